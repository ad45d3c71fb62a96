"""Small motions M δq̈ + R δq̇ + K δq = 0 about a state of rest: how they grow, and how surely.

In coordinates in which every elastic stiffness is 1, K reads like 1 − P/P_cr, whatever part of it
is stretch and whatever bending. There the inverse problem is solved: with M = C Cᵀ, s = s₀ + 1/σ,

    ⎡ −K⁻¹ R   −K⁻¹ C ⎤ ⎡ x ⎤     ⎡ x ⎤
    ⎣    Cᵀ       0    ⎦ ⎣ y ⎦ = σ ⎣ y ⎦ ,

whose largest σ are the slowest motions: these come out to round-off, and the fastest, 10⁶ times
faster in a slender rod, to 10⁻¹⁰ of themselves. Without damping and with K = 1 the matrix is skew,
hence as well conditioned as can be.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from soft_sim_ros.core.floats import Floats

Complex = NDArray[np.complex128]
EPS = float(np.finfo(float).eps)
# What an entry of K, R or M, a sum over many segments, is off by, over the root of the diagonal
# entries that belong to it.
NOISE = 1e-12
ASYMMETRY = 1e-11  # of the stiffness of two coordinates: less is round-off
NEUTRAL = 1e-10  # of the elastic stiffness: less is no direction that leaves, nor one that holds
SINGULAR = 1e-12


class Motions(NamedTuple):
    """All 2n small motions δq = Re(x e^{st})."""

    values: Complex  # (2n,) s in 1/s
    shapes: Complex  # (n, 2n) x
    doubts: Floats  # (2n,) what round-off may have changed s by, 1/s

    @property
    def growing(self) -> NDArray[np.bool_]:
        """Which of them grow, beyond round-off (2n,)."""
        return np.asarray(self.values.real > self.doubts)


def unit_scale(stiffness: Floats, law: Floats, weight: Floats) -> Floats:
    """Return d (n,): K / (d dᵀ) is the stiffness in coordinates of elastic stiffness 1.

    A coordinate that its load holds more than its own elasticity counts by that, and one that has
    no elasticity by the largest stiffness that couples it, all coordinates taken as displacements.

    Parameters
    ----------
    stiffness : (n, n) K
    law : (n,) the elastic part of its diagonal
    weight : (n,) how far a unit of each coordinate may move the tip
    """
    sizes = np.abs(stiffness) / np.outer(weight, weight)
    elastic = np.abs(law) / weight**2
    own = np.maximum(elastic, np.diag(sizes))
    loose = elastic <= 0.0
    own[loose] = sizes.max(axis=1)[loose]
    return scale_of(own, weight)


def scale_of(own: Floats, weight: Floats) -> Floats:
    """Return d (n,) for stiffnesses ``own`` (n,) of displacements; none counts as the least."""
    free = ~(own > 0.0)
    own[free] = 1.0 if free.all() else own[~free].min()
    return np.asarray(weight * np.sqrt(own))


def is_symmetric(scaled: Floats) -> bool:
    """Return whether a stiffness in units of ``unit_scale`` is symmetric to round-off."""
    return bool(np.abs(scaled - scaled.T).max(initial=0.0) <= ASYMMETRY * _size(scaled))


def leaving(scaled: Floats) -> int:
    """Return how many directions a symmetric stiffness (n, n) in those units does not hold."""
    lowest = np.linalg.eigvalsh(0.5 * (scaled + scaled.T))
    return int(np.count_nonzero(lowest < -NEUTRAL * _size(scaled)))


def _size(scaled: Floats) -> float:
    return max(1.0, float(np.abs(scaled).max(initial=0.0)))


def real_modes(stiffness: Floats, mass: Floats, scale: Floats) -> tuple[Floats, Floats]:
    """Return ω (n,) in rad/s, ascending, and φ (n, n) with φᵀ M φ = 1, of M δq̈ + K δq = 0.

    Of the symmetric part of K. What leaves as e^{st} has ω = −s. The slowest come out to round-off,
    the fastest to that times their ratio: 1/ω are the singular values of L⁻¹ C with K = L Lᵀ.
    """
    unit = np.outer(scale, scale)
    stiffness, mass = (0.5 * (x + x.T) / unit for x in (stiffness, mass))
    root = _root(mass)
    # where K does not hold, it is held by so much mass times this, and that is taken off again
    held, begin, heaviest = _try_root(stiffness), 0.0, float(np.linalg.norm(mass, 2))
    while held is None:
        begin = 10.0 * begin if begin > 0.0 else 1e-2 / heaviest
        held = _try_root(stiffness + begin * mass)
    left, inverse, _ = np.linalg.svd(np.linalg.solve(held, root))
    inverse = np.maximum(inverse, EPS * EPS * inverse[:1])
    squares = 1.0 / inverse**2 - begin
    shapes = np.linalg.solve(held.T, left / inverse) / scale[:, None]
    return np.sign(squares) * np.sqrt(np.abs(squares)), shapes


def _try_root(matrix: Floats) -> Floats | None:
    """Return L with matrix = L Lᵀ, None if it is not surely positive definite."""
    try:
        root = np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return None
    least = np.diag(root).min(initial=1.0)
    return np.asarray(root) if least**2 > NEUTRAL else None


def all_decay(stiffness: Floats, damping: Floats, mass: Floats, scale: Floats) -> bool:
    """Return whether no motion of ``small_motions`` grows at all, so that no doubt need be known.

    Without shapes, which cost some times as much. Without damping something always grows by
    round-off: then this says nothing.
    """
    if len(scale) == 0 or not damping.any():
        return len(scale) == 0
    inverse = _inverse_problem(stiffness, damping, mass, scale)
    found = scipy.linalg.eigvals(inverse.matrix, check_finite=False)
    return bool((_values(inverse, found).real <= 0.0).all())


def small_motions(stiffness: Floats, damping: Floats, mass: Floats, scale: Floats) -> Motions:
    """Return all motions of M δq̈ + R δq̇ + K δq = 0.

    Parameters
    ----------
    stiffness, damping, mass : (n, n) K, R, M; M is symmetric, K and R need not be
    scale : (n,) of ``unit_scale``

    Notes
    -----
    The doubt is the perturbation bound |yᴴ δQ x| / |yᴴ Q'(s) x| of Q(s) = s² M + s R + K, for
    entries that are off by NOISE, and that of the matrix above for round-off in its eigenvalues.
    For two frequencies that coincide, as those of a round rod, either is large as soon as nothing
    but round-off keeps them apart.
    """
    n = len(scale)
    if n == 0:
        return Motions(np.zeros(0, complex), np.zeros((0, 0), complex), np.zeros(0))
    problem = _inverse_problem(stiffness, damping, mass, scale)
    found = scipy.linalg.eig(problem.matrix, left=True, right=True, check_finite=False)
    inverse, left, right_vectors = (np.asarray(x, dtype=complex) for x in found)
    inverse = _some(inverse)
    values = _values(problem, inverse)
    shapes = right_vectors[:n]
    with np.errstate(divide="ignore", over="ignore"):
        condition = 1.0 / np.abs(np.sum(left.conj() * right_vectors, axis=0))
        doubts = 10.0 * n * EPS * condition / (problem.pace * np.abs(inverse) ** 2)
    y = scipy.linalg.lu_solve(problem.factors, left[:n], trans=2, check_finite=False)
    scaled = problem.stiffness, problem.damping, problem.mass
    doubts = doubts + _entries(*scaled, values, shapes, y)
    return Motions(values, np.asarray(shapes / scale[:, None], dtype=complex), doubts)


class _Inverse(NamedTuple):
    """The inverse problem: its matrix (2n, 2n) over ``pace``, and what it was made of."""

    matrix: Floats
    pace: float
    begin: float
    factors: tuple[Floats, NDArray[np.int32]]
    stiffness: Floats
    damping: Floats
    mass: Floats


def _inverse_problem(stiffness: Floats, damping: Floats, mass: Floats, scale: Floats) -> _Inverse:
    n = len(scale)
    unit = np.outer(scale, scale)
    stiffness, damping = stiffness / unit, damping / unit
    mass = 0.5 * (mass + mass.T) / unit
    root = _root(mass)
    begin = _shift(stiffness, mass)
    held = stiffness + begin * damping + begin**2 * mass
    lost = damping + 2.0 * begin * mass
    factors = scipy.linalg.lu_factor(held, check_finite=False)
    right = scipy.linalg.lu_solve(factors, np.hstack([lost, root]), check_finite=False)
    matrix = np.block([[-right[:, :n], -right[:, n:]], [root.T, np.zeros((n, n))]])
    pace = float(np.linalg.norm(matrix, 2)) or 1.0
    return _Inverse(matrix / pace, pace, begin, factors, stiffness, damping, mass)


def _values(problem: _Inverse, inverse: NDArray) -> Complex:
    """Return s (2n,) in 1/s of the eigenvalues of the inverse problem."""
    return np.asarray(problem.begin + 1.0 / (problem.pace * _some(inverse)), dtype=complex)


def _some(inverse: NDArray) -> Complex:
    """Return eigenvalues none of which is zero: what has no mass falls back at once."""
    tiny = EPS * EPS
    return np.asarray(np.where(np.abs(inverse) < tiny, -tiny, inverse), dtype=complex)


def _entries(
    stiffness: Floats, damping: Floats, mass: Floats, values: Complex, x: Complex, y: Complex
) -> Floats:
    """Return what entries of K, R, M that are off by NOISE change each s by."""

    def off(x: Complex, y: Complex, matrix: Floats, least: float) -> Floats:
        own = np.sqrt(np.maximum(np.abs(np.diag(matrix)), least))[:, None]
        return np.asarray((np.abs(y) * own).sum(axis=0) * (np.abs(x) * own).sum(axis=0))

    size = np.abs(values)
    change = off(x, y, stiffness, 1.0)
    change = change + size * off(x, y, damping, 0.0) + size**2 * off(x, y, mass, 0.0)
    slope = np.abs(np.sum(y.conj() * (2.0 * (mass @ x) * values + damping @ x), axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.nan_to_num(NOISE * change / slope, nan=np.inf))


def _root(mass: Floats) -> Floats:
    """Return C with M = C Cᵀ; a mass that round-off makes negative is made the least positive."""
    own = np.abs(np.diag(mass))
    for slack in (0.0, EPS, 1e2 * EPS, 1e4 * EPS, 1e6 * EPS):
        try:
            return np.asarray(np.linalg.cholesky(mass + slack * len(mass) * np.diag(own)))
        except np.linalg.LinAlgError:
            continue
    values, vectors = np.linalg.eigh(mass)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _shift(stiffness: Floats, mass: Floats) -> float:
    """Return s₀ in 1/s: 0, or where K is singular a tenth of the slowest pace that there is."""
    sizes = np.linalg.svd(stiffness, compute_uv=False)
    if sizes[-1] > SINGULAR * sizes[0]:
        return 0.0
    heaviest = float(np.linalg.norm(mass, 2))
    return 0.1 / np.sqrt(heaviest) if heaviest > 0.0 else 0.0
