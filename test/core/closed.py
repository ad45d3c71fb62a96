"""Scenes with constraints, for tests."""

from __future__ import annotations

from typing import Any

from forests import section
from scenes import ALL

SLACK = {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1000.0}


def bar(name: str, length: float, mass: float = 0.3) -> list[dict[str, Any]]:
    """Return a hinge and the rigid bar on it, along x; ``end_…`` is its far end."""
    inertia = mass * length**2 / 12.0
    return [
        {"joint": f"hinge_{name}", "kind": "revolute", "axis": [0, 1, 0]},
        {"rigid_body": f"bar_{name}", "mass": mass, "inertia": [1e-4, inertia, inertia],
         "com": {"position": [length / 2.0, 0, 0]}},
        {"joint": f"end_{name}", "kind": "fixed", "offset": {"position": [length, 0, 0]}},
    ]  # fmt: skip


def four_bar(kind: str = "ball", constraints: Any = None, **numerics: Any) -> dict[str, Any]:
    """Return three bars in a row whose end is pinned where it is at the start."""
    pin: dict[str, Any] = {"name": "pin", "kind": kind, "frames": [{"body": "end_three"}]}
    if kind == "hinge":
        pin["axis"] = [0, 1, 0]
    return {
        "name": "four_bar",
        "gravity": [0, 0, -9.81],
        "bodies": [*bar("one", 0.3), *bar("two", 0.5), *bar("three", 0.4)],
        "initial": {"positions": {"hinge_one": -0.9, "hinge_two": 0.7, "hinge_three": 1.2}},
        "constraints": [pin] if constraints is None else constraints,
        "numerics": {"step": 1e-3, "integrator": "sdirk2", **numerics},
    }


def held_rod(
    constraints: list[dict[str, Any]], length: float = 0.5, radius: float = 0.01, **rest: Any
) -> dict[str, Any]:
    """Return a rod from the base along x."""
    body = {"rod": "rod", "strains": list(ALL), "sections": [section(length, radius)]}
    return {
        "name": "held_rod",
        "gravity": [0, 0, 0],
        "materials": {"soft": SLACK},
        "bodies": [body | rest.pop("rod", {})],
        "constraints": constraints,
        "numerics": {"step": 1e-3, "basis": {"order": 5, "elements": 2}},
    } | rest


def at(kind: str, place: list[float], **rest: Any) -> dict[str, Any]:
    """Return what holds the end of the rod in the world."""
    frames = [{"body": "rod"}, {"world": {"position": place}}]
    return {"name": "far", "kind": kind, "frames": frames, **rest}
