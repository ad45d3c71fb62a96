"""Limit points and bifurcations: where the stiffness along a branch of equilibria is singular."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import NoBranch

from .curve import Curve, State
from .small_motion import NEUTRAL, is_symmetric, leaving

LIMIT, BIFURCATION = "limit", "bifurcation"
LOST = 1e-6  # of the elastic stiffness: what is left of it in the directions that a point names
# Arm lengths by which the whole range of the load would push along the direction that gives way,
# had it its elastic stiffness: where the load turns round and pushes less, two branches cross.
FLAT = 1e-6

Test = Callable[[State], float]


class SpecialPoint(NamedTuple):
    """Where the stiffness is singular.

    At a ``limit`` the load has an extremum along the branch: under a dead load the arm snaps. At a
    ``bifurcation`` other branches cross: the arm buckles.
    """

    kind: str
    load: float
    q: Floats  # (n,)
    directions: Floats  # (n, m) coordinates that lose their stiffness, m ≥ 1; tip moves by about L
    after: int  # index of the last point of the branch before it


def special_points(
    curve: Curve, first: State, last: State, step: float, tolerance: float, after: int
) -> list[SpecialPoint]:
    """Return the special points of one step, in order."""
    unit = curve.unit(first.stiffness)
    scaled = [x.stiffness / np.outer(unit, unit) for x in (first, last)]
    symmetric = all(is_symmetric(x) for x in scaled)

    def at(d: float) -> State | None:
        if d <= 0.0 or d >= step:
            return first if d <= 0.0 else last
        return curve.correct(first.u + d * first.tangent, first.tangent, tolerance)

    def spectrum(stiffness: Floats) -> Floats:
        return _spectrum(stiffness / np.outer(unit, unit), symmetric)

    before, behind = (
        leaving(x) if symmetric else int(np.count_nonzero(_spectrum(x, False) < -NEUTRAL))
        for x in scaled
    )
    tests: list[Test] = [
        lambda state, i=i: float(spectrum(state.stiffness)[i])  # type: ignore[misc]
        for i in range(min(before, behind), max(before, behind))
    ]
    if first.tangent[-1] * last.tangent[-1] < 0.0:
        tests.append(lambda state: float(state.tangent[-1]))
    places = [_root(at, lambda u, t: curve.correct(u, t, tolerance), test, step) for test in tests]
    special: list[SpecialPoint] = []
    previous = -np.inf
    for place in sorted(places, key=lambda place: place.d):
        if place.d - previous > 1e-3 * step:
            special.append(_special(curve, place, after))
        previous = place.d
    return special


def _spectrum(stiffness: Floats, symmetric: bool) -> Floats:
    """Return numbers that change sign where the stiffness becomes singular.

    All eigenvalues, ascending; or, without symmetry, ± the least singular value with the sign of
    the determinant.
    """
    if symmetric:
        return np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))
    sign = np.linalg.slogdet(stiffness)[0]
    return np.array([sign * np.linalg.svd(stiffness, compute_uv=False)[-1]])


class Place(NamedTuple):
    """Where a test value is zero."""

    d: float  # arc length from the beginning of the step
    u: Floats  # (n + 1,)
    turns: bool  # whether the load has an extremum there along the branch


def _root(
    at: Callable[[float], State | None],
    polish: Callable[[Floats, Floats], State | None],
    test: Test,
    step: float,
) -> Place:
    """Return where a test value is zero.

    Very near a bifurcation the corrector has no one way to go. So the root is found roughly, and
    then laid on the straight line between two points at a small distance on either side, and
    polished by the corrector if it can.
    """

    def value(d: float) -> float:
        state = at(d)
        return 0.0 if state is None else test(state)

    ends = value(0.0), value(step)
    if ends[0] * ends[1] >= 0.0:  # zero to round-off at one end
        d = 0.0 if abs(ends[0]) < abs(ends[1]) else step
    else:
        d = float(brentq(value, 0.0, step, xtol=1e-6 * step))
    near = max(1e-4 * step, 1e-6)
    one, other = at(max(d - near, 0.0)), at(min(d + near, step))
    if one is None or other is None:
        raise NoBranch(float("nan"), "the corrector fails beside a special point")
    a, b = test(one), test(other)
    share = a / (a - b) if a != b else 0.5
    u = one.u + share * (other.u - one.u)
    exact = polish(u, one.tangent)
    # what the straight line may miss; more is a corrector gone astray along what is singular
    allowed = 100.0 * near * near + 1e-9
    if exact is not None and np.abs(exact.u - u).max() <= allowed:
        u = exact.u
    # at an end of the step only one side is seen
    turns = not near < d < step - near or one.tangent[-1] * other.tangent[-1] < 0.0
    return Place(d, u, turns)


def _special(curve: Curve, place: Place, after: int) -> SpecialPoint:
    """Return what kind of point a place is, where the stiffness is singular.

    With ℓᵀ K = 0, K q′ + r_λ λ′ = 0 along the branch says ℓᵀ r_λ λ′ = 0: at a limit λ′ = 0 and the
    load pushes along what gives way, ℓᵀ r_λ ≠ 0; where λ′ has one sign before and behind,
    ℓᵀ r_λ = 0 and branches cross. They do so, too, where λ′ changes its sign but nothing pushes:
    the branch that was followed is then the one that buckled.
    """
    _, stiffness, slope = curve.matrices(place.u)
    unit = curve.unit(stiffness)
    left, sizes, right = np.linalg.svd(stiffness / np.outer(unit, unit))
    lost = sizes < LOST
    lost[-1] = True
    ways = right[lost].T / unit[:, None]  # in arm lengths
    push = np.abs(left[:, lost].T @ (slope / unit)) * np.abs(ways).max(axis=0)
    kind = LIMIT if place.turns and push.max() > FLAT else BIFURCATION
    q, load = curve.split(place.u)
    ways = ways / np.linalg.norm(ways, axis=0)
    return SpecialPoint(kind, load, q, ways * curve.scale[:-1, None], after)
