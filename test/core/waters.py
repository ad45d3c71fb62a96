"""Scenes in water, and the wrench of the fluid in words of another kind, for tests of it."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from scenes import rod_document, scene_of, zoo_document

from soft_sim_ros.core.settled import Dynamics, Simulation

CURRENT = {"x": "0.3 + 0.5*t", "y": "0.2*sin(t + 1)", "z": "-0.4 + 0.1*t**2"}
WATER = {"density": 1000.0}
HULL = {
    "semi_axes": [0.1, 0.06, 0.04],
    "drag": [0.3, 0.5, 0.7],
    "rotary_drag": [0.01, 0.02, 0.03],
    "rotary_viscous": 0.004,
    "lift": [0.2, -0.1, 0.3],
    "center": {"position": [0.02, 0.01, -0.03], "rpy": [0.4, 0.3, -0.2]},
}


def wet_zoo(**fluid: Any) -> dict[str, Any]:
    """Return an arm with everything in it, in a fluid that does everything."""
    document = zoo_document()
    document["fluid"] = {
        "density": 900.0,
        "current": CURRENT,
        "lift": [0.1, 0.3, -0.2],
        "viscous_normal": 2.0,
        "viscous_tangential": 1.0,
        "drag_normal": [1.1, 1.5],
        "surface": 2.0,
    } | fluid
    bodies = document["bodies"]
    bodies[1]["fluid"] = HULL
    bodies[2]["fluid"] = {"dry_ends": ["start"]}
    bodies[2]["sections"][0]["fluid"] = {"drag_tangential": 0.2, "added_mass": [0.8, 1.3]}
    bodies[4]["fluid"] = {"dry_ends": ["end"]}
    bodies[5]["fluid"] = {
        "volume": 1e-4,
        "added_mass": [0.1, 0.2, 0.3],
        "added_inertia": [1e-3, 2e-3, 3e-3],
        "area": [0.01, 0.02, 0.03],
        "drag": 1.0,
        "viscous": [0.1, 0.2, 0.3],
    }
    return document


def without_fluid(document: dict[str, Any]) -> dict[str, Any]:
    """Return the same scene in nothing."""
    dry = copy.deepcopy(document)
    dry.pop("fluid", None)
    for body in dry["bodies"]:
        for part in (body, *body.get("sections", ())):
            part.pop("fluid", None)
    return dry


def floating(bodies: list[dict[str, Any]], **rest: Any) -> dict[str, Any]:
    """Return bodies that nothing holds, in still water without weight."""
    document = rod_document(order=2)
    document["bodies"] = [{"joint": "float", "kind": "free"}, *bodies]
    document["numerics"] = {"basis": {"order": 2}} if any("rod" in b for b in bodies) else {}
    return document | {"gravity": [0, 0, 0], "fluid": dict(WATER)} | rest


def body(mass: float, inertia: Any = (0.0, 0.0, 0.0), **fluid: Any) -> dict[str, Any]:
    """Return a rigid body in the fluid."""
    return {"rigid_body": "hull", "mass": mass, "inertia": list(inertia), "fluid": fluid}


def simulation(document: dict[str, Any], step: float, **numerics: Any) -> Simulation:
    """Return a simulation by the fourth-order method, or another one."""
    own = {"step": step, "integrator": "sdirk4"} | numerics
    return Simulation(scene_of(document | {"numerics": document["numerics"] | own}))


def places(dynamics: Dynamics, q: np.ndarray) -> np.ndarray:
    """Return the poses (P, 4, 4) in the world of all places at which the fluid acts."""
    fluid, poses = dynamics.model.fluid, dynamics.node_poses(q)
    offsets = np.tile(np.eye(4), (len(fluid.node), 1, 1))
    offsets[:, :3, :3] = fluid.frame[:, :9].reshape(-1, 3, 3)
    offsets[:, :3, 3] = fluid.frame[:, 9:]
    return np.asarray(poses[fluid.node] @ offsets)


def velocities(dynamics: Dynamics, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return angular and linear velocity (P, 6) of these, along world axes."""
    fluid, poses = dynamics.model.fluid, dynamics.node_poses(q)
    twists = dynamics.node_twists(q, v)[fluid.node]
    out = np.zeros((len(twists), 6))
    for row, twist, own, pose in zip(
        out, twists, poses[fluid.node], places(dynamics, q), strict=True
    ):
        turn = own[:3, :3]
        row[:3] = turn @ twist[:3]
        row[3:] = turn @ twist[3:] + np.cross(row[:3], pose[:3, 3] - own[:3, 3])
    return out


def work_of(
    dynamics: Dynamics, q: np.ndarray, moments: np.ndarray, forces: np.ndarray
) -> np.ndarray:
    """Return the generalised force (n,) of moments and forces (P, 3) on places, in the world."""
    fluid, jacobians = dynamics.model.fluid, dynamics.jacobians(q, np.zeros(dynamics.n))[0]
    out = np.zeros(dynamics.n)
    poses, at = dynamics.node_poses(q), places(dynamics, q)
    for k, pose, moment, force in zip(fluid.node, at, moments, forces, strict=True):
        turn = poses[k, :3, :3].T
        about = moment + np.cross(pose[:3, 3] - poses[k, :3, 3], force)
        out += jacobians[k].T @ np.concatenate([turn @ about, turn @ force])
    return out


__all__ = [
    "CURRENT",
    "WATER",
    "body",
    "floating",
    "places",
    "simulation",
    "velocities",
    "wet_zoo",
    "without_fluid",
    "work_of",
]
