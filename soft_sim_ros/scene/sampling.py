"""Samples between which a function changes by little, however narrow its features are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from soft_sim_ros.scene.enclosure import Bounds, enclose
from soft_sim_ros.scene.expression import Expression
from soft_sim_ros.scene.taper import Floats

STEP = 0.1  # of its size, or of the largest: what may change between two samples
FINEST = 1e-5  # of the section: no narrower interval is cut
FORMULA, FUNCTION, MOST = 257, 4097, 20000  # samples: first of each kind, and in all
_BETWEEN = np.array([0.211, 0.5, 0.789])


class Unresolved(ValueError):
    """Data that change too fast, or too often, for any rod of a reasonable number of pieces."""


def resolving(function: Callable[[Floats], Floats], length: float) -> Floats:
    """Return rising places x (N,) in [0, 1] between which a function of x length changes by little.

    A formula is bounded between its samples, so nothing hides there; of other functions a few more
    samples are taken.

    Raises
    ------
    Unresolved
        if a formula may hide something narrower than FINEST, or MOST samples do not show it
    """
    formula = function if isinstance(function, Expression) else None
    x = np.linspace(0.0, 1.0, FUNCTION if formula is None else FORMULA)
    size = float(np.abs(_values(function, length, x)).max())
    done: list[Floats] = [x]
    begin, end = x[:-1], x[1:]
    while len(begin):
        low, high = _range(function, length, begin, end)
        least = np.where(low * high > 0.0, np.minimum(np.abs(low), np.abs(high)), size)
        rough = ~(high - low <= STEP * np.minimum(least, size))
        narrow = end - begin <= FINEST
        if formula is not None and (rough & narrow).any():
            tight = rough & narrow
            ends = [_values(function, length, one[tight]) for one in (begin, end)]
            first, last = ends
            _refuse_spikes(first, last, (low[tight], high[tight]), length * begin[tight])
        rough &= ~narrow
        middle = 0.5 * (begin + end)[rough]
        done.append(middle)
        begin, end = (
            np.concatenate([begin[rough], middle]),
            np.concatenate([middle, end[rough]]),
        )
        if sum(map(len, done)) > MOST:
            if formula is None:  # round-off of a spline, for instance
                break
            raise Unresolved(f"something that changes less often: {MOST} samples do not show it")
    return np.unique(np.concatenate(done))


def _values(function: Callable[[Floats], Floats], length: float, x: Floats) -> Floats:
    return np.broadcast_to(np.asarray(function(length * x), dtype=float), x.shape)


def _range(
    function: Callable[[Floats], Floats], length: float, begin: Floats, end: Floats
) -> Bounds:
    """Return bounds on intervals (N,); of what is no formula the extremes of a few samples."""
    if isinstance(function, Expression):
        return enclose(function, length * begin, length * end)
    inner = begin + (end - begin) * _BETWEEN[:, None]
    every = np.concatenate([begin[None], inner, end[None]])
    samples = _values(function, length, every.ravel()).reshape(every.shape)
    return samples.min(axis=0), samples.max(axis=0)


def _refuse_spikes(first: Floats, last: Floats, bounds: Bounds, s: Floats) -> None:
    """Refuse what the narrowest intervals hide: more than lies between the values at their ends."""
    least, most = np.minimum(first, last), np.maximum(first, last)
    over = bounds[1] - most > 0.5 * np.maximum(np.abs(first), np.abs(last))
    over |= least - bounds[0] > 0.5 * np.minimum(np.abs(first), np.abs(last))
    if over.any():
        raise Unresolved(
            f"nothing narrower than {FINEST:g} of the section, as there may be at "
            f"s = {s[np.argmax(over)]:.9g} m (at a jump another section begins)"
        )
