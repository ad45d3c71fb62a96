"""The six-rod platform of Till's continuum Stewart–Gough problem, and an own shooting solution.

Rods stand welded in the base; at the platform each may spin about its own axis, so a hinge holds
it. The published solution asks instead that two components of R₁ᵀR₂ − R₁R₂ᵀ vanish, R₁ of the rod
and R₂ of the platform, which mixes the axes of both: where a rod spins, its axis is then 2·10⁻³ rad
off the normal of the platform. ``published_axes`` finds those axes from the published forces alone,
so that the same problem can be posed here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

RING = 0.087
AREA, INERTIA = np.pi * 1e-6, np.pi * 1e-12 / 4.0
YOUNG, SHEAR, DENSITY, GRAVITY = 200e9, 80e9, 8000.0, 9.81
BOTTOM = np.radians([-10, 10, 110, 130, 230, 250])
TOP = np.radians([-50, 50, 70, 170, 190, 290])
TILT = np.radians(10.0)
PLATFORM = np.array(
    [[np.cos(TILT), 0.0, np.sin(TILT)], [0.0, 1.0, 0.0], [-np.sin(TILT), 0.0, np.cos(TILT)]]
)
HEIGHT = np.array([0.0, 0.0, 0.4])
# the published solution: lengths in m, base forces in N and base moments in N·m
LENGTHS = [0.39733767, 0.39733767, 0.39972011, 0.42163610, 0.42163610, 0.39972011]
FORCES = [
    [-1.502339, -0.891441, -4.494306],
    [-1.502339, 0.891441, -4.494306],
    [2.465413, 0.0, 10.701636],
    [-0.963074, -0.286881, -6.998302],
    [-0.963074, 0.286881, -6.998302],
    [2.465413, 0.0, 10.701636],
]
MOMENTS = [
    [0.28755709, -0.32180845],
    [-0.28755709, -0.32180845],
    [0.0, 0.29226336],
    [0.23778612, -0.2848474],
    [-0.23778612, -0.2848474],
    [0.0, 0.29226336],
]


def hole(angles: Any, i: int) -> Any:
    """Return the place (3,) of a hole on its ring."""
    return RING * np.array([np.cos(angles[i]), np.sin(angles[i]), 0.0])


def shoot(i: int, force: Any, moment: Any) -> tuple[Any, Any, Any]:
    """Return tip position, orientation (z along the rod) and moment of rod i, from its base."""
    shear = np.array([SHEAR * AREA, SHEAR * AREA, YOUNG * AREA])
    bend = np.array([YOUNG * INERTIA, YOUNG * INERTIA, 2.0 * SHEAR * INERTIA])
    weight = np.array([0.0, 0.0, -DENSITY * AREA * GRAVITY])

    def rates(_s: float, y: Any) -> Any:
        turn, n, m = y[3:12].reshape(3, 3), y[12:15], y[15:18]
        v, u = turn.T @ n / shear + [0.0, 0.0, 1.0], turn.T @ m / bend
        skew = np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])
        return np.concatenate([turn @ v, (turn @ skew).ravel(), -weight, -np.cross(turn @ v, n)])

    start = np.concatenate([hole(BOTTOM, i), np.eye(3).ravel(), force, moment])
    end = solve_ivp(rates, (0.0, LENGTHS[i]), start, rtol=1e-11, atol=1e-13).y[:, -1]
    return end[:3], end[3:12].reshape(3, 3), end[15:18]


def hinged(i: int) -> Any:
    """Return base force (3,) and moment (2,) of rod i with its axis across the platform."""
    goal = HEIGHT + PLATFORM @ hole(TOP, i)
    axes = PLATFORM[:, :2]

    def off(x: Any) -> Any:
        place, turn, _ = shoot(i, x[:3], [*x[3:], 0.0])
        return np.concatenate([place - goal, axes.T @ turn[:, 2]])

    found = root(off, [*FORCES[i], *MOMENTS[i]], tol=1e-13)
    assert np.abs(found.fun).max() < 1e-10
    return found.x


def published_axes() -> list[Any]:
    """Return the axes of the rods' ends in the platform (6, 3) that the published forces mean."""
    return [
        PLATFORM.T @ shoot(i, FORCES[i], [*MOMENTS[i], 0.0])[1][:, 2] for i in range(len(LENGTHS))
    ]


def robot_document(axes: Any = None, order: int = 6, **rest: Any) -> dict[str, Any]:
    """Return the robot as a scene, its platform on the end of nothing: a free joint."""
    bodies: list[dict[str, Any]] = []
    constraints = []
    for i, length in enumerate(LENGTHS):
        section = {
            "name": "all",
            "length": length,
            "material": "steel",
            "cross_section": {"shape": "circle", "radius": 0.001},
            "shear_correction": 1.0,
        }
        foot = {"position": hole(BOTTOM, i).tolist(), "rpy": [0.0, -np.pi / 2.0, 0.0]}
        strains = ["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"]
        bodies.append(
            {
                "rod": f"rod_{i + 1}",
                "parent": {"body": "base", "offset": foot},
                "strains": strains,
                "sections": [section],
            }
        )
        x, y, z = (0.0, 0.0, 1.0) if axes is None else axes[i]
        turn = [0.0, float(-np.arctan2(z, np.hypot(x, y))), float(np.arctan2(y, x))]
        top = {"position": hole(TOP, i).tolist(), "rpy": turn}
        frames = [{"body": f"rod_{i + 1}"}, {"body": "platform", "offset": top}]
        axis = [1.0, 0.0, 0.0]
        constraints.append(
            {"name": f"hole_{i + 1}", "kind": "hinge", "axis": axis, "frames": frames}
        )
    bodies += [
        {"joint": "float", "kind": "free", "parent": "base"},
        {"rigid_body": "platform", "mass": 0.1, "inertia": [2e-4, 2e-4, 4e-4]},
    ]
    orders = {"torsion": 2, "stretch": 2, "shear_y": order, "shear_z": order}
    return {
        "name": "parallel_robot",
        "gravity": [0.0, 0.0, -GRAVITY],
        "materials": {
            "steel": {"young_modulus": YOUNG, "shear_modulus": SHEAR, "density": DENSITY}
        },
        "bodies": bodies,
        "constraints": constraints,
        "initial": {
            "state": "equilibrium",
            "positions": {"float": [0.0, float(TILT), 0.0, *HEIGHT.tolist()]},
        },
        "numerics": {
            "step": 1e-3,
            "basis": {"order": orders | dict.fromkeys(("bend_y", "bend_z"), order)},
        },
    } | rest


def hand() -> dict[str, Any]:
    """Return the weld that holds the platform where the published solution has it."""
    half = 0.5 * float(TILT)
    pose = {
        "position": HEIGHT.tolist(),
        "quaternion": [0.0, float(np.sin(half)), 0.0, float(np.cos(half))],
    }
    return {"name": "hand", "kind": "weld", "frames": [{"body": "platform"}, {"world": pose}]}
