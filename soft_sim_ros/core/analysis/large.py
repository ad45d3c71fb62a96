"""Stability and slow motions of arms of many coordinates, at a cost linear in their number.

What ``small_motion.py`` asks of dense matrices is asked here of blocks (``mechanics/blocks.py``):
the number of negative directions by the law of inertia, the slowest motions by Arnoldi's method on
the inverse problem of M δq̈ + R δq̇ + K δq = 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.blocks import Blocks
from soft_sim_ros.core.mechanics.dynamics import Dynamics

from .small_motion import ASYMMETRY, NEUTRAL, Complex, scale_of

PROBES = 3
SLOWEST = 24  # motions that are looked at where the stiffness is not symmetric
# Growth less than this part of |s| may be round-off: where two frequencies meet, as in a round rod,
# entries that are off by 1e-12 move s by the root of that.
DOUBT = 1e-5


def unit_blocks(dynamics: Dynamics, stiffness: Blocks) -> Floats:
    """Return what ``small_motion.unit_scale`` does, (n,), for a stiffness that was filled in."""
    weight = dynamics.model.weight
    elastic = np.abs(dynamics.law_at_rest) / weight**2
    own = np.maximum(elastic, np.abs(stiffness.diagonal) / weight**2)
    for i in np.flatnonzero((elastic <= 0.0) & stiffness.mask):
        unit = np.zeros(len(own))
        unit[i] = 1.0
        own[i] = np.abs(stiffness.times(unit) / weight).max() / weight[i]
    return scale_of(own, weight)


def symmetric_blocks(stiffness: Blocks, scale: Floats) -> bool:
    """Return whether a stiffness is symmetric to round-off, in units of ``scale`` (n,).

    For vectors of random signs, xᵀ (K − Kᵀ) y is as large as the whole of K − Kᵀ.
    """
    rng = np.random.default_rng(0)  # the same answer every time
    x, y = (rng.choice([-1.0, 1.0], size=(PROBES, len(scale))) / scale for _ in range(2))
    for one, other in zip(x, y, strict=True):
        there, back = stiffness.times(other), stiffness.times(one)
        size = np.linalg.norm(there / scale) + np.linalg.norm(back / scale)
        if abs(one @ there - other @ back) > ASYMMETRY * size:
            return False
    return True


def negative_directions(stiffness: Blocks, scale: Floats) -> int | None:
    """Return how many directions a symmetric stiffness does not hold; None if it is singular.

    It is factored, with the little added that counts as neutral.
    """
    stiffness.add(NEUTRAL * scale**2)
    return stiffness.negative(scale) if stiffness.factor() else None


def slow_motions(
    dynamics: Dynamics, mask: NDArray[np.bool_], scale: Floats, shift: float = 0.0
) -> Complex | None:
    """Return s (k,) in 1/s of the slowest motions e^{st} about the last residual, at rest.

    None where Arnoldi's method finds none, or the matrix is singular.

    With s = s₀ + 1/σ: σ x = −(K + s₀ R + s₀² M)⁻¹ ((R + 2 s₀ M) x + M y), σ y = x.
    """
    n = dynamics.n
    held, lost, mass = (Blocks(dynamics, mask) for _ in range(3))
    held.fill((1.0, shift, shift * shift))
    lost.fill((0.0, 1.0, 2.0 * shift))
    mass.fill((0.0, 0.0, 1.0))
    if not held.factor():
        return None
    # y in units that make both halves of like size: the pace of the slowest motion
    start = np.where(mask, np.cos(np.arange(n)) / scale, 0.0)
    pace = float(np.sqrt(np.linalg.norm(scale * held.solve(mass.times(start)))))
    pace /= float(np.sqrt(np.linalg.norm(scale * start))) or 1.0

    def apply(z: Floats) -> Floats:
        x, y = z[:n] / scale, z[n:] / scale
        out = -held.solve(lost.times(x) + mass.times(y) / pace)
        return np.concatenate([out * scale, x * scale * pace])

    operator = LinearOperator((2 * n, 2 * n), matvec=apply, dtype=np.float64)
    first = np.concatenate([start * scale, start[::-1] * scale[::-1]])
    try:
        values = eigs(
            operator, k=SLOWEST, v0=first, ncv=4 * SLOWEST, return_eigenvectors=False, tol=0.0
        )
    except ArpackNoConvergence as stopped:
        values = stopped.eigenvalues
    values = values[np.abs(values) > 0.0]
    return None if not len(values) else np.asarray(shift + 1.0 / values, dtype=complex)


def growing_of(motions: Complex) -> Complex:
    """Return those that grow, beyond round-off."""
    return motions[motions.real > DOUBT * np.abs(motions)]
