"""How the rate of runs grows with processes: ``python -m benchmarks.batch``.

The same batch with one process and with more, in turn, several times; medians and their ratio go to
benchmarks/results/batch.json. Starting the processes is part of the time. A machine with other work
cannot give more than it has left: as a yardstick, as many tasks of nothing but arithmetic, about as
long as a run, go through the same processes in turn with the batches.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import tempfile
import time
from pathlib import Path

from soft_sim_ros.batch import Run, run_batch
from soft_sim_ros.batch.workers import cores, in_processes
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import load_scene

from . import machine
from .guard import yardstick

FILE = Path(__file__).parent / "results" / "batch.json"
PER_CORE = 24  # runs


def runs(count: int, duration: float) -> list[Run]:
    """Return equal amounts of work: the default arm with slightly different stiffnesses."""
    scene = load_scene("soft_arm")
    key = "materials.silicone.young_modulus"
    return [
        Run(scene.file, scene.source, duration, {key: repr(7e5 * (1.0 + 1e-4 * k))})
        for k in range(count)
    ]


def measured(work: list[Run], jobs: int) -> float:
    """Return the wall time in s of a batch."""
    with tempfile.TemporaryDirectory() as out:
        begin = time.perf_counter()
        results = run_batch(work, out, jobs=jobs)
        seconds = time.perf_counter() - begin
    assert all(result["outcome"] == "completed" for result in results)
    return seconds


def burn(units: int) -> None:
    """Do arithmetic."""
    work = yardstick()
    for _ in range(units):
        work()


def burnt(count: int, units: int, jobs: int) -> float:
    """Return the wall time in s of as many tasks of arithmetic."""
    begin = time.perf_counter()
    list(in_processes(burn, [(units,)] * count, jobs))
    return time.perf_counter() - begin


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.batch", description=__doc__)
    parser.add_argument("--duration", type=float, default=10.0, help="simulated s of a run")
    parser.add_argument("--repeats", type=int, default=3)
    given = parser.parse_args()
    load = os.getloadavg()[0]
    Simulation(load_scene("soft_arm")).advance(1)  # compiles the kernels, once
    counts = sorted({1, *(n for n in (2, 4, 8, 16, 32) if n < cores()), cores()})
    work = runs(PER_CORE * cores(), given.duration)
    with tempfile.TemporaryDirectory() as out:
        seconds = run_batch(work[:1], out, jobs=1)[0]["wall_s"]
    burn(1)  # compiles
    begin = time.perf_counter()
    burn(100)
    units = max(1, round(100 * seconds / (time.perf_counter() - begin)))
    walls: dict[tuple[str, int], list[float]] = {}
    for _ in range(given.repeats):
        for jobs in counts:
            walls.setdefault(("runs", jobs), []).append(measured(work, jobs))
            walls.setdefault(("arithmetic", jobs), []).append(burnt(len(work), units, jobs))
            last = {key: times[-1] for (key, n), times in walls.items() if n == jobs}
            told = ", ".join(f"{key} {seconds:.1f} s" for key, seconds in last.items())
            print(f"{len(work)} tasks with {jobs} processes: {told}", flush=True)
    median = {key: statistics.median(times) for key, times in walls.items()}
    rows = []
    for jobs in counts:
        wall = median["runs", jobs]
        speedup = median["runs", 1] / wall
        possible = median["arithmetic", 1] / median["arithmetic", jobs]
        rows.append(
            {
                "processes": jobs, "runs": len(work), "wall_s": wall,
                "runs_per_s": len(work) / wall,
                "speedup": speedup, "speedup_of_arithmetic": possible,
                "of_what_is_possible": speedup / possible,
            }
        )  # fmt: skip
        print(f"{jobs} processes: {speedup:.2f} times the rate of one; arithmetic {possible:.2f}")
    facts = machine.facts() | {"load_before": load}
    FILE.write_text(json.dumps({"rows": rows, "machine": facts}, indent=1) + "\n")


if __name__ == "__main__":
    main()
