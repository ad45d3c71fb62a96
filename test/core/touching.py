"""Scenes of bodies that touch shapes, for tests of contact."""

from __future__ import annotations

from typing import Any

import numpy as np
from scenes import scene_of

from soft_sim_ros.core.settled import Simulation

G = 9.81
BALL = {"kind": "sphere", "radius": 0.05}
PLANE = [{"plane": "floor"}]


def body_document(
    shape: Any = None, inertia: Any = None, mass: float = 0.5, tilt: float = 0.0, **rest: Any
) -> dict[str, Any]:
    """Return a free rigid body, by default a solid ball at rest on a plane tilted about y."""
    own = rest.pop("body", {})
    at = rest.pop("at", [0, 0, 0, 0, 0, 0.05])
    numerics = rest.pop("numerics", {})
    speed = rest.pop("speed", None)
    initial: dict[str, Any] = {"positions": {"fly": at}}
    if speed is not None:
        initial["velocities"] = {"fly": speed}
    inertia = [0.4 * mass * 0.05**2] * 3 if inertia is None else inertia
    return {
        "name": "thing",
        "gravity": [G * np.sin(tilt), 0.0, -G * np.cos(tilt)],
        "bodies": [
            {"joint": "fly", "kind": "free"},
            {"rigid_body": "thing", "mass": mass, "inertia": inertia, "shape": shape or BALL} | own,
        ],
        "environment": PLANE,
        "initial": initial,
        "numerics": {"step": 1e-3, "integrator": "sdirk2"} | numerics,
    } | rest


def body(**options: Any) -> Simulation:
    """Return a simulation of ``body_document``."""
    return Simulation(scene_of(body_document(**options)))


def rod_on_table(
    *,
    length: float = 0.4,
    radius: float = 0.01,
    height: float = 0.0,
    young: float = 2e6,
    strains: Any = ("bend_y", "stretch"),
    elements: int = 4,
    order: int = 3,
    free: bool = False,
    **rest: Any,
) -> dict[str, Any]:
    """Return a rod, clamped at the base or free, that begins ``height`` above a table."""
    numerics = {"step": 1e-3, "integrator": "sdirk2"} | rest.pop("numerics", {})
    basis = {"order": order, "elements": elements}
    own = rest.pop("body", {})
    bodies: list[dict[str, Any]] = [{"joint": "fly", "kind": "free"}] if free else []
    bodies.append(
        {
            "rod": "rod",
            "strains": list(strains),
            "sections": [
                {
                    "name": "s",
                    "length": length,
                    "material": "soft",
                    "cross_section": {"shape": "circle", "radius": radius},
                }
            ],
        }
        | own
    )
    return {
        "name": "rod",
        "gravity": [0.0, 0.0, -G],
        "materials": {
            "soft": {
                "young_modulus": young,
                "poisson_ratio": 0.45,
                "density": 1100.0,
                "viscosity": 2000.0,
            }
        },
        "bodies": bodies,
        "environment": [{"plane": "table", "position": [0.0, 0.0, -radius - height]}],
        "numerics": numerics | {"basis": basis},
    } | rest
