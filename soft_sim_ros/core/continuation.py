"""Branches of equilibria r(q, λ) = 0, followed by pseudo-arclength through limit points.

In u = (w q, λ / range), where w q is in arm lengths at the tip, a step of length d along the
tangent t from u₀ is corrected by Newton's method on

    r(q, λ) = 0,    tᵀ (u − u₀) = d,

whose matrix, K bordered by ∂r/∂λ and tᵀ, is regular at limit points, where K alone is not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from ..errors import NoBranch
from .dynamics import Dynamics
from .kernels.newton import CONVERGED, REASONS, admissible
from .load_path import LoadPath
from .model import Data, Floats
from .statics import unstable_directions

LIMIT, BIFURCATION = "limit", "bifurcation"
NEUTRAL = 1e-10  # of the largest eigenvalue: below it a direction costs no energy
# Arm lengths by which the whole range of the load may push along a direction that buckles, were it
# as stiff as the next one: beyond that it is a limit point.
FLAT = 1e-6
LARGEST_TURN = 0.3  # rad that the tangent may turn in one step
MIN_STEP = 1e-7
SHIFT = 1e-3  # of the range of λ, in difference quotients
ITERATIONS = 12


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


@dataclass(frozen=True, eq=False)
class Branch:
    """Equilibria along a branch.

    Parameters
    ----------
    loads : (P,) λ
    q : (P, n) coordinates
    unstable : (P,) number of directions in which the arm leaves the equilibrium without swinging
    special : limit points and bifurcations, in order
    ended_by : ``load`` (the end of the range was met), ``steps`` or ``refused: …``
    """

    loads: Floats
    q: Floats
    unstable: np.ndarray
    special: tuple[SpecialPoint, ...]
    ended_by: str

    def of_kind(self, kind: str) -> list[SpecialPoint]:
        """Return the special points of one kind."""
        return [point for point in self.special if point.kind == kind]


class _State(NamedTuple):
    """A point on a branch, scaled."""

    u: Floats  # (n + 1,)
    tangent: Floats  # (n + 1,) of unit length
    stiffness: Floats  # (n, n)
    slope: Floats  # (n,) ∂r/∂λ
    iterations: int


Test = Callable[[_State], float]


class _Curve:
    """The curve r(u) = 0 in scaled unknowns."""

    def __init__(self, dynamics: Dynamics, path: LoadPath, within: tuple[float, float]) -> None:
        low, high = within
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            raise ValueError(f"within = {within!r}: expected two finite loads, low < high")
        self.dynamics, self.path, self.within = dynamics, path, (float(low), float(high))
        self.range = high - low
        self.scale = np.append(1.0 / dynamics.model.weight, self.range)
        self.zero = np.zeros(dynamics.n)
        self.why = ""

    def split(self, u: Floats) -> tuple[Floats, float]:
        whole = u * self.scale
        return whole[:-1], float(whole[-1])

    def residual(self, u: Floats) -> Floats:
        q, load = self.split(u)
        data = self.path(load)
        return self.dynamics.residual(q, self.zero, self.zero, data) * self.scale[:-1]

    def matrices(self, u: Floats) -> tuple[Floats, Floats, Floats]:
        """Return r, ∂r/∂(w q), ∂r/∂(λ/range) in scaled rows; exact for loads linear in λ."""
        shift = np.zeros(len(u))
        shift[-1] = SHIFT
        slope = (self.residual(u + shift) - self.residual(u - shift)) / (2.0 * SHIFT)
        residual = self.residual(u)
        stiffness = self.dynamics.last_tangent((1.0, 0.0, 0.0))
        return residual, stiffness * np.outer(self.scale[:-1], self.scale[:-1]), slope

    def correct(self, guess: Floats, tangent: Floats, tolerance: float) -> _State | None:
        """Return the point in the plane through ``guess`` across ``tangent``, or None."""
        u = guess.copy()
        before = np.inf
        for iteration in range(ITERATIONS):
            residual, stiffness, slope = self.matrices(u)
            matrix = np.vstack([np.column_stack([stiffness, slope]), tangent])
            if not (np.isfinite(matrix).all() and np.isfinite(residual).all()):
                self.why = "it is not finite"
                return None
            # least squares: a direction that costs no energy at all is left alone
            wrong = np.append(residual, tangent @ (u - guess))
            rows = np.abs(matrix).max(axis=1)
            step = np.linalg.lstsq(matrix / rows[:, None], wrong / rows, rcond=1e-13)[0]
            u -= step
            size = float(np.abs(step).max())
            if size <= tolerance:
                return self._accept(u, tangent, iteration + 1)
            if not size < 2.0 * before:
                break
            before = size
        self.why = "Newton's method does not converge"
        return None

    def _accept(self, u: Floats, tangent: Floats, iterations: int) -> _State | None:
        _, stiffness, slope = self.matrices(u)
        status = admissible(self.dynamics.model, self.path_data(u))
        if status != CONVERGED:
            self.why = REASONS[status]
            return None
        matrix = np.vstack([np.column_stack([stiffness, slope]), tangent])
        rows = np.abs(matrix).max(axis=1)
        ahead = np.zeros(len(u))
        ahead[-1] = 1.0 / rows[-1]
        new = np.linalg.lstsq(matrix / rows[:, None], ahead, rcond=1e-13)[0]
        new /= np.linalg.norm(new)
        return _State(u, new, stiffness, slope, iterations)

    def path_data(self, u: Floats) -> Data:
        """Return the scratch of a sweep at u."""
        q, load = self.split(u)
        data = self.path(load)
        self.dynamics.residual(q, self.zero, self.zero, data)
        return data


def follow(
    dynamics: Dynamics,
    path: LoadPath,
    q: Floats,
    load: float = 0.0,
    *,
    within: tuple[float, float],
    downwards: bool = False,
    steps: int = 300,
    step: float = 0.02,
    max_step: float = 0.1,
    tolerance: float = 1e-11,
) -> Branch:
    """Follow the branch of equilibria through (q, load).

    Parameters
    ----------
    path : what grows with λ, see ``load_path``
    q : (n,) where to look for the first equilibrium, at λ = ``load``
    within : λ between which the branch is followed; it ends exactly on either
    downwards : set out towards smaller λ
    steps : largest number of points
    step, max_step : first and largest arc length of a step; 1 is an arm length at the tip, or the
        whole range of λ
    tolerance : largest last correction, likewise

    Raises
    ------
    NoBranch
        if there is no equilibrium near (q, load) to set out from.

    Notes
    -----
    A step is shortened where the branch turns by more than 0.3 rad or Newton's method fails; if
    it cannot be made, the branch so far is returned with ``ended_by`` = "refused: …". Stability
    is static stability, under dead loads and loads that follow (``complex_modes`` sees flutter).
    """
    curve = _Curve(dynamics, path, within)
    vertical = np.append(np.zeros(dynamics.n), -1.0 if downwards else 1.0)
    start = curve.correct(np.append(q, load) / curve.scale, vertical, tolerance)
    if start is None:
        raise NoBranch(load, f"no equilibrium near the coordinates given: {curve.why}")
    return _march(curve, start, steps, step, max_step, tolerance)


def switch(
    dynamics: Dynamics,
    path: LoadPath,
    point: SpecialPoint,
    *,
    within: tuple[float, float],
    direction: Floats | None = None,
    offset: float = 0.02,
    steps: int = 300,
    max_step: float = 0.1,
    tolerance: float = 1e-11,
) -> Branch:
    """Follow the other branch through a bifurcation.

    Parameters
    ----------
    point : the bifurcation
    direction : (n,) where to; the first of ``point.directions`` by default, and minus it leads to
        the other half of the branch
    offset : arc length of the first step

    Raises
    ------
    NoBranch
        if no other branch is found in that direction.
    """
    curve = _Curve(dynamics, path, within)
    aside = np.append(point.directions[:, 0] if direction is None else direction, 0.0) / curve.scale
    aside /= np.linalg.norm(aside)
    origin = np.append(point.q, point.load) / curve.scale
    start = curve.correct(origin + offset * aside, aside, tolerance)
    if start is None:
        raise NoBranch(point.load, f"nothing in that direction: {curve.why}")
    if start.tangent @ (start.u - origin) < 0.0:
        start = start._replace(tangent=-start.tangent)
    return _march(curve, start, steps, offset, max_step, tolerance)


def _march(
    curve: _Curve, start: _State, steps: int, step: float, max_step: float, tolerance: float
) -> Branch:
    """Return the branch from ``start`` along its tangent."""
    points, special = [start], []
    low, high = np.array(curve.within) / curve.range
    ended = "steps"
    while len(points) < steps:
        here = points[-1]
        found = curve.correct(here.u + step * here.tangent, here.tangent, tolerance)
        turn = np.inf
        if found is not None:
            turn = float(np.arccos(np.clip(found.tangent @ here.tangent, -1.0, 1.0)))
        if found is None or turn > LARGEST_TURN:
            step *= 0.5
            if step < MIN_STEP:
                ended = f"refused: {curve.why or 'the branch has a corner'}"
                break
            continue
        outside = not low <= found.u[-1] <= high
        if outside:
            vertical = np.append(np.zeros(len(here.u) - 1), 1.0)
            bound = high if found.u[-1] > high else low
            share = (bound - here.u[-1]) / (found.u[-1] - here.u[-1])
            guess = here.u + share * (found.u - here.u)
            guess[-1] = bound
            end = curve.correct(guess, vertical, tolerance)
            if end is None:  # too far to guess
                step *= 0.5
                continue
            along = end.tangent * np.sign(end.tangent @ here.tangent)
            found = end._replace(tangent=along)
            step = float((found.u - here.u) @ here.tangent)
        special += _between(curve, here, found, step, tolerance, len(points) - 1)
        points.append(found)
        if outside:
            ended = "load"
            break
        grow = min(1.5, 0.5 * LARGEST_TURN / max(turn, 1e-9), 4.0 / found.iterations)
        step = min(step * max(grow, 0.5), max_step)
    pairs = [curve.split(point.u) for point in points]
    unstable = []
    for point in points:
        curve.residual(point.u)
        unstable.append(unstable_directions(curve.dynamics))
    return Branch(
        loads=np.array([load for _, load in pairs]),
        q=np.array([q for q, _ in pairs]),
        unstable=np.array(unstable),
        special=tuple(special),
        ended_by=ended,
    )


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


def _between(
    curve: _Curve, first: _State, last: _State, step: float, tolerance: float, after: int
) -> list[SpecialPoint]:
    """Return the special points of one step, in order."""
    symmetric = _is_symmetric(first.stiffness) and _is_symmetric(last.stiffness)
    size = np.abs(first.stiffness).max()

    def at(d: float) -> _State | None:
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


def _root(
    at: Callable[[float], _State | None],
    polish: Callable[[Floats, Floats], _State | None],
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


def _special(curve: _Curve, u: Floats, after: int) -> SpecialPoint:
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
