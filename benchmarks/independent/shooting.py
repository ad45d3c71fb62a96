"""Statics of a rod in space as a boundary-value problem in world axes, by shooting (scipy).

Unknown is the moment at the clamp; position, quaternion and moment are integrated along the rod
with DOP853. Weight and wrenches are dead. Nothing is shared with the package: other unknowns, other
equations, no basis.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import root
from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Rod:
    """A uniform rod that begins along x at the origin, where it is clamped.

    lengths : m of the stretches at whose ends wrenches act
    stiffness : (6,) of torsion, bending about y and z (N·m²), stretch and shear (N)
    weight : (3,) N/m along world axes
    wrenches : (stretches, 6) moment N·m and force N at the ends, along world axes
    curvature : (3,) 1/m at rest, about the section's axes
    """

    lengths: tuple[float, ...]
    stiffness: Floats
    weight: Floats
    wrenches: Floats
    curvature: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def force(self, stretch: int, s: float) -> Floats:
        """Return the internal force (3,) at arc length s, along world axes."""
        beyond: Floats = self.weight * (sum(self.lengths) - s)
        return beyond + self.wrenches[stretch:, 3:].sum(axis=0)

    def rates(self, s: float, y: Floats, stretch: int) -> Floats:
        """Return the derivatives along s of position (3), quaternion (4) and moment (3)."""
        quaternion = y[3:7] / np.linalg.norm(y[3:7])
        turn = Rotation.from_quat(quaternion).as_matrix()
        force = self.force(stretch, s)
        bent = turn.T @ y[7:10] / self.stiffness[:3] + self.curvature
        drawn = turn @ (turn.T @ force / self.stiffness[3:] + [1.0, 0.0, 0.0])
        vector, scalar = quaternion[:3], quaternion[3]
        spin = 0.5 * np.append(scalar * bent + np.cross(vector, bent), -vector @ bent)
        return np.concatenate([drawn, spin, -np.cross(drawn, force)])


def march(rod: Rod, moment: Floats, stations: list[Floats]) -> tuple[list[Floats], Floats]:
    """Integrate from the clamp with a moment (3,) there.

    Returns positions and quaternions (stations, 7) of every stretch, and the moment (3,) that is
    left over at the tip.
    """
    y = np.concatenate([np.zeros(6), [1.0], moment])
    out, begin = [], 0.0
    for stretch, length in enumerate(rod.lengths):
        ends = (begin, begin + length)
        solution = solve_ivp(
            rod.rates, ends, y, method="DOP853", rtol=1e-12, atol=1e-13, args=(stretch,),
            dense_output=len(stations[stretch]) > 0,
        )  # fmt: skip
        if len(stations[stretch]):
            out.append(solution.sol(stations[stretch])[:7].T)
        y = solution.y[:, -1].copy()
        y[7:10] -= rod.wrenches[stretch, :3]
        begin += length
    return out, y[7:10]


def solve(rod: Rod, stations: list[Floats], steps: int = 4) -> list[Floats]:
    """Return positions and quaternions (stations, 7) of every stretch; all loads grow together.

    stations : arc lengths from the clamp in m, those of every stretch rising, not beyond its end
    """
    none: list[Floats] = [np.zeros(0)] * len(rod.lengths)
    moment = np.zeros(3)
    for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
        part = replace(rod, weight=share * rod.weight, wrenches=share * rod.wrenches)
        guess = moment * share / (share - 1.0 / steps) if moment.any() else moment
        found = root(lambda m, part=part: march(part, m, none)[1], guess, tol=1e-13)
        size = float(np.abs(found.fun).max())
        if size > 1e-10 * max(1.0, float(np.abs(found.x).max())):
            raise RuntimeError(f"shooting stopped at {share:.2f} of the load: {found.message}")
        moment = found.x
    return march(rod, moment, stations)[0]
