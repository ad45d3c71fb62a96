"""Two undamped benchmarks of Simo and Vu-Quoc: a beam in free flight, and an elbow.

Set-ups: J. C. Simo, L. Vu-Quoc, ASME J. Appl. Mech. 53 (1986) 849–863 (plane), Comput. Methods
Appl. Mech. Eng. 66 (1988) 125–161 (space). They print pictures, no numbers: what is compared are
the digitised curves of the elbow, Exudyn's geometrically exact elements extrapolated to size zero,
and the momentum of the beam in flight, which is known exactly.
"""

from __future__ import annotations

import json
import subprocess
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import Scene, parse_scene

from ..programs.environments import clean, interpreter

Floats = NDArray[np.float64]
HERE = Path(__file__).parent


@dataclass(frozen=True)
class Section:
    """What both beams are made of: stiffnesses, mass per length, rotary inertia per length."""

    stretch: float
    shear: float
    torsion: float
    bend: float
    line: float
    inertia: tuple[float, float, float]

    def entry(self, length: float) -> dict[str, Any]:
        """Return the section of a scene. The shape of the cross-section has no effect left."""
        names = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")
        values = (self.torsion, self.bend, self.bend, self.stretch, self.shear, self.shear)
        return {
            "name": "whole", "length": length, "material": "any",
            "cross_section": {"shape": "circle", "radius": 0.1},
            "stiffness": dict(zip(names, values, strict=True)),
            "mass_per_length": self.line, "inertia_per_length": list(self.inertia),
        }  # fmt: skip


FLYING = Section(1e4, 1e4, 5e2, 1e2, 1.0, (20.0, 10.0, 10.0))
FLIGHT = {
    "from": (6.0, 0.0, 0.0), "to": (0.0, 8.0, 0.0), "force": 8.0, "moment": -80.0, "until": 2.5,
    "duration": 5.0,
}  # fmt: skip
ELBOW = Section(1e6, 1e6, 1e3, 1e3, 1.0, (20.0, 10.0, 10.0))
LOADED = {"leg": 10.0, "force": 50.0, "until": 2.0, "duration": 30.0}
ANY = {"any": {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1000.0}}


def numerics(step: float, order: int, elements: int, error: float) -> dict[str, Any]:
    """Return the block of that name."""
    return {
        "step": step, "integrator": "adaptive", "options": {"error": error},
        "basis": {"order": order, "elements": elements},
    }  # fmt: skip


def flying(outputs: int, order: int = 4, elements: int = 4, error: float = 1e-7) -> Scene:
    """Return the beam that a force and a couple at one end throw through the plane."""
    start, end = np.array(FLIGHT["from"]), np.array(FLIGHT["to"])
    way = end - start
    schedule = {"start": 0.0, "end": FLIGHT["until"]}
    document = {
        "gravity": [0.0, 0.0, 0.0],
        "base": {
            "position": start.tolist(), "rpy": [0.0, 0.0, float(np.arctan2(way[1], way[0]))],
        },
        "materials": ANY,
        "bodies": [
            {"joint": "end", "kind": "free"},
            {"rod": "beam", "strains": ["bend_z", "stretch", "shear_y"],
             "sections": [FLYING.entry(float(np.linalg.norm(way)))]},
        ],
        "loads": [{
            "point": "throw", "body": "end", "force": [FLIGHT["force"], 0.0, 0.0],
            "moment": [0.0, 0.0, FLIGHT["moment"]], "schedule": schedule,
        }],
        "numerics": numerics(float(FLIGHT["duration"]) / outputs, order, elements, error),
    }  # fmt: skip
    return parse_scene(yaml.safe_dump(document), "flying.yaml")


def elbow(outputs: int, order: int = 3, elements: int = 2, error: float = 1e-6) -> Scene:
    """Return the two legs, at right angles, pushed out of their plane at the corner."""
    document = {
        "gravity": [0.0, 0.0, 0.0],
        "materials": ANY,
        "bodies": [
            {"rod": "first", "sections": [ELBOW.entry(LOADED["leg"])]},
            {"joint": "corner", "kind": "fixed", "offset": {"rpy": [0.0, 0.0, float(np.pi / 2)]}},
            {"rod": "second", "sections": [ELBOW.entry(LOADED["leg"])]},
        ],
        "loads": [{
            "point": "push", "body": "corner", "force": [0.0, 0.0, LOADED["force"]],
            "schedule": {"start": 0.0, "end": LOADED["until"], "ramp": LOADED["until"] / 2},
        }],
        "numerics": numerics(LOADED["duration"] / outputs, order, elements, error),
    }  # fmt: skip
    return parse_scene(yaml.safe_dump(document), "elbow.yaml")


def run(scene: Scene, outputs: int, samples: int, watched: tuple[int, int]) -> tuple[Floats, Any]:
    """Return the places (outputs + 1, 2, 3) of two of the samples, and the simulation."""
    simulation = Simulation(scene)
    sampler = simulation.sampler(samples)
    places = np.zeros((outputs + 1, 2, 3))
    for k in range(outputs + 1):
        simulation.advance(1 if k else 0)
        places[k] = sampler.poses()[list(watched), :3]
    return places, simulation


def exudyn(which: str, outputs: int, elements: int, steps: int, **more: Any) -> Floats:
    """Return the same places from Exudyn; ``elements`` per leg, ``steps`` per output."""
    data: dict[str, Any] = asdict(FLYING) | FLIGHT if which == "flying" else asdict(ELBOW) | LOADED
    if which == "flying":
        data |= {"from": data["from"][:2], "to": data["to"][:2]}
    job = {
        "which": which, "elements": elements, "steps": steps, "outputs": outputs, "data": data,
        "duration": data["duration"],
    } | more  # fmt: skip
    command = [str(interpreter("exudyn")), str(HERE / "child_exudyn.py")]
    done = subprocess.run(
        command, input=json.dumps(job), capture_output=True, text=True, env=clean()
    )
    if done.returncode:
        raise RuntimeError(f"Exudyn's child ended with {done.returncode}: {done.stderr[-500:]}")
    return np.array(json.loads(done.stdout.splitlines()[-1]))


def digitised() -> dict[str, Floats]:
    """Return times and displacements (2, N) of corner and tip as the paper's figure has them."""
    lines = (HERE / "data" / "elbow_1988.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines if not line.startswith(("#", "point"))]
    return {
        name: np.array([[float(t), float(u)] for point, t, u in rows if point == name]).T
        for name in ("corner", "tip")
    }


def first_peak(times: Floats, values: Floats, until: float) -> list[float]:
    """Return time and size of the largest value up to a time, by a parabola of three points."""
    k = int(np.argmax(np.where(times <= until, values, -np.inf)))
    a, b, c = np.polyfit(times[k - 1 : k + 2], values[k - 1 : k + 2], 2)
    return [float(-b / (2 * a)), float(c - b * b / (4 * a))]


def extrapolated(
    which: str, outputs: int, sizes: tuple[tuple[int, int], ...], **more: Any
) -> tuple:
    """Return Exudyn's places, extrapolated from the last two of its runs, and what that changes."""
    coarse, fine = (exudyn(which, outputs, n, steps, **more) for n, steps in sizes)
    last = fine + (fine - coarse) / 3.0
    return last, float(np.abs(last - fine).max())


def compare_flight(outputs: int = 50) -> dict[str, Any]:
    """Compare the beam in flight; errors over its length."""
    length = float(np.linalg.norm(np.array(FLIGHT["to"]) - FLIGHT["from"]))
    mine, simulation = run(flying(outputs, 4, 8, 1e-8), outputs, 2, (0, 1))
    coarse, _ = run(flying(outputs, 4, 4, 1e-7), outputs, 2, (0, 1))
    theirs, moved = extrapolated("flying", outputs, ((64, 16), (128, 32)))
    push = float(FLIGHT["force"]) * float(FLIGHT["until"])
    momentum = simulation.dynamics.momentum(simulation.q, simulation.v)[3:5]
    return {
        "theirs": "Exudyn 1.13.6, 64 and 128 elements in a plane, extrapolated",
        "own_accuracy": moved / length, "error": float(np.abs(mine - theirs).max() / length),
        "own_refinement": float(np.abs(mine - coarse).max() / length),
        "momentum": momentum.tolist(), "impulse": [push, 0.0],
        "momentum_error": float(np.linalg.norm(momentum - [push, 0.0]) / push),
    }  # fmt: skip


def compare_elbow(outputs: int = 300) -> tuple[dict[str, Any], Floats, Floats]:
    """Compare the elbow; errors over the length of a leg. Return our and Exudyn's places, too."""
    leg, times = float(LOADED["leg"]), np.linspace(0.0, LOADED["duration"], outputs + 1)
    mine, _ = run(elbow(outputs), outputs, 3, (1, 2))
    fine, _ = run(elbow(outputs, 4, 3, 1e-7), outputs, 3, (1, 2))
    theirs, moved = extrapolated("elbow", outputs, ((16, 1), (32, 2)), tolerance=1e-4)
    curves = {}
    for k, (name, figure) in enumerate(digitised().items()):
        until = 5.0 if name == "corner" else 10.0
        ours = np.interp(figure[0], times, mine[:, k, 2])
        curves[name] = {
            "rms": float(np.sqrt(np.mean((ours - figure[1]) ** 2)) / leg),
            "worst": float(np.abs(ours - figure[1]).max() / leg),
            "our_first_peak": first_peak(times, mine[:, k, 2], until),
            "exudyn_first_peak": first_peak(times, theirs[:, k, 2], until),
            "figure_first_peak": first_peak(figure[0], figure[1], until),
        }
    return {
        "theirs": "Exudyn 1.13.6, 16 and 32 elements per leg in space, extrapolated",
        "own_accuracy": moved / leg, "error": float(np.abs(mine - theirs).max() / leg),
        "own_refinement": float(np.abs(mine - fine).max() / leg), "figure": curves,
    }, mine, theirs  # fmt: skip
