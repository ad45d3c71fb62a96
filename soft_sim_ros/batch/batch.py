"""Make all runs of a batch that are not made yet."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from soft_sim_ros.batch.dask import on_dask
from soft_sim_ros.batch.run import Run, execute
from soft_sim_ros.batch.table import write_tables
from soft_sim_ros.batch.workers import cores, in_processes
from soft_sim_ros.endings import undisturbed

Progress = Callable[[int, int, dict[str, Any] | None], None]


def run_batch(
    runs: Sequence[Run],
    out: str | Path,
    *,
    jobs: int | None = None,
    dask: str | None = None,
    progress: Progress = lambda done, total, result: None,
) -> list[dict[str, Any]]:
    """Make the runs that are not made yet; return all results, in the order of ``runs``.

    Every run has a directory of its own in ``out``, named after a digest of everything that affects
    the result. One whose directory holds the result of this very run is not made again, so a batch
    that was killed goes on where it was. What a killed run has recorded is kept beside it, as
    ``NAME.torn-1``, for ``recover``.

    Parameters
    ----------
    runs : equal ones are made once
    out : folder, made if it is missing; with Dask, every machine must see it by this name
    jobs : processes; one per core unless told
    dask : address of a Dask scheduler, or ``local``
    progress : called with (runs done, runs in all, result of the last or None)

    Returns
    -------
    list of dict
        also in ``results.json`` and ``results.csv``, written when all is done or interrupted. A
        run that failed has the name of its error as ``outcome`` and its words as ``reason``; the
        others go on.
    """
    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    every = {run.name: run for run in runs}
    results: dict[str, dict[str, Any]] = {}
    for name, run in every.items():
        if (made := run.done(out)) is not None:
            results[name] = made | run.described()  # the same numbers may have another seed
    due = [run for name, run in every.items() if name not in results]
    progress(len(results), len(every), None)
    # a path that means the same elsewhere
    tasks = [(run, str(out.resolve())) for run in due]
    answers = (
        in_processes(execute, tasks, min(jobs or cores(), len(tasks)))
        if dask is None
        else on_dask(execute, tasks, dask, jobs)
    )
    names = [run.name for run in runs]
    try:
        for number, answer in answers:
            run = due[number]
            if isinstance(answer, BaseException):
                answer = run.described() | {
                    "outcome": type(answer).__name__, "reason": str(answer), "final": False,
                }  # fmt: skip
            results[run.name] = answer
            progress(len(results), len(every), answer)
    finally:
        with undisturbed():
            answers.close()  # type: ignore[attr-defined]  # both are generators
            write_tables([results[name] for name in names if name in results], out)
    return [results[name] for name in names]
