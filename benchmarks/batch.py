"""How the rate of runs grows with processes: ``python -m benchmarks.batch``.

The same batch with one process and with more, in turn, several times; medians and their ratio go to
benchmarks/results/batch.json. Starting the processes is part of the time.
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
from soft_sim_ros.batch.workers import cores
from soft_sim_ros.core.simulation import Simulation
from soft_sim_ros.scene import load_scene

from . import machine

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


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.batch", description=__doc__)
    parser.add_argument("--duration", type=float, default=20.0, help="simulated s of a run")
    parser.add_argument("--repeats", type=int, default=3)
    given = parser.parse_args()
    load = os.getloadavg()[0]
    Simulation(load_scene("soft_arm")).advance(1)  # compiles the kernels, once
    counts = sorted({1, *(n for n in (2, 4, 8, 16, 32) if n < cores()), cores()})
    work = runs(PER_CORE * cores(), given.duration)
    walls: dict[int, list[float]] = {jobs: [] for jobs in counts}
    for _ in range(given.repeats):
        for jobs in counts:
            walls[jobs].append(measured(work, jobs))
            print(f"{len(work)} runs with {jobs} processes: {walls[jobs][-1]:.2f} s", flush=True)
    median = {jobs: statistics.median(times) for jobs, times in walls.items()}
    rows = [
        {
            "processes": jobs, "runs": len(work), "wall_s": median[jobs],
            "runs_per_s": len(work) / median[jobs],
            "speedup": median[1] / median[jobs], "efficiency": median[1] / median[jobs] / jobs,
        }
        for jobs in counts
    ]  # fmt: skip
    for row in rows:
        print(f"{row['processes']} processes: {row['speedup']:.2f} times the rate of one")
    facts = machine.facts() | {"load_before": load}
    FILE.write_text(json.dumps({"rows": rows, "machine": facts}, indent=1) + "\n")


if __name__ == "__main__":
    main()
