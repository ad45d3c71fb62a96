"""Statics of the heavy arm as a boundary-value problem in world axes, by collocation (scipy).

Unknowns are position, rotation angle and internal force of the planar rod; nothing is shared with
the package.

    python -m benchmarks.independent.statics
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_bvp

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics

from ..cases import CASES
from ..programs.ours import scene_of


def planar_tip() -> np.ndarray:
    """Return the tip (2,) of the heavy arm at rest."""
    case = CASES["heavy_arm"]
    area, second = np.pi * case.radius**2, np.pi / 4 * case.radius**4
    weight = case.density * area * 9.81

    def rates(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        _, _, angle, moment = y
        c, sn = np.cos(angle), np.sin(angle)
        down = -weight * (case.length - s)
        stretch = 1.0 + sn * down / (case.young * area)
        shear = c * down / (case.shear * area)
        dx, dy = c * stretch - sn * shear, sn * stretch + c * shear
        return np.array([dx, dy, moment / (case.young * second), -dx * down])

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.array([a[0], a[1], a[2], b[3]])

    s = np.linspace(0.0, case.length, 41)
    y = np.zeros((4, 41))
    y[0], y[2] = s, -1.0 * s / case.length
    solution = solve_bvp(rates, ends, s, y, tol=1e-11, max_nodes=100000)
    if not solution.success:
        raise RuntimeError(solution.message)
    tip: np.ndarray = solution.y[:2, -1]
    return tip


def main() -> None:
    """Compare the package's equilibrium with it."""
    exact = planar_tip()
    print(f"boundary-value problem: tip at ({exact[0]:.9f}, {exact[1]:.9f})")
    for order, nodes in ((2, 6), (3, 8), (5, 16), (8, 40), (8, 100)):
        settings = {"order": order, "nodes": nodes, "step": 0.01}
        dynamics = Dynamics(scene_of(CASES["heavy_arm"], settings))
        tip = dynamics.node_poses(equilibrium(dynamics))[-1][:2, 3]
        error = np.linalg.norm(tip - exact) / CASES["heavy_arm"].length
        print(f"order {order}, {nodes} nodes: error {error:.1e} of the length")


if __name__ == "__main__":
    main()
