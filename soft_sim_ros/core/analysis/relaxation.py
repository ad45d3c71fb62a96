"""Equilibria of arms that are held by their load only: strings and cables.

Without stiffness there is no path of equilibria from no load to the full one. The arm sinks under
the full load instead: steps against the residual, in the metric of the mass matrix, each
mode at the pace of its own stiffness (whether it holds or tips), none farther than a trust region.
"""

from __future__ import annotations

import numpy as np
import scipy

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.errors import StaticsFailed

STEPS = 300
NEAR = 1e-4  # arm lengths from where Newton's method finds the rest
FARTHEST = 0.3  # arm lengths that one step may move the tip
HELD = 1e-13  # of the largest eigenvalue: less is round-off, not stiffness
LOOSE = "nothing holds the arm there: its strings and cables need weight, or a load that pulls them"


def sink(dynamics: Dynamics, q: Floats, mask: np.ndarray, forcing: tuple, time: float) -> Floats:
    """Return q (n,) near a stable equilibrium under the full load.

    Strings and cables first turn as straight links, until the load pulls them: from there on they
    have the stiffness of their tension.

    Parameters
    ----------
    q : (n,) start
    mask : (n,) bool, coordinates that may move
    forcing : arguments of ``Dynamics.forcing``
    time : s, for the error

    Raises
    ------
    StaticsFailed
        if nothing holds the arm, or no equilibrium is reached in STEPS steps.
    """
    pivots = np.zeros_like(mask)
    pivots[[c for m in dynamics.compiled.chain.rods.values() for c in m.pivot]] = True
    for moving in (mask & pivots, mask):
        if moving.any():
            q = _sink(dynamics, q, moving, forcing, time)
    return q


def _sink(dynamics: Dynamics, q: Floats, mask: np.ndarray, forcing: tuple, time: float) -> Floats:
    q = q.copy()
    zero = np.zeros(len(q))
    unit = 1.0 / dynamics.model.weight[mask]
    radius, size = FARTHEST, np.inf
    residual = dynamics.residual(q, zero, zero, dynamics.forcing(*forcing))[mask] * unit
    for _ in range(STEPS):
        values, shapes = _modes(dynamics, mask, unit)
        drive = shapes.T @ residual
        pace = np.abs(values)
        damping = max(HELD * pace.max(), 1e-6 * np.abs(shapes @ drive).max() / radius)
        if not damping > 0.0:
            raise StaticsFailed(0.0, size, time, LOOSE)
        step = -shapes @ (drive / (pace + damping))
        while (size := float(np.abs(step).max())) > radius:
            damping *= 2.0
            step = -shapes @ (drive / (pace + damping))
        if size < NEAR and values[0] < 0.0:  # balanced on a saddle: tip off it
            step, size = NEAR * shapes[:, 0] / np.abs(shapes[:, 0]).max(), NEAR
        elif size < NEAR:
            if values[0] < HELD * pace.max():
                raise StaticsFailed(0.0, size, time, LOOSE)
            return q
        trial = q.copy()
        trial[mask] += step * unit
        after = dynamics.residual(trial, zero, zero, dynamics.forcing(*forcing))[mask] * unit
        if not np.isfinite(after).all() or step @ after > abs(step @ residual):
            radius = 0.25 * size  # it passed the minimum
            dynamics.residual(q, zero, zero, dynamics.forcing(*forcing))
            continue
        q, residual = trial, after
        radius = min(2.0 * radius, FARTHEST)
    raise StaticsFailed(0.0, size, time, f"it has not come to rest after {STEPS} steps")


def _modes(dynamics: Dynamics, mask: np.ndarray, unit: Floats) -> tuple[Floats, Floats]:
    """Return eigenvalues (m,) in 1/s², ascending, and mass-normalised modes (m, m) as columns.

    Of the symmetric part of the tangent at the last residual, coordinates in units of ``unit``.
    """
    stiffness, mass = (
        dynamics.last_tangent(alpha)[np.ix_(mask, mask)] * np.outer(unit, unit)
        for alpha in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    )
    # high orders move so little mass that rounding may make it negative; any metric will do
    mass += 1e-9 * np.diag(np.diag(mass))
    root = scipy.linalg.cholesky(0.5 * (mass + mass.T), lower=True)
    inner = scipy.linalg.solve_triangular(root, 0.5 * (stiffness + stiffness.T), lower=True)
    inner = scipy.linalg.solve_triangular(root, inner.T, lower=True)
    values, shapes = scipy.linalg.eigh(0.5 * (inner + inner.T))
    return values, scipy.linalg.solve_triangular(root, shapes, lower=True, trans="T")
