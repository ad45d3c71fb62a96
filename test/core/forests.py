"""Scenes of several branches, for tests of the forest."""

from __future__ import annotations

from typing import Any

from scenes import ALL, SOFT, plain, scene_of

from soft_sim_ros.core.settled import Dynamics


def section(length: float, radius: float = 0.02, name: str = "s") -> dict[str, Any]:
    """Return a round section of a length in m."""
    shape = {"shape": "circle", "radius": radius}
    return {"name": name, "length": length, "material": "soft", "cross_section": shape}


def rod(name: str, length: float, parent: Any = None, **rest: Any) -> dict[str, Any]:
    """Return a rod of one section."""
    where = {} if parent is None else {"parent": parent}
    return {"rod": name, "sections": [section(length)], **where, **rest}


def place(body: str, s: float | None = None, **offset: Any) -> dict[str, Any]:
    """Return where a body is attached."""
    out: dict[str, Any] = {"body": body}
    if s is not None:
        out["s"] = s
    if offset:
        out["offset"] = offset
    return out


def forest_document(bodies: list[dict[str, Any]], **rest: Any) -> dict[str, Any]:
    """Return a scene of some bodies, low orders, under a tilted weight."""
    basis = {"order": dict.fromkeys(ALL, 2)}
    return {
        "name": "forest",
        "gravity": [1.0, -2.0, -9.0],
        "materials": {"soft": SOFT | {"viscosity": 2e3, "rayleigh": {"mass": 0.3}}},
        "bodies": bodies,
        "numerics": {"basis": basis, "step": 1e-3},
    } | rest


def tree_document(**rest: Any) -> dict[str, Any]:
    """Return rods on a palm, on rods and in the middle of rods, rings, tools, loads, tendons."""
    bodies = [
        {"joint": "swing", "kind": "revolute", "axis": [0.2, 1.0, 0.1], "stiffness": 3.0},
        {"rigid_body": "palm", "mass": 0.4, "inertia": [1e-3, 2e-3, 2.5e-3],
         "com": {"position": [0.05, 0.01, 0.0], "rpy": [0.3, 0.1, 0.2]}},
        rod("stem", 0.3),
        rod("left", 0.2, place("stem", 0.12, position=[0, 0.01, 0], rpy=[0.1, 0.2, 0.9])),
        {"rigid_body": "ring", "mass": 0.1, "inertia": [2e-4, 1e-4, 1e-4],
         "parent": place("left", 0.05)},
        {"joint": "hinge", "kind": "universal", "axes": [[0, 1, 0], [0, 0, 1]],
         "stiffness": 0.4, "damping": 0.01, "parent": "left"},
        rod("finger", 0.1),
        rod("thumb", 0.15, place("palm", position=[0.02, -0.04, 0.01], rpy=[0, 0, -1.2])),
        {"rigid_body": "tool", "mass": 0.05, "parent": "stem"},
        rod("second", 0.25, place("base", position=[0.0, 0.5, 0.0], rpy=[0.4, -0.3, 0.2])),
    ]  # fmt: skip
    return forest_document(
        bodies,
        actuators=[
            {"moment": "curl", "rod": "thumb", "section": "s", "strain": "bend_z"},
            {"tendon": "pull", "rod": "stem", "offset": [0.01, 0.004]},
            {"tendon": "rubbing", "rod": "left", "offset": [0.0, 0.01], "friction": 0.2},
            {"chamber": "blow", "rod": "second", "offset": [0.005, 0.0], "area": 1e-4},
        ],
        loads=[
            {"point": "push", "body": "left", "s": 0.17, "force": [0.1, 0.2, -0.3]},
            {"point": "turn", "body": "ring", "moment": [0.01, 0.0, 0.02], "frame": "body"},
            {"distributed": "wind", "body": "finger", "force": [0.0, 0.4, 0.1]},
        ],
        **rest,
    )


EFFORTS = [0.05, 2.0, 1.5, 2e3]


def tree(**rest: Any) -> Dynamics:
    """Return the equations of motion of ``tree_document``."""
    return Dynamics(scene_of(tree_document(**rest)))


__all__ = [
    "EFFORTS",
    "forest_document",
    "place",
    "plain",
    "rod",
    "scene_of",
    "section",
    "tree",
    "tree_document",
]
