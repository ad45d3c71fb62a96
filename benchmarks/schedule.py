"""Who runs when: this package on the first core, its peers on the others, then peers on all.

A job is one program on one case. Nothing else runs on a core while a job does, and this package
has the first one for itself, so what is timed is one program on one core.
"""

from __future__ import annotations

import json
import os
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from .reference import RESULTS

FILE = RESULTS / "costs.json"
OURS = "soft_sim_ros"
# CPU s of a job that has never run
UNKNOWN = {OURS: 10.0, "pyelastica": 150.0, "soromox": 170.0, "exudyn": 30.0, "mujoco": 35.0}


@dataclass(frozen=True)
class Job:
    """One program on one case."""

    program: str
    case: str


class Costs:
    """CPU s that every job took, kept from run to run: they tell when a run will end."""

    def __init__(self) -> None:
        rows = json.loads(FILE.read_text()) if FILE.is_file() else []
        self._kept = {Job(row["program"], row["case"]): float(row["cpu_s"]) for row in rows}

    def of(self, job: Job) -> float:
        """Return what a job is expected to cost in CPU s."""
        return self._kept.get(job, UNKNOWN[job.program])

    def keep(self, job: Job, cpu: float) -> None:
        """Write down what a job took."""
        self._kept[job] = cpu
        rows = [
            {"program": j.program, "case": j.case, "cpu_s": round(c, 1)}
            for j, c in self._kept.items()
        ]
        FILE.write_text(json.dumps(rows, indent=1) + "\n")


def cores() -> list[int]:
    """Return the numbers of the cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return [0]


def pin(core: int) -> None:
    """Keep this thread, and the processes it will start, on one core."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {core})


def work(jobs: list[Job], run: Callable[[Job], float], on: list[int]) -> None:
    """Run all jobs; ``run`` returns CPU s. An exception in any job ends them all.

    Jobs of this package run in this thread, on the first core. Peers are child processes, started
    by one thread per core, the longest first.
    """
    costs, lock, begin = Costs(), threading.Lock(), time.monotonic()
    mine = [job for job in jobs if job.program == OURS]
    theirs = sorted((job for job in jobs if job.program != OURS), key=costs.of, reverse=True)
    running: dict[int, Job] = {}
    failures: list[BaseException] = []

    def left() -> float:
        known = [costs.of(job) for job in (*mine, *theirs, *running.values())]
        return max([sum(known) / len(on), *known])

    def drain(waiting: list[Job], core: int) -> None:
        while True:
            with lock:
                if failures or not waiting:
                    return
                job = running[core] = waiting.pop(0)
                spent = time.monotonic() - begin
                print(f"[{spent / 60:.1f} min, about {left() / 60:.0f} min to go] core "
                      f"{core}: {job.program} on {job.case}", flush=True)  # fmt: skip
            cpu = run(job)
            with lock:
                del running[core]
                costs.keep(job, cpu)

    def other(core: int) -> None:
        try:
            pin(core)
            drain(theirs, core)
        except BaseException as failure:
            failures.append(failure)

    threads = [threading.Thread(target=other, args=(core,)) for core in on[1:]]
    pin(on[0])
    for thread in threads:
        thread.start()
    try:
        drain(mine, on[0])
        drain(theirs, on[0])
    except BaseException as failure:
        failures.append(failure)
    for thread in threads:
        thread.join()
    if failures:
        raise failures[0]
