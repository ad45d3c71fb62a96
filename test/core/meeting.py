"""Scenes of bodies that touch one another, for tests of contact between them."""

from __future__ import annotations

from typing import Any

import numpy as np

LAW = {
    "stiffness": 2e4,
    "onset": 2e-3,
    "dissipation": 0.3,
    "tangential_time": 0.002,
    "friction": {"static": 0.6, "kinetic": 0.4, "across": 0.3},
}
SOFT = {"young_modulus": 1e6, "poisson_ratio": 0.45, "density": 1100.0, "viscosity": 500.0}


def rod(name: str, radius: Any = 0.02, length: float = 0.3, **rest: Any) -> dict[str, Any]:
    """Return a round rod."""
    section = {
        "name": "s",
        "length": length,
        "material": "soft",
        "cross_section": {"shape": "circle", "radius": radius},
    }
    return {"rod": name, "sections": [section]} | rest


def free(name: str) -> dict[str, Any]:
    """Return a free joint at the base."""
    return {"joint": f"fly_{name}", "kind": "free", "parent": "base"}


def solid(name: str, mass: float = 0.3, shape: Any = None, **rest: Any) -> dict[str, Any]:
    """Return a rigid body, by default a ball of 5 cm."""
    shape = shape or {"kind": "sphere", "radius": 0.05}
    inertia = [4e-4, 5e-4, 6e-4]
    return {"rigid_body": name, "mass": mass, "inertia": inertia, "shape": shape} | rest


def scene(bodies: list[Any], pairs: Any, at: Any, speed: Any = None, **rest: Any) -> dict[str, Any]:
    """Return a document without weight of free bodies; at, speed: by name."""
    numerics = {"step": 1e-3, "integrator": "sdirk2"} | rest.pop("numerics", {})
    initial = {"positions": {f"fly_{name}": list(x) for name, x in at.items()}}
    if speed:
        initial["velocities"] = {f"fly_{name}": list(v) for name, v in speed.items()}
    return {
        "name": "meeting",
        "gravity": [0.0, 0.0, 0.0],
        "materials": {"soft": SOFT},
        "bodies": bodies,
        "pairs": pairs,
        "initial": initial,
        "numerics": numerics,
    } | rest


def momentum(sim: Any) -> Any:
    """Return (angular momentum about the origin, momentum) (6,) of a simulation, in base axes."""
    dynamics = sim.dynamics
    poses = dynamics.node_poses(sim.q)
    dynamics.residual(sim.q, sim.v, np.zeros(dynamics.n), dynamics.forcing())
    total = np.zeros(6)
    for mass, twist, pose in zip(dynamics.model.inertia, dynamics._data.eta, poses, strict=True):
        turn, p = pose[:3, :3], pose[:3, 3]
        push = mass[0] * turn @ twist[3:]
        total += [*(np.cross(p, push) + turn @ (mass[1:] * twist[:3])), *push]
    return total
