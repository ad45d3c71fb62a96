"""Bathe's bend: an eighth of a circle, clamped, is bent out of its plane by a force at its tip.

Displacements are along the tangent of the circle at the clamp, away from its centre, and along the
force of 600. Published solutions differ in shape, shear and torsion. Kynema's
(github.com/kynema/kynema, static curved beam among its verification tests) has twelve digits, equal
to BeamDyn's; its axis is the parabola through three points of the circle, and so is ours then. The
circle itself is compared with the boundary-value problem of the same rod.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml
from scipy.integrate import quad

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import parse_scene

from ..independent import shooting

RADIUS, YOUNG, FORCE = 100.0, 1e7, 600.0
LENGTH = RADIUS * np.pi / 4


@dataclass(frozen=True)
class Published:
    """A published tip: displacements, what half of its last digit is, its source, its axis."""

    name: str
    tip: tuple[float, float, float]
    digit: float
    source: str
    axis: str


PUBLISHED = (
    Published(
        "Kynema, BeamDyn", (-23.6459716009047, 13.7208006040058, 53.5776450626987), 5e-13,
        "Kynema's verification test of a curved beam, one element of 15 nodes", "parabola",
    ),
    Published(
        "BeamDyn, 2015", (-23.7, 13.5, 53.4), 0.05,
        "Wang, Sprague, Jonkman, Johnson, SciTech 2015, as quoted in OpenFAST's r-test", "circle",
    ),
    Published(
        "Bathe, Bolourchi 1979", (-23.5, 13.4, 53.4), 0.05,
        "Int. J. Numer. Meth. Eng. 14, 961–986, as quoted in OpenFAST's r-test", "circle",
    ),
)  # fmt: skip
# torsion, bending (twice), stretch, shear (twice), as Kynema and BeamDyn list them
STIFFNESS = np.array([8.333e5, 8.333e5, 8.333e5, 100e5, 41.6667e5, 41.6667e5])
# three points of the circle, as Kynema and BeamDyn list them
THROUGH = ((38.2683, -7.61205), (70.7107, -29.2893))


def parabola(points: int = 400) -> tuple[float, float, np.ndarray]:
    """Return angle at the clamp in rad, length and points (N, 3) of the parabola."""
    (x1, y1), (x2, y2) = THROUGH
    bend = (y2 / x2 - y1 / x1) / (x2 - x1)
    slope = y1 / x1 - bend * x1
    x = np.linspace(0.0, x2, points)
    length = quad(lambda u: np.hypot(1.0, slope + 2 * bend * u), 0.0, x2, epsrel=1e-13)[0]
    return float(np.arctan(slope)), length, np.array([x, slope * x + bend * x**2, 0.0 * x]).T


def tip(axis: str, order: int = 10, elements: int = 4) -> np.ndarray:
    """Return the displacement (3,) of the tip."""
    names = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")
    angle, length, points = parabola()
    reference: dict[str, Any] = {"centre_line": {"points": points.tolist()}}
    if axis == "circle":
        angle, length = 0.0, float(LENGTH)
        reference = {"curvature": [0.0, 0.0, -1.0 / RADIUS]}
    section: dict[str, Any] = {
        "name": "whole", "length": length, "material": "steel", "reference": reference,
        "cross_section": {"shape": "rectangle", "width_y": 1.0, "width_z": 1.0},
        "stiffness": dict(zip(names, STIFFNESS.tolist(), strict=True)),
    }  # fmt: skip
    document = {
        "gravity": [0.0, 0.0, 0.0],
        "base": {"rpy": [0.0, 0.0, angle]},
        "materials": {"steel": {"young_modulus": YOUNG, "poisson_ratio": 0.0, "density": 1.0}},
        "bodies": [{"rod": "bend", "sections": [section]}],
        "numerics": {"basis": {"order": order, "elements": elements}},
    }
    dynamics = Dynamics(parse_scene(yaml.safe_dump(document), "bathe.yaml"))
    rest = dynamics.node_poses(np.zeros(dynamics.n))[-1][:3, 3]
    q = equilibrium(dynamics, tip=np.array([0.0, 0.0, 0.0, 0.0, 0.0, FORCE]))
    moved: np.ndarray = dynamics.node_poses(q)[-1][:3, 3] - rest
    return moved


def exact() -> np.ndarray:
    """Return the displacement (3,) of the tip of the circle by the boundary-value problem."""
    wrench = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, FORCE]])
    curvature = (0.0, 0.0, -1.0 / RADIUS)
    rod = shooting.Rod((float(LENGTH),), STIFFNESS, np.zeros(3), wrench, curvature)
    (poses,) = shooting.solve(rod, [np.array([LENGTH])], steps=4)
    turned = np.pi / 4
    rest = RADIUS * np.array([np.sin(turned), np.cos(turned) - 1.0, 0.0])
    moved: np.ndarray = poses[-1, :3] - rest
    return moved


def compare() -> dict[str, Any]:
    """Compare the tip with what is published; errors over the length of the bend."""
    mine = {axis: tip(axis) for axis in ("circle", "parabola")}
    rows = [
        {
            "name": published.name, "source": published.source, "axis": published.axis,
            "tip": list(published.tip), "own_accuracy": published.digit / LENGTH,
            "error": float(np.linalg.norm(mine[published.axis] - published.tip) / LENGTH),
        }
        for published in PUBLISHED
    ]  # fmt: skip
    truth = exact()
    rows.append({
        "name": "boundary-value problem", "source": "benchmarks/independent/shooting.py",
        "axis": "circle", "tip": truth.tolist(), "own_accuracy": 1e-11,
        "error": float(np.linalg.norm(mine["circle"] - truth) / LENGTH),
    })  # fmt: skip
    return {"rows": rows, "tip": {axis: value.tolist() for axis, value in mine.items()}}
