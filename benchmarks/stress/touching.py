"""Random scenes of contact: bodies that fall, slide, roll and hit, with friction and without.

Energy may be lost by a step, never made: the bound is GAINED of the energy turned over.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import SolverError
from soft_sim_ros.scene import Scene, parse_scene

from .passivity import Passivity

KINDS = ("ball", "capsule", "box", "arm", "rod", "balls", "rods", "coil")
SHAPES = ("plane", "corner", "sphere", "cylinder", "box")
STEP = (1e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2)
METHODS = ("sdirk2", "sdirk3", "sdirk4", "adaptive")
FRICTION = (0.0, 0.1, 0.5, 1.0)
TIME, INSTANTS = 0.5, 100  # s that a run lasts, and times at which its energy is looked at
GAINED = 1e-3  # of the energy turned over
SLIP = 1.5  # static over kinetic friction of half of the cases


@dataclass(frozen=True)
class Touch:
    """One scene of contact.

    stiffness : Pa; speed : m/s; friction : kinetic coefficient; ratio : static over it
    dissipation : s/m; step : s; tilt : of the weight from the normal of the floor, rad
    """

    kind: str
    shape: str
    stiffness: float
    speed: float
    friction: float
    ratio: float
    dissipation: float
    step: float
    tilt: float
    integrator: str
    seed: int

    def scene(self, pieces: int = 1) -> Scene:
        """Return the scene, each of its steps cut into so many."""
        rng = np.random.default_rng(self.seed)
        friction: Any = {"kinetic": self.friction, "static": self.ratio * self.friction}
        law = {"stiffness": self.stiffness, "dissipation": self.dissipation}
        law["friction"] = friction if self.friction > 0.0 else 0.0
        document: dict[str, Any] = {
            "name": "touching",
            "gravity": (9.81 * _tilted(self.tilt, rng)).tolist(),
            "materials": {"soft": _material(10.0 ** rng.uniform(5, 8))},
            "contact": law,
            "environment": _shapes(self.shape),
            "numerics": {"step": self.step / pieces, "integrator": self.integrator},
        }
        if self.integrator == "adaptive":
            document["numerics"]["options"] = {"error": 1e-4}
        _bodies(document, self, rng)
        return parse_scene(yaml.safe_dump(document), "touching.yaml")

    def as_dict(self) -> dict[str, Any]:
        """Return the parameters."""
        return asdict(self)


def _tilted(tilt: float, rng: np.random.Generator) -> np.ndarray:
    way = rng.uniform(0.1, math.pi - 0.1)
    return np.array([
        math.sin(tilt) * math.cos(way), math.sin(tilt) * math.sin(way), -math.cos(tilt)
    ])  # fmt: skip


def _material(young: float) -> dict[str, float]:
    return {"young_modulus": young, "poisson_ratio": 0.4, "density": 1100.0,
            "viscosity": 1e-3 * young}  # fmt: skip


def _shapes(shape: str) -> list[dict[str, Any]]:
    floor = {"plane": "floor", "normal": [0.0, 0.0, 1.0]}
    if shape == "plane":
        return [floor]
    if shape == "corner":
        return [floor, {"plane": "wall", "position": [0.3, 0, 0], "normal": [-1.0, 0.1, 0.2]}]
    if shape == "sphere":
        return [floor, {"sphere": "bump", "position": [0.05, 0.02, -0.02], "radius": 0.1}]
    if shape == "cylinder":
        ends = {"from": [0.0, -1.0, 0.0], "to": [0.1, 1.0, 0.0]}
        return [floor, {"cylinder": "log", "radius": 0.06} | ends]
    return [floor, {"box": "block", "size": [0.2, 0.3, 0.1], "position": [0.02, 0.01, 0.05],
                    "rpy": [0.0, 0.0, 0.3]}]  # fmt: skip


def _rod(name: str, radius: float, length: float) -> dict[str, Any]:
    section = {"name": "s", "length": length, "material": "soft",
               "cross_section": {"shape": "circle", "radius": radius}}  # fmt: skip
    return {"rod": name, "sections": [section]}


def _solid(name: str, kind: str, rng: np.random.Generator) -> dict[str, Any]:
    mass = 10.0 ** rng.uniform(-1.5, 0.5)
    shapes = {
        "ball": {"kind": "sphere", "radius": 0.05},
        "capsule": {"kind": "capsule", "radius": 0.03, "from": [-0.06, 0, 0], "to": [0.06, 0, 0]},
        "box": {"kind": "box", "size": [0.12, 0.08, 0.06]},
    }
    inertia = (mass * 1e-3 * rng.uniform(0.8, 1.2, 3)).tolist()
    return {"rigid_body": name, "mass": mass, "inertia": inertia, "shape": shapes[kind]}


def _bodies(document: dict[str, Any], case: Touch, rng: np.random.Generator) -> None:
    """Add bodies above the shapes, thrown at them."""
    positions: dict[str, Any] = {}
    velocities: dict[str, Any] = {}
    bodies: list[dict[str, Any]] = []

    def throw(name: str, at: list[float]) -> dict[str, Any]:
        positions[f"fly_{name}"] = [*rng.uniform(-0.6, 0.6, 3).tolist(), *at]
        way = np.array([*rng.uniform(-1, 1, 2), -abs(rng.normal())])
        way *= case.speed / np.linalg.norm(way)
        spin = rng.normal(size=3) * 0.5 * case.speed / 0.1
        velocities[f"fly_{name}"] = [*spin.tolist(), *way.tolist()]
        return {"joint": f"fly_{name}", "kind": "free", "parent": "base"}

    basis = {"basis": {"order": 2, "elements": 2}}
    if case.kind in ("ball", "capsule", "box"):
        bodies += [throw("a", [0.0, 0.0, 0.3]), _solid("a", case.kind, rng)]
    elif case.kind == "balls":
        bodies += [throw("a", [0.0, 0.0, 0.3]), _solid("a", "ball", rng)]
        bodies += [throw("b", [0.02, 0.01, 0.42]), _solid("b", "capsule", rng)]
        document["pairs"] = [{"bodies": ["a", "b"]}]
    elif case.kind == "arm":
        document["base"] = {"position": [-0.2, 0.0, 0.3], "rpy": [0.1, 0.2, 0.3]}
        bodies += [_rod("arm", 0.02, 0.5)]
        document["numerics"] |= basis
    elif case.kind == "rod":
        bodies += [throw("a", [-0.1, 0.0, 0.35]), _rod("a", 0.02, 0.3)]
        document["numerics"] |= basis
    elif case.kind == "rods":
        bodies += [throw("a", [-0.1, 0.0, 0.35]), _rod("a", 0.02, 0.3)]
        bodies += [throw("b", [-0.1, 0.02, 0.65]), _rod("b", 0.03, 0.3)]
        document["pairs"] = [{"bodies": ["a", "b"]}]
        document["numerics"] |= basis
    else:
        section = {"reference": {"curvature": [2.0, 0.0, 11.5]}}
        coil = _rod("a", 0.02, 0.5)
        coil["sections"][0] |= section
        bodies += [throw("a", [-0.1, 0.0, 0.35]), coil]
        document["pairs"] = [{"self": ["a"]}]
        document["numerics"] |= basis
    document["bodies"] = bodies
    document["initial"] = {"positions": positions, "velocities": velocities}
    for shape in document["environment"]:
        shape["overlap"] = True


def touches(count: int, seed: int = 3) -> list[Touch]:
    """Return random scenes; those of more begin with those of fewer."""
    rng = np.random.default_rng(seed)
    return [
        Touch(
            kind=str(rng.choice(KINDS)),
            shape=str(rng.choice(SHAPES)),
            stiffness=10.0 ** rng.uniform(4, 8),
            speed=10.0 ** rng.uniform(-1, 0.7),
            friction=float(rng.choice(FRICTION)),
            ratio=float(rng.choice((1.0, SLIP))),
            dissipation=float(rng.choice((0.0, 0.1, 1.0))),
            step=float(rng.choice(STEP)),
            tilt=float(rng.choice((0.0, 0.3, 0.8))),
            integrator=str(rng.choice(METHODS)),
            seed=int(rng.integers(2**31)),
        )
        for _ in range(count)
    ]


def judge_touch(case: Touch) -> dict[str, Any]:
    """Run a scene; say whether it made energy, and whether it was refused."""
    entry = case.as_dict() | {"outcome": "kept", "why": None, "gained_rel": None}
    passivity = None
    try:
        simulation = Simulation(case.scene())
        passivity = Passivity(simulation.ledger()[:3])
        steps = max(1, round(TIME / INSTANTS / case.step))
        for _ in range(round(TIME / case.step / steps)):
            simulation.advance(steps)
            ledger = simulation.ledger()
            # what is stored and lost, over what was there: the residual of the balance
            passivity.look(ledger[:3], float(ledger[3:5].sum()) - float(ledger[5]), 0.0)
    except SolverError as error:
        entry["outcome"], entry["why"] = "refused", f"{type(error).__name__}: {error.reason}"
    if passivity is not None and passivity.turned > 0.0:
        entry["gained_rel"] = -passivity.rel
        if entry["gained_rel"] > GAINED:
            entry["outcome"], entry["why"] = "wrong", "energy from nowhere"
    return entry
