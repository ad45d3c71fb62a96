"""Dynamics of a case in absolute coordinates, by the method of lines and scipy's Radau.

Unknowns are positions and unit quaternions of points along the rod, and their velocities in world
and section axes: no strains, no joints, no recursion, no basis. A staggered grid, second order: n
cells; positions at the cell ends, frames in the middles (so the clamp is half a cell away from the
first frame and bending there sees half a cell). Three grids and Richardson's extrapolation in h²
give the value and, from the last two, an idea of its error.

    python -m benchmarks.independent.absolute [case …]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import csr_matrix

from ..cases import CASES, Case
from ..reference import distance, load

DAMPED = ("planar_pcs", "release_3d")


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a × b for arrays (3, m)."""
    return np.array([
        a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
    ])  # fmt: skip


def rotations(p: np.ndarray) -> np.ndarray:
    """Return rotation matrices (3, 3, m) of quaternions w x y z (4, m), normalised here."""
    w, x, y, z = p / np.sqrt(np.sum(p * p, axis=0))
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def between(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the rotation vectors (3, m) that turn frames p into q, in the axes of p."""
    w = np.sum(p * q, axis=0)
    v = p[0] * q[1:] - q[0] * p[1:] - cross(p[1:], q[1:])
    size = np.sqrt(np.sum(v * v, axis=0)) + 1e-300
    return 2.0 * np.arctan2(size, w) / size * v


class Grid:
    """One clamped case on n cells; the state is r (3, n), p (4, n), ṙ (3, n), ω (3, n).

    ``reference`` is the curvature vector (3,) of the rod without loads, in 1/m.
    """

    def __init__(self, case: Case, n: int, reference: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        if case.hinge or case.moments or case.tendon:
            raise ValueError(f"{case.name}: only clamped cases without actuators")
        self.case, self.n, self.h = case, n, case.length / n
        r = case.radius
        area, second = np.pi * r**2, np.pi / 4 * r**4
        e, g, eta = case.young, case.shear, case.viscosity
        self.reference = np.array(reference, dtype=float)[:, None]
        column = lambda *x: np.array(x)[:, None]  # noqa: E731
        self.bend, self.bend_v = (
            column(2 * a * second, b * second, b * second) for a, b in ((g, e), (eta, 3 * eta))
        )
        self.pull, self.pull_v = (
            column(b * area, a * area, a * area) for a, b in ((g, e), (eta, 3 * eta))
        )
        self.mass = np.full(n, case.density * area * self.h)
        self.mass[-1] *= 0.5
        self.inertia = case.density * self.h * column(2 * second, second, second)
        self.gravity = np.array(case.gravity)[:, None]
        # distances between frames; the clamp is half a cell before the first
        self.gap = np.full(n, self.h)
        self.gap[0] = 0.5 * self.h

    def start(self) -> np.ndarray:
        """Return the state of uniform strain ``offset`` at rest."""
        kappa = np.array(self.case.offset[:3]) + self.reference[:, 0]
        size = np.linalg.norm(kappa) + 1e-300
        p = np.zeros((4, self.n))
        middles = self.h * (np.arange(self.n) + 0.5)
        p[0] = np.cos(0.5 * size * middles)
        p[1:] = np.sin(0.5 * size * middles) * (kappa / size)[:, None]
        ends = self.h * (np.arange(self.n) + 1.0)
        hat = -np.cross(np.eye(3), kappa).T
        if not kappa.any():
            r = np.array([ends, 0 * ends, 0 * ends])
            return np.concatenate([r.ravel(), p.ravel(), np.zeros(6 * self.n)])
        r = np.array([
            (s * np.eye(3) + (1 - np.cos(size * s)) / size**2 * hat
             + (size * s - np.sin(size * s)) / size**3 * hat @ hat)[:, 0]
            for s in ends
        ]).T  # fmt: skip
        return np.concatenate([r.ravel(), p.ravel(), np.zeros(6 * self.n)])

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return ẏ."""
        n, h = self.n, self.h
        r, p = y[: 3 * n].reshape(3, n), y[3 * n : 7 * n].reshape(4, n)
        v, w = y[7 * n : 10 * n].reshape(3, n), y[10 * n :].reshape(3, n)
        turn = rotations(p)
        zero = np.zeros((3, 1))
        slope = np.diff(np.hstack([zero, r]), axis=1) / h
        speed = np.diff(np.hstack([zero, v]), axis=1) / h
        gamma = np.einsum("jik,jk->ik", turn, slope)
        gamma_rate = np.einsum("jik,jk->ik", turn, speed) - cross(w, gamma)
        rest = np.array([[1.0], [0.0], [0.0]])
        force = self.pull * (gamma - rest) + self.pull_v * gamma_rate
        world = np.einsum("ijk,jk->ik", turn, force)
        before = np.hstack([np.array([[1.0], [0], [0], [0]]), p[:, :-1]])
        angle = between(before, p)
        kappa = angle / self.gap
        w_before = np.hstack([zero, w[:, :-1]])
        # rate of the rotation vector, to second order: difference of ω plus the turn between them
        kappa_rate = (w - w_before) / self.gap + cross(kappa, 0.5 * (w + w_before))
        moment = self.bend * (kappa - self.reference) + self.bend_v * kappa_rate
        # the joint moment acts on both frames, half a turn away from each
        back = moment + 0.5 * cross(angle, moment)
        forth = moment - 0.5 * cross(angle, moment)
        torque = shifted(back) - forth
        torque += h * cross(gamma, force) - cross(w, self.inertia * w)
        push = shifted(world) - world + self.mass * self.gravity
        spin = 0.5 * np.array([
            -p[1] * w[0] - p[2] * w[1] - p[3] * w[2],
            p[0] * w[0] + p[2] * w[2] - p[3] * w[1],
            p[0] * w[1] - p[1] * w[2] + p[3] * w[0],
            p[0] * w[2] + p[1] * w[1] - p[2] * w[0],
        ])  # fmt: skip
        return np.concatenate([
            v.ravel(), spin.ravel(), (push / self.mass).ravel(), (torque / self.inertia).ravel(),
        ])  # fmt: skip

    def pattern(self) -> csr_matrix:
        """Return which rates depend on which unknowns: neighbours only."""
        n = self.n
        near = (np.abs(np.subtract.outer(np.arange(n), np.arange(n))) <= 1).astype(int)
        return csr_matrix(np.kron(np.ones((13, 13), dtype=int), near))

    def tip(self, rtol: float) -> np.ndarray:
        """Return the tip (outputs, 3)."""
        case = self.case
        times = case.output_period * np.arange(1, case.outputs + 1)
        solution = solve_ivp(
            self.rates, (0.0, case.duration), self.start(), method="Radau", t_eval=times,
            rtol=rtol, atol=1e-3 * rtol, jac_sparsity=self.pattern(),
        )  # fmt: skip
        if not solution.success:
            raise RuntimeError(solution.message)
        return solution.y[[self.n - 1, 2 * self.n - 1, 3 * self.n - 1]].T


def shifted(flow: np.ndarray) -> np.ndarray:
    """Return what comes from the next cell; nothing beyond the tip."""
    return np.hstack([flow[:, 1:], np.zeros((3, 1))])


def extrapolated(
    case: Case, n: int, rtol: float, reference: Sequence[float] = (0.0, 0.0, 0.0)
) -> tuple[np.ndarray, float]:
    """Return the tip from grids n, 2n, 4n, extrapolated twice, and the last correction."""
    a, b, c = (Grid(case, k * n, reference).tip(rtol) for k in (1, 2, 4))
    one, two = b + (b - a) / 3.0, c + (c - b) / 3.0
    return two + (two - one) / 15.0, distance(two, one, case.length)


def main() -> None:
    """Compare the references of some cases, shortened, with this formulation."""
    for name in sys.argv[1:] or DAMPED:
        case = CASES[name]
        share = min(1.0, 0.3 / case.duration)
        outputs = round(case.outputs * share)
        short = replace(case, duration=outputs * case.output_period, outputs=outputs)
        begin = time.perf_counter()
        tip, correction = extrapolated(short, 12, 1e-7)
        error = distance(load(case)[0][:outputs], tip, case.length)
        print(
            f"{name}: first {short.duration:g} s, reference against absolute coordinates: "
            f"{error:.1e} of the length (last correction of the extrapolation {correction:.1e}, "
            f"{time.perf_counter() - begin:.0f} s)",
            flush=True,
        )


if __name__ == "__main__":
    main()
