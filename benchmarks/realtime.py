"""How much faster than real time the default arm runs at 1 ms: ``python -m benchmarks.realtime``.

Writes benchmarks/results/realtime.json. Each row is one integrator under one kind of input: times
real time (simulated s per CPU s, in calls that advance to the next change of the torques, or by 10
ms; the best of some runs), wall time of single steps (every step a call of its own, as a controller
makes them), work per step, and the error of the tip: the largest distance over the run, looked at
every 10 ms or more often, from a run of the same discretisation in space with steps four times
smaller of a method of fourth order, over the length of the arm. So no speed stands without its
error; that of the discretisation in space is not in it (docs/benchmarks.md has it).

Wall times of single steps are also those of whoever else uses the machine: beside them stands how
many steps of those over 1 ms were interrupted, seen by the CPU time of the process being less than
half of the wall time.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import Scene, load_scene, parse_scene

from . import machine

FILE = Path(__file__).parent / "results" / "realtime.json"
STEP = 0.001  # s
SPEED_BAR, STEP_BAR_US = 50.0, 1000.0
REFINED, REFINED_METHOD = 4, "sdirk4"
INTEGRATORS = ("sdirk2", "generalized_alpha", "implicit_midpoint", "sdirk3")
SHARE = 0.5  # of the torques' limits that is used
LOOK = 10  # steps of 1 ms after which the tip is looked at, at the latest
REPEATS = 4


@dataclass(frozen=True)
class Input:
    """Torques that are held for ``hold`` steps of 1 ms: rows (k, A) in parts of the limits."""

    name: str
    hold: int
    torques: Callable[[int, int], Floats]


def _random(count: int, actuators: int) -> Floats:
    return np.random.default_rng(1).uniform(-1.0, 1.0, (count, actuators))


def _chirp(count: int, actuators: int) -> Floats:
    """Return sines from 0.2 to 10 Hz, a phase apart, that are held for 4 ms as the node does."""
    t = np.linspace(0.0, 1.0, count)[:, None]
    duration = 0.004 * count
    phase = 2.0 * np.pi * duration * (0.2 * t + 0.5 * 9.8 * t * t)
    return np.sin(phase + np.arange(actuators))


INPUTS = (
    Input("random torques every 1 s", 1000, _random),
    Input("random torques every 10 ms", 10, _random),
    Input("random torques every 100 ms", 100, _random),
    Input("chirp to 10 Hz, held for 4 ms", 4, _chirp),
)


def arm(**numerics: Any) -> Simulation:
    """Return the default arm with some of its numerics exchanged."""
    return Simulation(scene_with(arm_numerics() | numerics))


def arm_numerics() -> dict[str, Any]:
    """Return the numerics of the default arm as they are written."""
    found: dict[str, Any] = yaml.safe_load(load_scene("soft_arm").source)["numerics"]
    return found


def scene_with(numerics: dict[str, Any]) -> Scene:
    """Return the default arm with other numerics."""
    document = yaml.safe_load(load_scene("soft_arm").source)
    document["numerics"] = numerics
    return parse_scene(yaml.safe_dump(document), "soft_arm.yaml")


def program(given: Input, simulation: Simulation, duration: float, share: float = SHARE) -> Floats:
    """Return the torques (k, A) in N·m of a run, up to ``share`` of their limits."""
    high = np.array([actuator.limits[1] for actuator in simulation.scene.actuators])
    count = round(duration / (given.hold * STEP))
    return share * high * given.torques(count, len(high))


def whole(
    simulation: Simulation, torques: Floats, hold: int, parts: int = 1
) -> tuple[float, Floats]:
    """Run from change to change; return the CPU time in s in those calls and the tips (k, 3).

    The step is 1 ms / ``parts``.
    """
    simulation.reset()
    sampler = simulation.sampler(2)
    pieces, steps = max(1, hold // LOOK), min(hold, LOOK) * parts
    spent, tips = 0, []
    for row in torques:
        for piece in range(pieces):
            begin = time.process_time_ns()
            if piece == 0:
                simulation.set_efforts(row)
            simulation.advance(steps)
            spent += time.process_time_ns() - begin
            tips.append(sampler.poses()[-1, :3].copy())
    return spent * 1e-9, np.array(tips)


def single(simulation: Simulation, torques: Floats, steps: int) -> tuple[Floats, Floats, Floats]:
    """Run step by step; return wall and CPU time (n,) in µs of every step, and its work (n, 2).

    The work is the number of evaluations and of factorisations.
    """
    simulation.reset()
    wall, cpu = np.empty((2, len(torques) * steps))
    work = np.empty((len(wall) + 1, 2))
    work[0] = simulation.statistics()[1:3]
    k = 0
    for row in torques:
        for i in range(steps):
            spent, begin = time.process_time_ns(), time.perf_counter_ns()
            if i == 0:
                simulation.set_efforts(row)
            simulation.advance(1)
            wall[k] = time.perf_counter_ns() - begin
            cpu[k] = time.process_time_ns() - spent
            k += 1
            work[k] = simulation.statistics()[1:3]
    return wall * 1e-3, cpu * 1e-3, np.diff(work, axis=0)


def parts(cpu: Floats, work: Floats) -> dict[str, float]:
    """Return what a step costs in µs by itself, and per evaluation and factorisation in it.

    A fit to the least time of all steps with the same work, which other programs disturb least; the
    more there are of a kind, the more it counts.
    """
    kinds, of, count = np.unique(work, axis=0, return_inverse=True, return_counts=True)
    least = np.array([cpu[of.ravel() == kind].min() for kind in range(len(kinds))])
    matrix = np.column_stack([np.ones(len(kinds)), kinds])
    cost = np.linalg.lstsq(matrix * count[:, None], least * count, rcond=None)[0]
    return dict(zip(("step", "evaluation", "factorisation"), cost.tolist(), strict=True))


def percentiles(values: np.ndarray) -> dict[str, float]:
    """Return the median, two high percentiles and the largest of some values (N,)."""
    names = ("p50", "p99", "p99.9", "max")
    found = np.percentile(values, (50, 99, 99.9, 100))
    return {name: float(value) for name, value in zip(names, found, strict=True)}


def measured(integrator: str, given: Input, duration: float, reference: Floats) -> dict[str, Any]:
    """Return one row."""
    simulation = arm(integrator=integrator, step=STEP)
    torques = program(given, simulation, duration)
    before = simulation.statistics()
    spent, tips = whole(simulation, torques, given.hold)
    after = simulation.statistics()
    best = min(spent, *(whole(simulation, torques, given.hold)[0] for _ in range(REPEATS - 1)))
    wall, cpu, work = single(simulation, torques, given.hold)
    steps = len(wall)
    over = wall > STEP_BAR_US
    return {
        "integrator": integrator,
        "input": given.name,
        "simulated_s": duration,
        "times_real_time": duration / best,
        "step_wall_us": percentiles(wall),
        "step_cpu_us": percentiles(cpu),
        "steps_over_1_ms": int(over.sum()),
        "of_them_interrupted": int((over & (cpu < 0.5 * wall)).sum()),
        "evaluations_per_step": (after.evaluations - before.evaluations) / steps,
        "factorisations_per_step": (after.factorisations - before.factorisations) / steps,
        "refused": after.refused - before.refused,
        "parts_us": parts(cpu, work),
        "error_rel": float(np.linalg.norm(tips - reference, axis=1).max() / simulation.length),
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Return the rows as a table in Markdown."""
    lines = [
        "| input | integrator | times real time | step, CPU p50 / p99.9 / max µs | "
        "wall p99.9 µs | evaluations, factors per step | error |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        cpu = " / ".join(f"{row['step_cpu_us'][key]:.0f}" for key in ("p50", "p99.9", "max"))
        lines.append(
            f"| {row['input']} | {row['integrator']} | {row['times_real_time']:.0f}× | {cpu} | "
            f"{row['step_wall_us']['p99.9']:.0f} | "
            f"{row['evaluations_per_step']:.1f}, {row['factorisations_per_step']:.2f} | "
            f"{row['error_rel']:.0e} |"
        )
    return "\n".join(lines)


def main() -> int:
    """Measure, tell, and keep."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.realtime", description=__doc__)
    parser.add_argument("--seconds", type=float, default=5.0, help="simulated, of every run")
    parser.add_argument("--integrators", nargs="*", default=INTEGRATORS)
    given = parser.parse_args()
    rows = []
    for one in INPUTS:
        refined = arm(integrator=REFINED_METHOD, step=STEP / REFINED)
        torques = program(one, refined, given.seconds)
        _, reference = whole(refined, torques, one.hold, REFINED)
        for integrator in given.integrators:
            arm(integrator=integrator, step=STEP).advance(1)  # compiles
            rows.append(measured(integrator, one, given.seconds, reference))
            print(json.dumps(rows[-1]), flush=True)
    print(table(rows))
    if set(given.integrators) == set(INTEGRATORS):
        kept = {
            "step_s": STEP,
            "speed_bar": SPEED_BAR,
            "p99.9_bar_us": STEP_BAR_US,
            "rows": rows,
            "machine": machine.facts(),
        }
        FILE.write_text(json.dumps(kept, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
