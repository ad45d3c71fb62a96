"""Equilibria under dead moments and loads that follow: what is called stable has to stay.

Each scene is judged three times: by ``equilibrium``, by the growth of ``complex_modes`` on a finer
model, and by a run of that finer model, pushed by a ten-millionth of its length.
"""

from __future__ import annotations

import time
import warnings
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.analysis.modes import complex_modes
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.refine.prolong import prolong
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import SolverError, StaticsFailed, UndampedFlutter
from soft_sim_ros.scene import Scene, parse_scene

KINDS = ("twisted column", "column and follower", "beck", "roll-up", "bent by a dead moment", "any")
YOUNG, DENSITY = 1e7, 1000.0  # Pa, kg/m³
DAMPING = ("none", "viscosity", "mass")
PUSH = 1e-7  # arm lengths
GREW = 1e5  # by this factor a run is followed, where it should grow
STEADY = 8.0  # times the largest deviation of its first third: more in the last has left
PERIOD = 40  # steps in one swing of what grows
STEPS = 1200
NEAR = (
    2e-3  # growth over the pace of what grows: less is too near for two models to agree, or a run
)
BEYOND = 0.03  # of the load: a refusal is looked at so far before and behind where it is said
FAR = 0.3  # arm lengths: farther away, a finer model has found another equilibrium


@dataclass(frozen=True)
class Load:
    """One scene. Lengths in m, ``slenderness`` length over radius, ``ratio`` of two widths.

    amount : of the first load, over Euler's load, EI/L² or turns, by kind
    twist : of the second, over EI/L
    damping_ratio : of the slowest mode
    """

    kind: str
    length: float
    slenderness: float
    ratio: float
    amount: float
    twist: float
    side: float
    damping: str
    damping_ratio: float
    seed: int

    @property
    def radius(self) -> float:
        """Half the smaller width in m."""
        return self.length / self.slenderness

    @property
    def section(self) -> tuple[float, float]:
        """Area in m² and least second moment of area in m⁴."""
        if self.ratio > 1.0:
            area = 4.0 * self.radius**2 * self.ratio
            return area, area * self.radius**2 / 3.0
        area = np.pi * self.radius**2
        return area, area * self.radius**2 / 4.0

    @property
    def omega(self) -> float:
        """Lowest angular frequency in rad/s of the rod without loads (Euler–Bernoulli)."""
        area, inertia = self.section
        return float(1.8751**2 / self.length**2 * np.sqrt(YOUNG * inertia / (DENSITY * area)))

    def scene(
        self, factor: float = 1.0, order: int = 5, nodes: int = 16, step: float = 1.0
    ) -> Scene:
        """Return the scene with its loads times a factor."""
        section: dict[str, Any] = {"shape": "circle", "radius": self.radius}
        if self.ratio > 1.0:
            wide = 2.0 * self.radius * self.ratio
            section = {"shape": "rectangle", "width_y": wide, "width_z": 2.0 * self.radius}
        material: dict[str, Any] = {
            "young_modulus": YOUNG,
            "poisson_ratio": 0.4,
            "density": DENSITY,
        }
        body = {
            "rod": "rod",
            "sections": [
                {"name": "s", "length": self.length, "material": "m", "cross_section": section}
            ],
        }
        if self.damping == "viscosity":
            material["viscosity"] = float(2.0 * self.damping_ratio / self.omega * YOUNG / 3.0)
        elif self.damping == "mass":
            material["rayleigh"] = {"mass": float(2.0 * self.damping_ratio * self.omega)}
        loads = [
            {"point": f"load{i}", "body": "rod", "force": (factor * force).tolist(),
             "moment": (factor * moment).tolist(), "frame": frame}
            for i, (force, moment, frame) in enumerate(self._loads())
        ]  # fmt: skip
        document = {
            "name": "equilibrium", "gravity": [0.0, 0.0, 0.0], "materials": {"m": material},
            "bodies": [body], "loads": loads,
            "numerics": {
                "basis": {"order": order, "nodes": nodes},
                "integrator": "sdirk4", "step": round(step, 9),
            },
        }  # fmt: skip
        return parse_scene(yaml.safe_dump(document), "equilibrium.yaml")

    def _loads(self) -> list[tuple[Floats, Floats, str]]:
        x, _, z = np.eye(3)
        stiff = YOUNG * self.section[1]
        unit, bend = stiff / self.length**2, stiff / self.length
        euler = 0.25 * np.pi**2 * unit
        nothing = np.zeros(3)
        push = -self.amount * euler * x + self.side * euler * z
        if self.kind == "twisted column":
            return [(push, self.twist * bend * x, "world")]
        if self.kind == "column and follower":
            return [(push, nothing, "world"), (nothing, self.twist * bend * x, "body")]
        if self.kind == "beck":
            dead = self.side * unit * z
            return [(-self.amount * unit * x, nothing, "body"), (dead, nothing, "world")]
        rng = np.random.default_rng(self.seed)
        if self.kind == "any":
            force, moment = 3.0 * rng.uniform(-1.0, 1.0, (2, 3)) * self.amount
            return [(force * unit, moment * bend, "world")]
        moment = 2.0 * np.pi * self.amount * bend * np.array([0.0, 1.0, self.side])
        return [(nothing, moment, "body" if self.kind == "roll-up" else "world")]


def loads(count: int) -> list[Load]:
    """Return random scenes, always the same."""
    rng = np.random.default_rng(9)
    most = {"twisted column": 2.0, "column and follower": 2.0, "beck": 40.0, "roll-up": 1.2}
    out = []
    for i in range(count):
        kind = KINDS[i % len(KINDS)]
        round_ = rng.random() < 0.4
        out.append(
            Load(
                kind=kind,
                length=float(10.0 ** rng.uniform(-3.0, 1.5)),
                slenderness=float(10.0 ** rng.uniform(1.2, 4.0)),
                ratio=1.0 if round_ else float(10.0 ** rng.uniform(0.005, 0.7)),
                amount=float(rng.uniform(0.02, most.get(kind, 0.8))),
                twist=float(10.0 ** rng.uniform(-4.0, 0.5)),
                side=float(rng.choice([0.0, 1e-3, 0.1])),
                damping=str(rng.choice(DAMPING)),
                damping_ratio=float(10.0 ** rng.uniform(-3.0, -0.5)),
                seed=i,
            )
        )
    return out


def judge_equilibrium(load: Load) -> dict[str, Any]:
    """Return how a scene was judged, and whether that was wrong."""
    begin = time.perf_counter()
    entry: dict[str, Any] = asdict(load) | {
        "outcome": "stable", "why": None, "share": 1.0, "growth_rel": None, "run": None,
        "wrong": None,
    }  # fmt: skip
    coarse = Dynamics(load.scene())
    try:
        q, told = _equilibrium(coarse)
        entry["outcome"] = "told" if told else "stable"
        entry |= _looked_at(load, 1.0, coarse, q, told)
    except StaticsFailed as failure:
        entry |= {"outcome": "refused", "why": failure.why, "share": failure.load_factor}
        if "stability" in failure.why:
            entry |= _both_sides(load, failure.load_factor)
    return entry | {"wall_s": time.perf_counter() - begin}


def _equilibrium(dynamics: Dynamics, **options: Any) -> tuple[Floats, bool]:
    """Return an equilibrium, and whether it was said that its swings grow."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        q = equilibrium(dynamics, **options)
    return q, any(isinstance(w.message, UndampedFlutter) for w in said)


def _both_sides(load: Load, share: float) -> dict[str, Any]:
    """Look at the equilibria a little before and beyond the load at which stability is lost."""
    before = Dynamics(load.scene((1.0 - BEYOND) * share))
    q, told = _equilibrium(before)
    answer = _looked_at(load, (1.0 - BEYOND) * share, before, q, told)
    if answer["wrong"] is None:
        factor = (1.0 + BEYOND) * share + 1e-9
        answer = _looked_at(load, factor, before, q, True)
    return answer


def _looked_at(
    load: Load, factor: float, known: Dynamics, q: Floats, leaves: bool
) -> dict[str, Any]:
    """Return what a finer model and its pushed run say of the equilibrium near a known one.

    leaves : whether it was said to be unstable
    """
    fine = Dynamics(load.scene(factor, order=7, nodes=26))
    start = prolong(known.compiled, fine.compiled, q)
    try:
        q = equilibrium(fine, start, stable=False, thorough=False)
    except StaticsFailed:
        return {"run": "no equilibrium there", "wrong": None}
    if np.abs((q - start) * fine.model.weight).max() > FAR:
        return {"run": "another equilibrium", "wrong": None}
    values = complex_modes(fine, q).values
    fastest = values[np.argmax(values.real)]
    rel = float(fastest.real) / max(abs(fastest), 0.1 * load.omega)
    answer: dict[str, Any] = {"growth_rel": rel, "run": None, "wrong": None}
    if (rel > NEAR and not leaves) or (leaves and rel < -NEAR):
        answer["wrong"] = "complex_modes"
        if not _confirmed(load, factor, fine, q, fastest):
            # two of the fastest swings coincide in this model, and in no other
            return answer | {"run": "models differ", "wrong": None}
    grew = answer["run"] = _run(load, factor, q, fastest, rel > NEAR)
    if isinstance(grew, float) and answer["wrong"] is None:
        if grew > STEADY and not leaves:
            answer["wrong"] = "the run leaves"
        if grew < STEADY and leaves and rel > NEAR:
            answer["wrong"] = "the run stays"
    return answer


def _confirmed(load: Load, factor: float, known: Dynamics, q: Floats, fastest: complex) -> bool:
    """Return whether a still finer model has what grows fastest, too."""
    finest = Dynamics(load.scene(factor, order=9, nodes=36))
    try:
        start = prolong(known.compiled, finest.compiled, q)
        q = equilibrium(finest, start, stable=False, thorough=False)
    except StaticsFailed:
        return False
    values = complex_modes(finest, q).values
    return bool(np.abs(values - fastest).min() < 0.2 * abs(fastest.real))


def _run(load: Load, factor: float, q: Floats, fastest: complex, grows: bool) -> float | str:
    """Return by how much a small push has grown, or why nobody knows."""
    pace = max(abs(fastest), load.omega) if grows else load.omega
    step = max(round(2e9 * np.pi / pace / PERIOD), 1) * 1e-9
    steps = STEPS
    if grows:
        steps = int(np.ceil(np.log(GREW) / fastest.real / step))
        if steps > 4 * STEPS:
            return "too slow to see"
    simulation = Simulation(load.scene(factor, order=7, nodes=26, step=step))
    weight = simulation.model.weight
    rng = np.random.default_rng(load.seed)
    push = np.zeros(len(q))
    for rod in simulation.compiled.chain.rods.values():
        for component, first, count in rod.elements[0].columns:
            if component < 3:
                push[first : first + count] = rng.normal(size=count)
    push *= PUSH / np.abs(push).max() / weight
    simulation.set_state(q + push, np.zeros(len(q)))
    size = []
    try:
        for _ in range(30):
            simulation.advance(max(1, steps // 30))
            size.append(float(np.abs((simulation.q - q) * weight).max()))
    except SolverError as error:
        return type(error).__name__
    return max(size[20:]) / max(size[:10])
