"""Cases as scenes of this package, and their timed runs."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.accuracy.contract import choose
from soft_sim_ros.core.accuracy.drive import Drive
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import Diverged, ToleranceMissed
from soft_sim_ros.scene import Scene, parse_scene

from ..cases import Case

AXES = {"y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 1.0]}


@dataclass(frozen=True)
class Run:
    """The tip (outputs, 3) in m of a run, its cost in s (wall and CPU), and how it ended.

    estimate, search : with a tolerance, the own estimate of the error over the length, and CPU s
        that choosing the numerics took
    """

    tip: np.ndarray
    wall: float
    coordinates: int
    outcome: str
    reason: str = ""
    counters: dict[str, int] | None = None
    cpu: float | None = None
    estimate: float | None = None
    search: float | None = None


def numerics(case: Case, settings: dict[str, Any]) -> dict[str, Any]:
    """Return the ``numerics`` block of the scene document.

    settings : either tolerance and step, and the simulation chooses the rest; or step, integrator,
    options, newton_tolerance, and kind, order (int, or by strain), elements and nodes of the basis
    """
    if "tolerance" in settings:
        return {key: settings[key] for key in ("tolerance", "step")}
    basis: dict[str, Any] = {
        "kind": settings.get("kind", "legendre"),
        "elements": settings.get("elements", 1),
    }
    if basis["kind"] not in ("constant", "linear"):
        order = settings["order"]
        basis["order"] = dict.fromkeys(strains_of(case, settings), order) if isinstance(
            order, int
        ) else order  # fmt: skip
    if "nodes" in settings:
        basis["nodes"] = settings["nodes"]
    return {
        "step": settings["step"],
        "integrator": settings.get("integrator", "sdirk2"),
        "newton_tolerance": settings.get("newton_tolerance", "auto"),
        "options": settings.get("options", {}),
        "basis": basis,
    }


def strains_of(case: Case, settings: dict[str, Any]) -> list[str]:
    """Return the free strains: the case's, or those of its plane if the settings say so."""
    return list(settings.get("strains", case.strains))


def document(case: Case, settings: dict[str, Any]) -> dict[str, Any]:
    """Return the scene document of a case."""
    names = [f"s{k}" for k in range(len(case.sections))]
    rod = {
        "rod": "rod",
        "strains": strains_of(case, settings),
        "sections": [
            {
                "name": name,
                "length": length,
                "material": "soft",
                "cross_section": {"shape": "circle", "radius": case.radius},
                "shear_correction": 1.0,
            }
            for name, length in zip(names, case.sections, strict=True)
        ],
    }
    out: dict[str, Any] = {
        "name": case.name,
        "gravity": list(case.gravity),
        "materials": {
            "soft": {
                "young_modulus": case.young,
                "shear_modulus": case.shear,
                "density": case.density,
                "viscosity": case.viscosity,
            }
        },
        "bodies": [rod],
        "numerics": numerics(case, settings),
    }
    if case.hinge:
        out["bodies"].insert(0, {"joint": "hinge", "kind": "revolute", "axis": AXES[case.hinge]})
    if any(case.offset):
        offsets = dict(zip(("torsion", "bend_y", "bend_z"), case.offset, strict=False))
        out["initial"] = {"strains": {f"rod/{name}": offsets for name in names}}
    if case.moments:
        out["actuators"] = [
            {"moment": f"m{k}", "rod": "rod", "section": names[section], "strain": strain}
            for k, (section, strain) in enumerate(case.moments.channels)
        ]
    if case.tendon:
        path = {"from": list(case.tendon.start), "to": list(case.tendon.end)}
        out["actuators"] = [{"tendon": "tendon", "rod": "rod", "offset": path}]
    if case.hub:
        axis = np.array(AXES[case.hinge or "z"]) * case.hub.value
        out["loads"] = [
            {
                "point": "hub",
                "body": "hinge",
                "moment": axis.tolist(),
                "schedule": {"start": 0.0, "end": case.hub.end, "ramp": case.hub.ramp},
            }
        ]
    return out


def scene_of(case: Case, settings: dict[str, Any]) -> Scene:
    """Return the scene of a case."""
    return parse_scene(yaml.safe_dump(document(case, settings)), f"{case.name}.yaml")


def steps_in(span: float, step_ns: int) -> int:
    """Return how many steps make up a span of time in s; refuse a step that does not divide it."""
    steps, rest = divmod(round(span * 1e9), step_ns)
    if rest:
        raise ValueError(f"a step of {step_ns} ns does not divide {span} s")
    return steps


def follow(case: Case, simulation: Simulation) -> np.ndarray:
    """Run a case to its end; return the tip (outputs, 3)."""
    tip = np.zeros((case.outputs, 3))
    sampler = simulation.sampler(2)
    per_output = steps_in(case.output_period, simulation.step_ns)
    if case.tendon:
        simulation.set_efforts([case.tendon.tension])
    held = case.moments
    per_command = steps_in(held.period, simulation.step_ns) if held else 0
    start = simulation.step_index
    for k in range(case.outputs):
        goal = start + (k + 1) * per_output
        while simulation.step_index < goal:
            until = goal
            if held:
                row, into = divmod(simulation.step_index - start, per_command)
                if into == 0:
                    simulation.set_efforts(held.values[row])
                until = min(goal, simulation.step_index + per_command - into)
            simulation.advance(until - simulation.step_index)
        tip[k] = sampler.poses()[-1, :3]
    return tip


def drive_of(case: Case, step_ns: int) -> Drive:
    """Return the commands of a case and the instants at which its tip is compared."""
    every = steps_in(case.output_period, step_ns)
    starts, rows = np.zeros(0, dtype=np.int64), np.zeros((0, 0))
    if case.moments:
        rows = np.array(case.moments.values)
        starts = np.arange(len(rows)) * steps_in(case.moments.period, step_ns)
    elif case.tendon:
        starts, rows = np.zeros(1, dtype=np.int64), np.array([[case.tendon.tension]])
    return Drive(starts, rows, case.outputs * every, every)


def run(case: Case, settings: dict[str, Any], repeats: int = 5, patience: float = 2.0) -> Run:
    """Run a case; the cost is the best of up to ``repeats`` runs within ``patience`` s.

    Building the simulation is not counted, neither here nor for the peers. CPU time is that of this
    thread: another one may be reading what a peer says.
    """
    scene = scene_of(case, settings)
    estimate, search = None, None
    if "tolerance" in settings:
        begin_cpu = time.thread_time()
        try:
            choice = choose(scene, drive_of(case, round(scene.numerics.step * 1e9)))
        except ToleranceMissed as missed:
            return Run(np.zeros((0, 3)), 0.0, 0, "refused", str(missed), estimate=missed.estimate)
        scene, estimate = choice.scene, choice.estimate
        search = time.thread_time() - begin_cpu
    best, cpu, spent, tip = np.inf, np.inf, 0.0, np.zeros((0, 3))
    simulation = Simulation(scene)
    with suppress(Diverged):  # the timed run will say so
        simulation.advance(1)  # compiles what has not been compiled yet
    for _ in range(repeats):
        simulation = Simulation(scene)
        begin, begin_cpu = time.perf_counter(), time.thread_time()
        try:
            tip = follow(case, simulation)
        except Diverged as reason:
            wall = time.perf_counter() - begin
            return Run(tip, wall, simulation.n_coordinates, "refused", str(reason))
        wall = time.perf_counter() - begin
        cpu = min(cpu, time.thread_time() - begin_cpu)
        best, spent = min(best, wall), spent + wall
        if spent > patience:
            break
    counters = simulation.statistics()._asdict()
    return Run(
        tip, best, simulation.n_coordinates, "completed", "", counters, cpu, estimate, search
    )
