"""Limit points and bifurcations: where the stiffness along a branch of equilibria is singular."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from ..errors import NoBranch
from .curve import Curve, State
from .model import Floats

LIMIT, BIFURCATION = "limit", "bifurcation"
NEUTRAL = 1e-10  # of the largest eigenvalue: below it a direction costs no energy
# Arm lengths by which the whole range of the load may push along a direction that buckles, were it
# as stiff as the next one: beyond that it is a limit point.
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
    symmetric = _is_symmetric(first.stiffness) and _is_symmetric(last.stiffness)
    size = np.abs(first.stiffness).max()

    def at(d: float) -> State | None:
        if d <= 0.0 or d >= step:
            return first if d <= 0.0 else last
        return curve.correct(first.u + d * first.tangent, first.tangent, tolerance)

    before, behind = (
        int(np.count_nonzero(_spectrum(x.stiffness, symmetric) < -NEUTRAL * size))
        for x in (first, last)
    )
    tests: list[Test] = [
        lambda state, i=i: float(_spectrum(state.stiffness, symmetric)[i])  # type: ignore[misc]
        for i in range(min(before, behind), max(before, behind))
    ]
    if first.tangent[-1] * last.tangent[-1] < 0.0:
        tests.append(lambda state: float(state.tangent[-1]))
    places = [_root(at, lambda u, t: curve.correct(u, t, tolerance), test, step) for test in tests]
    special: list[SpecialPoint] = []
    previous = -np.inf
    for d, u in sorted(places, key=lambda place: place[0]):
        if d - previous > 1e-3 * step:
            special.append(_special(curve, u, after))
        previous = d
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


def _is_symmetric(stiffness: Floats) -> bool:
    return bool(np.abs(stiffness - stiffness.T).max() < 1e-9 * np.abs(stiffness).max())


def _root(
    at: Callable[[float], State | None],
    polish: Callable[[Floats, Floats], State | None],
    test: Test,
    step: float,
) -> tuple[float, Floats]:
    """Return where a test value is zero: arc length, and the point u (n + 1,).

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
    return d, u if exact is None or np.abs(exact.u - u).max() > allowed else exact.u


def _special(curve: Curve, u: Floats, after: int) -> SpecialPoint:
    """Return what kind of point u is, where the stiffness is singular."""
    _, stiffness, slope = curve.matrices(u)
    left, sizes, right = np.linalg.svd(stiffness)
    lost = sizes < 1e-6 * sizes[0]
    lost[-1] = True
    weights = np.outer(curve.scale[:-1], curve.scale[:-1])
    law = curve.dynamics.stiffness_matrix() * weights
    next_stiffness = sizes[~lost][-1] if not lost.all() else np.abs(law).max()
    push = np.abs(left[:, lost].T @ slope).max()
    kind = LIMIT if push > FLAT * next_stiffness else BIFURCATION
    q, load = curve.split(u)
    return SpecialPoint(kind, load, q, right[lost].T * curve.scale[:-1, None], after)
