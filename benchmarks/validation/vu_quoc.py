"""Two undamped benchmarks of Simo and Vu-Quoc: a beam in free flight, and an elbow.

Set-ups: J. C. Simo, L. Vu-Quoc, ASME J. Appl. Mech. 53 (1986) 849–863 (plane), and Comput. Methods
Appl. Mech. Eng. 66 (1988) 125–161 (space). They print pictures, no numbers: what is compared are the
digitised curves of the elbow, Exudyn's geometrically exact elements extrapolated to none, and the
momentum of the beam in flight, which is known exactly.
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

from soft_sim_ros.core.simulation import Simulation
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
