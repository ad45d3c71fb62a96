"""Fail where a step costs more than it did: ``python -m benchmarks.guard [--update]``.

Times are compared with a yardstick of compiled scalar arithmetic that runs in turn with them, so
that what is stored, benchmarks/results/guard.json, are ratios and fit any machine. Counts of
evaluations and factorisations are stored too: they have no noise at all. What is slower than
ALLOWED times its baseline is measured again, several times, before it is believed.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numba
import numpy as np
import yaml

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.scene import load_scene, parse_scene

from . import machine

FILE = Path(__file__).parent / "results" / "guard.json"
ALLOWED = 1.5
ROUNDS = 15
ATTEMPTS = 4
Function = Callable[[], object]


@numba.njit(error_model="numpy", cache=True)
def _rotations(count, matrix, out):
    """Multiply 3x3 matrices one after the other, as the recursion over a chain does."""
    for _ in range(count):
        for i in range(3):
            for j in range(3):
                total = 0.0
                for k in range(3):
                    total += out[i, k] * matrix[k, j]
                matrix[i, j] = 0.5 * (matrix[i, j] + total)
        for i in range(3):
            for j in range(3):
                matrix[i, j] /= 1.0 + abs(matrix[i, j])


def yardstick() -> Function:
    """Return the work that everything is compared with, about half a millisecond."""
    matrix, turn = np.eye(3), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    _rotations(1, matrix, turn)
    return lambda: _rotations(10_000, matrix, turn)


@dataclass(frozen=True)
class Work:
    """Something to be timed, and a count of what it does that has no noise."""

    run: Function
    count: Callable[[], dict[str, float]] = dict


def stepping(simulation: Simulation, steps: int) -> Work:
    """Return the first steps of a simulation under constant efforts."""

    def run() -> None:
        simulation.reset()
        simulation.set_efforts(efforts)
        simulation.advance(steps)

    def count() -> dict[str, float]:
        before = simulation.statistics()
        run()
        after = simulation.statistics()
        return {
            "evaluations": (after.evaluations - before.evaluations) / steps,
            "factorisations": (after.factorisations - before.factorisations) / steps,
        }

    limits = [actuator.limits[1] for actuator in simulation.scene.actuators]
    efforts = np.array([0.25 * limit if np.isfinite(limit) else 0.1 for limit in limits])
    return Work(run, count)


def works() -> dict[str, Work]:
    """Return everything that is guarded."""
    arm = Simulation(load_scene("soft_arm"))
    telemetry = Telemetry(arm, 51, "world", "/guard")
    build = [getattr(telemetry, topic.key) for topic in telemetry.topics]
    document = yaml.safe_load(load_scene("cantilever").source)
    document["numerics"] = {"step": 0.002, "basis": {"order": 1, "elements": 100}}
    long = Simulation(parse_scene(yaml.safe_dump(document), "long.yaml"))
    start = np.zeros(arm.n_coordinates)

    def messages() -> None:
        arm.advance(1)
        for message in build:
            message()

    return {
        "soft_arm, 50 steps": stepping(arm, 50),
        "tendon_arm, 50 steps": stepping(Simulation(load_scene("tendon_arm")), 50),
        "flexible_manipulator, 50 steps": stepping(
            Simulation(load_scene("flexible_manipulator")), 50
        ),
        "100 elements, 3 steps": stepping(long, 3),
        "equilibrium of soft_arm": Work(lambda: equilibrium(arm.dynamics, start)),
        "all messages and a step": Work(messages),
    }


def measured(guarded: dict[str, Work], rounds: int = ROUNDS) -> dict[str, dict[str, float]]:
    """Return for each work its time over that of the yardstick, and its counts.

    The least of many rounds in turn: what disturbs a run only ever makes it longer.
    """
    unit = yardstick()
    functions = {"": unit} | {name: work.run for name, work in guarded.items()}
    best = dict.fromkeys(functions, np.inf)
    for _ in range(rounds):
        for name, function in functions.items():
            begin = time.process_time()
            function()
            best[name] = min(best[name], time.process_time() - begin)
    return {
        name: {"time": float(best[name] / best[""])} | work.count()
        for name, work in guarded.items()
    }


def worse(
    now: dict[str, dict[str, float]], before: dict[str, dict[str, float]]
) -> dict[str, dict[str, float]]:
    """Return work → quantity → how many times its baseline, where that is more than ALLOWED."""
    found: dict[str, dict[str, float]] = {}
    for name, values in now.items():
        known = before.get(name, {})
        ratios = {key: value / known[key] for key, value in values.items() if known.get(key)}
        over = {key: ratio for key, ratio in ratios.items() if ratio > ALLOWED}
        if over:
            found[name] = over
    return found


def main() -> int:
    """Measure, compare, tell."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.guard", description=__doc__)
    parser.add_argument("--update", action="store_true", help="make this the baseline")
    given = parser.parse_args()
    begin = time.monotonic()
    guarded = works()
    for work in guarded.values():
        work.run()  # compiles the kernels, once
    now = measured(guarded)
    if given.update:
        stored = {"works": now, "machine": machine.facts()}
        FILE.write_text(json.dumps(stored, indent=1) + "\n")
    before = json.loads(FILE.read_text())["works"]
    for _ in range(ATTEMPTS - 1):
        if not (slow := worse(now, before)):
            break
        again = measured({name: guarded[name] for name in slow})
        for name, values in again.items():
            now[name] = {key: min(value, now[name][key]) for key, value in values.items()}
    slow = worse(now, before)
    for name, values in now.items():
        told = ", ".join(f"{key} {value:.3g}" for key, value in values.items())
        print(f"{'SLOWER' if name in slow else 'ok':6} {name:32} {told}")
    for name, ratios in slow.items():
        print(f"{name}: " + ", ".join(f"{ratio:.2f} times the {k}" for k, ratio in ratios.items()))
    missing = sorted(set(now) ^ set(before))
    if missing:
        print(f"no baseline, or nothing to compare it with (--update): {', '.join(missing)}")
    print(f"guard: {time.monotonic() - begin:.0f} s")
    return 1 if slow or missing else 0


if __name__ == "__main__":
    sys.exit(main())
