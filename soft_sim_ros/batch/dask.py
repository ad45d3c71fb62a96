"""Runs of a batch on many machines, by Dask."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from typing import Any

from soft_sim_ros.batch.workers import ONE_THREAD, WorkerDied, cores
from soft_sim_ros.errors import SoftSimError

LOCAL = "local"


class NoDask(SoftSimError):
    """Dask is not installed, or no scheduler answers at the address."""

    def __init__(self, why: str) -> None:
        super().__init__(why)
        self.why = why

    def __str__(self) -> str:
        return self.why


def on_dask(
    function: Callable[..., Any], tasks: Iterable[tuple], address: str, jobs: int | None = None
) -> Iterator[tuple[int, Any]]:
    """Call ``function(*task)`` on the workers of a Dask scheduler; yield as ``in_processes`` does.

    Parameters
    ----------
    address : of the scheduler, such as ``tcp://host:8786``; ``local`` starts one for this call,
        with ``jobs`` workers, one per core unless told

    Raises
    ------
    NoDask
        without Dask, or where no scheduler answers
    """
    try:
        dask, distributed = import_module("dask"), import_module("distributed")
    except ImportError as error:
        raise NoDask(
            f"runs on many machines need Dask, which cannot be imported ({error}): "
            "pip install 'soft_sim_ros[batch]'"
        ) from error
    cluster = None
    if address == LOCAL:
        settings = {"distributed.nanny.pre-spawn-environ": ONE_THREAD}
        with dask.config.set(settings):
            cluster = distributed.LocalCluster(
                n_workers=jobs or cores(), threads_per_worker=1, dashboard_address=None
            )
    try:
        try:
            client = distributed.Client(cluster or address, timeout=10)
        except (OSError, ValueError) as error:
            raise NoDask(f"no Dask scheduler answers at {address}: {error}") from error
        with client:
            # a run that kills its worker would kill the next one too
            futures = {
                client.submit(function, *task, pure=False, retries=0): number
                for number, task in enumerate(tasks)
            }
            for future in distributed.as_completed(futures):
                failure = future.exception()
                if isinstance(failure, distributed.scheduler.KilledWorker):
                    failure = WorkerDied(str(failure))
                yield futures[future], future.result() if failure is None else failure
    finally:
        if cluster is not None:
            cluster.close()
