"""Scenes for physics tests, built from plain dictionaries."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml

from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.scene import Scene, parse_scene

ALL = ["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"]
SOFT = {"young_modulus": 1e6, "shear_modulus": 1e6 / 3, "density": 1000.0, "viscosity": 0.0}


def plain(value: Any) -> Any:
    """Return value with numpy numbers and arrays as YAML can write them."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value


def scene_of(document: dict[str, Any]) -> Scene:
    """Return the scene of a document."""
    return parse_scene(yaml.safe_dump(plain(document)), "test.yaml")


def rod_document(
    *,
    length: float = 0.6,
    radius: float = 0.03,
    strains: list[str] | None = None,
    order: int = 5,
    elements: int = 1,
    kind: str = "legendre",
    nodes: int | None = None,
    gravity: Any = (0.0, 0.0, 0.0),
    material: dict[str, float] | None = None,
    section: dict[str, Any] | None = None,
    numerics: dict[str, Any] | None = None,
    **rest: Any,
) -> dict[str, Any]:
    """Return the document of one clamped rod along x."""
    strains = ALL if strains is None else strains
    basis: dict[str, Any] = {"kind": kind, "elements": elements}
    if kind not in ("constant", "linear"):
        basis["order"] = {strain: order for strain in strains}
    if nodes is not None:
        basis["nodes"] = nodes
    return {
        "name": "rod",
        "gravity": gravity,
        "materials": {"soft": SOFT | (material or {})},
        "bodies": [
            {
                "rod": "rod",
                "strains": strains,
                "sections": [
                    {
                        "name": "s",
                        "length": length,
                        "material": "soft",
                        "cross_section": {"shape": "circle", "radius": radius},
                    }
                    | (section or {})
                ],
            }
        ],
        "numerics": {"basis": basis} | (numerics or {}),
    } | rest


def rod(**options: Any) -> Dynamics:
    """Return the dynamics of one clamped rod along x."""
    return Dynamics(scene_of(rod_document(**options)))


def rod_simulation(**options: Any) -> Simulation:
    """Return a simulation of one clamped rod along x."""
    return Simulation(scene_of(rod_document(**options)))


def zoo_document(base: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return an arm with everything in it: joints, rods, rigid bodies, all loads and actuators."""
    return {
        "name": "zoo",
        "gravity": [0.7, -1.3, -9.0],
        "base": base or {"position": [0.3, -0.2, 1.1], "rpy": [0.4, -0.7, 1.9]},
        "materials": {"soft": SOFT | {"viscosity": 300.0}},
        "bodies": [
            {"joint": "hip", "kind": "revolute", "axis": [0.3, 0.5, -0.8], "stiffness": 0.4,
             "damping": 0.02, "offset": {"position": [0.0, 0.02, 0.03], "rpy": [0.1, 0.2, 0.3]}},
            {"rigid_body": "motor", "mass": 0.3, "inertia": [1e-4, 2e-4, 2.5e-4],
             "com": {"position": [0.01, 0.02, -0.01], "rpy": [0.3, 0.0, 0.5]}},
            {"rod": "one", "strains": ALL, "sections": [
                {"name": "a", "length": 0.2, "material": "soft",
                 "cross_section": {"shape": "ellipse", "semi_axis_y": [0.03, 0.025],
                                   "semi_axis_z": 0.02},
                 "reference": {"curvature": [1.0, [0.0, 2.0], -1.0]}},
                {"name": "b", "length": 0.15, "material": "soft",
                 "cross_section": {"shape": "rectangle", "width_y": 0.04, "width_z": 0.03}}]},
            {"joint": "knee", "kind": "revolute", "axis": [0.0, 1.0, 0.0]},
            {"rod": "two", "strains": ["torsion", "bend_y", "bend_z", "stretch"], "sections": [
                {"name": "c", "length": 0.25, "material": "soft",
                 "cross_section": {"shape": "annulus", "outer": [0.03, 0.02], "inner": 0.01}}]},
            {"rigid_body": "payload", "mass": 0.2, "inertia": [1e-4, 1e-4, 1e-4]},
        ],
        "actuators": [
            {"joint_torque": "hip_torque", "joint": "hip"},
            {"moment": "a_bend", "rod": "one", "section": "a", "strain": "bend_y"},
            {"tendon": "straight", "rod": "one", "offset": {"from": [0.02, 0.01],
                                                            "to": [0.015, -0.01]}},
            {"tendon": "helix", "rod": "two", "start": 0.0, "end": 0.15,
             "helix": {"radius": 0.02, "angle": 0.4, "turns": 0.7}},
        ],
        "loads": [
            {"point": "dead", "body": "one", "s": 0.1, "force": [0.3, -0.4, 0.2],
             "moment": [0.02, 0.05, -0.03]},
            {"point": "follower", "body": "two", "force": [0.2, 0.3, -0.3],
             "moment": [0.01, -0.02, 0.03], "frame": "body"},
            {"distributed": "wind", "body": "two", "start": 0.1, "force": [1.0, -2.0, 0.5]},
            {"distributed": "jet", "body": "one", "force": [0.0, 0.5, 1.0],
             "moment": [0.1, 0.0, 0.0], "frame": "body"},
        ],
        "numerics": {"basis": {"order": 2}},
    }  # fmt: skip


def random_state(dynamics: Dynamics, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return q, q̇, q̈ (n,) of a strongly deformed, fast motion: tip displacements of order one."""
    rng = np.random.default_rng(seed)
    size = 0.25 / dynamics.model.weight
    # stretch and shear of order one would turn the rod inside out
    names = dynamics.compiled.coordinate_names
    size *= [0.1 if "stretch" in name or "shear" in name else 1.0 for name in names]
    return tuple(rng.normal(size=(3, dynamics.n)) * size)  # type: ignore[return-value]
