"""Branches of equilibria r(q, λ) = 0, followed by pseudo-arclength through limit points.

In u = (w q, λ / range), where w q is in arm lengths at the tip, a step of length d along the
tangent t from u₀ is corrected by Newton's method on

    r(q, λ) = 0,    tᵀ (u − u₀) = d,

whose matrix, K bordered by ∂r/∂λ and tᵀ, is regular at limit points, where K alone is not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.core.arguments import number, vector, whole
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.errors import BadArgument, NoBranch

from .curve import Curve, State
from .load_path import LoadPath
from .special_points import BIFURCATION, LIMIT, SpecialPoint, special_points
from .stability import unstable_directions

__all__ = ["BIFURCATION", "LIMIT", "Branch", "SpecialPoint", "follow", "switch"]

LARGEST_TURN = 0.3  # rad that the tangent may turn in one step
MIN_STEP = 1e-7
MOST_POINTS = 1_000_000
STEP, LARGEST_STEP, TOLERANCE = 0.02, 0.1, 1e-11


@dataclass(frozen=True, eq=False)
class Branch:
    """Equilibria along a branch.

    Parameters
    ----------
    loads : (P,) λ
    q : (P, n) coordinates
    unstable : (P,) number of directions in which the arm leaves the equilibrium by itself; under
        loads that follow, of a swing that grows, two
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


def follow(
    dynamics: Dynamics,
    path: LoadPath,
    q: Floats,
    load: float = 0.0,
    *,
    within: tuple[float, float],
    downwards: bool = False,
    steps: int = 300,
    step: float = STEP,
    max_step: float = LARGEST_STEP,
    tolerance: float = TOLERANCE,
) -> Branch:
    """Follow the branch of equilibria through (q, load).

    Parameters
    ----------
    dynamics : the arm
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
    it cannot be made, the branch so far is returned with ``ended_by`` = "refused: …". What is
    stable is what ``equilibrium`` calls so. Special points are static ones; the onset of flutter is
    seen from ``unstable`` only. Unlike in ``equilibrium``, the discretisation is not checked: if
    the branch bends much, compare with a higher order.
    """
    curve = Curve(dynamics, path, within)
    _check(curve, load, steps=steps, step=step, max_step=max_step, tolerance=tolerance)
    q = dynamics.coordinates(q)
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
    dynamics : the arm
    path, within, steps, max_step, tolerance : as for ``follow``
    point : the bifurcation
    direction : (n,) where to; the first of ``point.directions`` by default, and minus it leads to
        the other half of the branch
    offset : arc length of the first step

    Raises
    ------
    NoBranch
        if no other branch is found in that direction.
    """
    curve = Curve(dynamics, path, within)
    _check(curve, point.load, steps=steps, offset=offset, max_step=max_step, tolerance=tolerance)
    if direction is None:
        direction = point.directions[:, 0]
    direction = vector("direction", direction, dynamics.n, finite=True)
    if not direction.any():
        raise BadArgument("direction", direction, f"{dynamics.n} numbers that are not all zero")
    aside = np.append(direction, 0.0) / curve.scale
    aside /= np.linalg.norm(aside)
    origin = np.append(point.q, point.load) / curve.scale
    start = curve.correct(origin + offset * aside, aside, tolerance)
    if start is None:
        raise NoBranch(point.load, f"nothing in that direction: {curve.why}")
    if start.tangent @ (start.u - origin) < 0.0:
        start = start._replace(tangent=-start.tangent)
    return _march(curve, start, steps, offset, max_step, tolerance)


def _check(curve: Curve, load: float, steps: int, **above_zero: float) -> None:
    """Refuse a branch that could not be followed as it is asked for."""
    whole("steps", steps, 1, MOST_POINTS)
    for name, value in above_zero.items():
        if not number(name, value, expected="finite number above zero") > 0.0:
            raise BadArgument(name, value, "a finite number above zero")
    number("load", load)
    if not curve.within[0] <= load <= curve.within[1]:
        raise ValueError(f"the branch starts at the load {load:g}, not within {curve.within}")


def trace(
    dynamics: Dynamics,
    path: LoadPath,
    q: Floats,
    load: float,
    *,
    within: tuple[float, float],
    steps: int,
) -> tuple[Floats, float] | None:
    """Return the last point (q, λ) of the branch upwards from (q, load), as ``follow`` would find.

    None if there is no equilibrium there. Special points are not looked for, nor stability.
    """
    curve = Curve(dynamics, path, within)
    vertical = np.append(np.zeros(dynamics.n), 1.0)
    start = curve.correct(np.append(q, load) / curve.scale, vertical, TOLERANCE)
    if start is None:
        return None
    points = _steps(curve, start, steps, STEP, LARGEST_STEP, TOLERANCE)[0]
    return curve.split(points[-1].u)


def _march(
    curve: Curve, start: State, steps: int, step: float, max_step: float, tolerance: float
) -> Branch:
    """Return the branch from ``start`` along its tangent."""
    points, lengths, ended = _steps(curve, start, steps, step, max_step, tolerance)
    special: list[SpecialPoint] = []
    for i, length in enumerate(lengths):
        special += special_points(curve, points[i], points[i + 1], length, tolerance, i)
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


def _steps(
    curve: Curve, start: State, steps: int, step: float, max_step: float, tolerance: float
) -> tuple[list[State], list[float], str]:
    """Return points along the branch from ``start``, the steps between them, and why it ended."""
    points, lengths = [start], []
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
        lengths.append(step)
        points.append(found)
        if outside:
            ended = "load"
            break
        grow = min(1.5, 0.5 * LARGEST_TURN / max(turn, 1e-9), 4.0 / found.iterations)
        step = min(step * max(grow, 0.5), max_step)
    return points, lengths, ended
