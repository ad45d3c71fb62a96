"""What a feature costs a scene that does not use it: ``python -m benchmarks.skip``.

Writes benchmarks/results/skip.json. A further feature is a further row of FEATURES.

For every feature three scenes are stepped in turn, many times, and medians of the CPU time per
evaluation of the equations of motion (solving with the tangent included) are kept: the smallest
scene there is (baseline), the scene without the feature (absent), and with it (present). Where the
feature can be present without effect (a force of 1e-300 N), the equations with and without it are
compared at random states: the code that was skipped must not have had anything to say.
"""

from __future__ import annotations

import argparse
import copy
import json
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.scene import parse_scene
from soft_sim_ros.scene.constraint import CONSTRAINT_KINDS, WITH_AXIS

from . import machine

FILE = Path(__file__).parent / "results" / "skip.json"
NOTHING = 1e-300  # so little that it changes no digit, but not zero
PLANE = ["bend_z", "stretch", "shear_y"]
ALL = ["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"]
Document = dict[str, Any]
Cost = Callable[[], float]


def smallest() -> Document:
    """Return the scene with nothing in it: a clamped rod that vibrates in its plane."""
    return {
        "gravity": [0.0, 0.0, 0.0],
        "materials": {"m": {"young_modulus": 1e6, "poisson_ratio": 0.45, "density": 1000.0}},
        "bodies": [
            {
                "rod": "rod",
                "strains": PLANE,
                "sections": [
                    {
                        "name": "s",
                        "length": 0.5,
                        "material": "m",
                        "cross_section": {"shape": "circle", "radius": 0.02},
                    }
                ],
            }
        ],
        "initial": {"strains": {"rod/s": {"bend_z": 1.0}}},
        "numerics": {"step": 0.001, "basis": {"order": 3, "elements": 4}},
    }


@dataclass(frozen=True)
class Feature:
    """One row: how a scene gets the feature, and what it is without.

    Parameters
    ----------
    add : puts the feature into a scene, with a size; NOTHING is a feature without effect
    size : of the feature
    efforts : whether size is an effort of the actuator that is added, not a number of the scene
    silent : whether the feature can be there without effect
    """

    name: str
    add: Callable[[Document, float], None]
    size: float = 1.0
    efforts: bool = False
    silent: bool = True


def _gravity(scene: Document, size: float) -> None:
    scene["gravity"] = [0.0, -size, 0.0]


def _material(**values: Callable[[float], Any]) -> Callable[[Document, float], None]:
    def add(scene: Document, size: float) -> None:
        scene["materials"]["m"] |= {key: value(size) for key, value in values.items()}

    return add


def _law(scene: Document, size: float) -> None:
    scene["materials"]["m"] = {"law": {"kind": "neo_hookean", "c10": 1e6 / 6.0}, "density": 1000.0}


def _section(**keys: Callable[[float], Any]) -> Callable[[Document, float], None]:
    def add(scene: Document, size: float) -> None:
        scene["bodies"][0]["sections"][0] |= {key: value(size) for key, value in keys.items()}

    return add


def _string(scene: Document, size: float) -> None:
    scene["bodies"][0] |= {"model": "string", "strains": ["bend_z"]}


def _load(**keys: Any) -> Callable[[Document, float], None]:
    def add(scene: Document, size: float) -> None:
        scene.setdefault("loads", []).append(keys | {"force": [0.0, size, 0.0]})

    return add


def _actuator(**keys: Any) -> Callable[[Document, float], None]:
    def add(scene: Document, size: float) -> None:
        scene.setdefault("actuators", []).append(keys)

    return add


def _body(first: bool, **keys: Any) -> Callable[[Document, float], None]:
    def add(scene: Document, size: float) -> None:
        least = max(size, 1e-60)  # what scenes take for a mass
        body = {key: least if value is None else value for key, value in keys.items()}
        scene["bodies"].insert(0 if first else len(scene["bodies"]), body)

    return add


def _link(scene: Document, size: float) -> None:
    # modes need some mass; this much changes no digit of what a rod does
    line = max(size, 1e-30)
    part = {
        "name": "s", "length": 0.2, "material": "m", "mass_per_length": line,
        "inertia_per_length": [2e-4 * line, 1e-4 * line, 1e-4 * line],
        "cross_section": {"shape": "circle", "radius": 0.02},
    }  # fmt: skip
    link = {"flexible_link": "link", "strains": ["bend_z"], "modes": 2, "sections": [part]}
    scene["bodies"].append(link)


def _fluid(scene: Document, size: float) -> None:
    scene["fluid"] = {"density": max(size, 1e-50), "current": [0.1, 0.2, 0.0]}


def _touch(height: float, friction: float) -> Callable[[Document, float], None]:
    """Let the rod fall on a plane at a height in m along y; below −1 it never does."""

    def add(scene: Document, size: float) -> None:
        law = {"friction": friction, "stiffness": 1e4}
        plane = {"plane": "floor", "position": [0.0, height, 0.0], "normal": [0.0, 1.0, 0.0]}
        scene["environment"] = [plane | {"contact": law}]

    return add


def _constraint(kind: str) -> Callable[[Document, float], None]:
    """Hold the end of the rod."""

    def add(scene: Document, size: float) -> None:
        frames: list[dict[str, Any]] = [{"body": "rod"}]
        if kind == "distance":
            frames.append({"world": {"position": [0.2, 0.3, 0.0]}})
        axis = {"axis": [0.0, 1.0, 0.0] if kind == "plane" else [0.0, 0.0, 1.0]}
        if kind in ("line", "slider"):
            axis = {"axis": [1.0, 0.0, 0.0]}
        one = {"name": "c", "kind": kind, "frames": frames}
        scene["constraints"] = [one | (axis if kind in WITH_AXIS else {})]

    return add


def _space(scene: Document, size: float) -> None:
    scene["bodies"][0]["strains"] = ALL


FEATURES = (
    Feature("gravity", _gravity, 9.81),
    Feature("viscosity", _material(viscosity=float), 100.0),
    Feature("Rayleigh damping", _material(rayleigh=lambda x: {"mass": x}), 0.5),
    Feature(
        "Maxwell branch", _material(maxwell=lambda x: {"ratio": max(x, 1e-60), "time": 0.1}), 0.5
    ),
    Feature("hyperelastic law", _law, silent=False),
    Feature(
        "formula along the rod",
        _section(cross_section=lambda x: {
            "shape": "circle", "radius": {"expression": f"0.02 + {x} * sin(9 * s)"}
        }), 0.002,
    ),
    Feature("curved reference", _section(reference=lambda x: {"curvature": [0, 0, x]}), 2.0),
    Feature("string instead of a beam", _string, silent=False),
    Feature("dead point load", _load(point="p", body="rod"), 0.1),
    Feature("dead distributed load", _load(distributed="d", body="rod"), 0.1),
    Feature("follower point load", _load(point="p", body="rod", frame="body"), 0.1),
    Feature("load that is over", _load(point="p", body="rod", schedule={"end": 1e-6}), 0.1),
    Feature("moment", _actuator(moment="a", rod="rod", section="s", strain="bend_z"), 0.05, True),
    Feature("tendon", _actuator(tendon="t", rod="rod", offset=[0.01, 0.0]), 1.0, True),
    Feature(
        "tendon with friction",
        _actuator(tendon="t", rod="rod", offset=[0.01, 0.0], friction=0.2), 1.0, True,
    ),
    Feature(
        "tendon of commanded length",
        _actuator(tendon="t", rod="rod", offset=[0.01, 0.0], control="length",
                  axial_stiffness=1e3), 0.01, True, silent=False,
    ),
    Feature(
        "chamber", _actuator(chamber="c", rod="rod", area=1e-4, offset=[0.01, 0.0]), 1e3, True
    ),
    Feature("fixed joint", _body(True, joint="j", kind="fixed")),
    Feature(
        "revolute joint",
        _body(True, joint="j", kind="revolute", axis=[0.0, 0.0, 1.0], stiffness=None), 10.0,
        silent=False,
    ),
    Feature("prismatic joint", _body(True, joint="j", kind="prismatic", axis=[1.0, 0.0, 0.0])),
    Feature(
        "universal joint",
        _body(True, joint="j", kind="universal", axes=[[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
    ),
    Feature("spherical joint", _body(True, joint="j", kind="spherical")),
    Feature("free base", _body(True, joint="j", kind="free")),
    Feature("floating-frame link", _link, 1.0),
    Feature(
        "stiffness between strains",
        _section(coupling=lambda x: {"bend_z": {"shear_y": x}}), 1.0,
    ),
    Feature("surrounding fluid", _fluid, 1000.0),
    Feature("shape out of reach", _touch(-9.0, 0.0)),
    Feature("contact", _touch(-0.0199, 0.0), silent=False),
    Feature("contact with friction", _touch(-0.0199, 0.5), silent=False),
    *(
        Feature(f"constraint: {kind}", _constraint(kind), silent=False)
        for kind in CONSTRAINT_KINDS
    ),
    Feature("rigid body at the tip", _body(False, rigid_body="b", mass=None), 0.1),
    Feature("strains out of the plane", _space),
)  # fmt: skip


def simulation_of(document: Document) -> Simulation:
    """Return the simulation of a document."""
    return Simulation(parse_scene(yaml.safe_dump(document), "skip.yaml"))


def with_feature(feature: Feature, size: float) -> Document:
    """Return the smallest scene with a feature of some size."""
    document = copy.deepcopy(smallest())
    feature.add(document, size)
    return document


def stepping(simulation: Simulation, effort: float = 0.0, steps: int = 60) -> Cost:
    """Return a function that makes steps from the start; its cost in s per evaluation."""

    def cost() -> float:
        simulation.reset()
        simulation.set_efforts(np.full(simulation.n_actuators, effort))
        before = simulation.statistics().evaluations
        begin = time.process_time()
        simulation.advance(steps)
        seconds = time.process_time() - begin
        return seconds / (simulation.statistics().evaluations - before)

    return cost


def calling(function: Callable[[], object], times: int = 200) -> Cost:
    """Return a function that calls another many times; its cost in s per call."""

    def cost() -> float:
        begin = time.process_time()
        for _ in range(times):
            function()
        return (time.process_time() - begin) / times

    return cost


def interleaved(costs: dict[str, Cost], rounds: int) -> dict[str, float]:
    """Return the median costs in µs of functions called in turn."""
    found: dict[str, list[float]] = {key: [] for key in costs}
    for _ in range(rounds):
        for key, cost in costs.items():
            found[key].append(cost())
    return {key: 1e6 * statistics.median(values[1:] or values) for key, values in found.items()}


def difference(feature: Feature) -> float | None:
    """Return the largest relative difference of residual and tangents without and with."""
    if not feature.silent:
        return None
    without = Dynamics(simulation_of(smallest()).scene)
    size = feature.size if feature.efforts or feature.name == "load that is over" else NOTHING
    beside = Dynamics(simulation_of(with_feature(feature, size)).scene)
    names = beside.compiled.coordinate_names
    shared = [names.index(name) for name in without.compiled.coordinate_names]
    efforts = np.full(beside.actuators, NOTHING)
    rng, worst = np.random.default_rng(1), 0.0
    for _ in range(5):
        states = 0.02 * rng.normal(size=(3, without.n)) / without.model.weight
        wide = np.zeros((3, beside.n))
        wide[:, shared] = states
        pairs = [(without.inverse_dynamics(*states, time=1.0),
                  beside.inverse_dynamics(*wide, efforts, time=1.0)[shared])]  # fmt: skip
        fine, full = without.tangents(*states, time=1.0), beside.tangents(*wide, efforts, time=1.0)
        pairs += [(a, b[np.ix_(shared, shared)]) for a, b in zip(fine, full, strict=True)]
        worst = max(worst, *(relative(a, b) for a, b in pairs))
    return worst


def relative(a: Floats, b: Floats) -> float:
    """Return the largest difference over the largest entry."""
    size = float(np.abs(a).max())
    return float(np.abs(a - b).max()) / size if size else float(np.abs(b).max())


def stepped(feature: Feature, rounds: int) -> dict[str, Any]:
    """Measure a feature of scenes."""
    present = simulation_of(with_feature(feature, feature.size))
    costs = interleaved(
        {
            "baseline": stepping(simulation_of(smallest())),
            "absent": stepping(simulation_of(smallest())),
            "present": stepping(present, feature.size if feature.efforts else 0.0),
        },
        rounds,
    )
    return entry(feature.name, costs, difference(feature))


def served(rounds: int) -> list[dict[str, Any]]:
    """Measure what is built for listeners only: per step, with the Python around it."""
    simulation = simulation_of(smallest())
    telemetry = Telemetry(simulation, 51, "world", "/skip")
    build = [getattr(telemetry, topic.key) for topic in telemetry.topics]
    posed = ("backbone", "tip_pose")  # one sampling serves both
    lean = [b for b, t in zip(build, telemetry.topics, strict=True) if t.key not in posed]

    def step(builders: list[Callable[[], object]]) -> Callable[[], None]:
        def run() -> None:
            simulation.advance(1)
            for builder in builders:
                builder()

        return run

    simulation.set_state(0.0 * simulation.q, simulation.v)  # at rest: every step costs the same
    kinds = {"none": [], "nobody": [], "lean": lean, "unposed": lean, "all": build}
    found = interleaved({key: calling(step(value)) for key, value in kinds.items()}, rounds)
    rows = (("messages", "none", "nobody"), ("messages of poses", "lean", "unposed"))
    return [
        entry(name, {"baseline": found[b], "absent": found[a], "present": found["all"]}, 0.0)
        for name, b, a in rows
    ]


def static(rounds: int) -> dict[str, Any]:
    """Measure velocity terms: the tangent of statics against that of motion."""
    dynamics = simulation_of(smallest()).dynamics
    rng = np.random.default_rng(2)
    state = 0.02 * rng.normal(size=dynamics.n) / dynamics.model.weight
    zero = np.zeros(dynamics.n)
    dynamics.inverse_dynamics(state, zero, zero)
    still, moving = (1.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    parts = dynamics.tangents(state, zero, zero)
    costs = interleaved(
        {
            "baseline": calling(lambda: dynamics.last_tangent(still)),
            "absent": calling(lambda: dynamics.last_tangent(still)),
            "present": calling(lambda: dynamics.last_tangent(moving)),
        },
        rounds,
    )
    return entry(
        "velocity terms in statics", costs, relative(parts[0], dynamics.last_tangent(still))
    )


def entry(name: str, costs: dict[str, float], worst: float | None) -> dict[str, Any]:
    """Return an entry of the file."""
    return {
        "feature": name,
        "cost_absent_us": costs["absent"],
        "cost_baseline_us": costs["baseline"],
        "cost_present_us": costs["present"],
        "max_rel_difference": worst,
    }


def main() -> int:
    """Measure, print, write; fail if something skipped had something to say."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.skip", description=__doc__)
    parser.add_argument("--rounds", type=int, default=31)
    parser.add_argument("--only", metavar="WORD", help="features with a word; nothing is written")
    given = parser.parse_args()
    rows = [
        stepped(feature, given.rounds)
        for feature in FEATURES
        if given.only is None or given.only in feature.name
    ]
    if given.only is None:
        rows += [static(given.rounds), *served(given.rounds)]
    for row in rows:
        absent = row["cost_absent_us"] / row["cost_baseline_us"]
        present = row["cost_present_us"] / row["cost_absent_us"]
        worst = "  –  " if row["max_rel_difference"] is None else f"{row['max_rel_difference']:.0e}"
        print(f"{row['feature']:26} {row['cost_baseline_us']:7.2f} us, absent {absent:5.2f}x, "
              f"present {present:5.2f}x, difference {worst}")  # fmt: skip
    if given.only is None:
        here = machine.facts()
        FILE.write_text(json.dumps([row | {"machine": here} for row in rows], indent=1) + "\n")
    return 1 if any((row["max_rel_difference"] or 0.0) > 1e-12 for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
