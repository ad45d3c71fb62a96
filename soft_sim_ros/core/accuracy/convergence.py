"""How far off a run is, told by two runs that are finer.

With r for the contraction, the distance of the finer two over that of the coarser two, the finest
is off by about r / (1 − r) of the distance to the one before. So the coarsest is off by no more
than its distance to the finest, and that. A companion that is hardly better than the run has r near
one, and makes the estimate large.
"""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.refine.space_error import apart

SAFETY = 1.25  # neither is the finest the continuum
SLOWEST = 0.9  # contraction from which on it is taken for this: the finest is off by nine times
ASSUMED = 1.0 / 3.0  # contraction where nobody has looked
NOISE = 0.03  # of what is allowed: distances below this tell nothing of the contraction


def accuracy(
    tolerance: float, error: float, orientation: float | None, angle: float
) -> dict[str, float]:
    """Return what is told of a tolerance and an estimate; of orientations if they have one."""
    told = {"tolerance": tolerance, "error_rel": error}
    if orientation is None:
        return told
    return told | {"orientation_tolerance": orientation, "error_rad": angle}


def distances(one: Floats, other: Floats, compiled: Compiled) -> Floats:
    """Return the largest distances so far (looks, 2) of tips of two runs: poses (looks, T, 7).

    Of the positions over the length on the way to each tip, and of the orientations in rad.
    """
    away = apart(one[..., :3], other[..., :3], compiled)
    # of two unit quaternions, which may have opposite signs
    gap = np.minimum(
        np.linalg.norm(one[..., 3:] - other[..., 3:], axis=-1),
        np.linalg.norm(one[..., 3:] + other[..., 3:], axis=-1),
    ).max(axis=-1)
    angle = 4.0 * np.arcsin(np.minimum(1.0, 0.5 * gap))
    return np.maximum.accumulate(np.stack([away, angle], axis=1), axis=0)


def bound(near: Floats, far: Floats, between: Floats) -> Floats:
    """Return the estimate of an error, same shape, from distances of a run and two finer ones.

    near, far : of the run and the finer one, of the run and the finest
    between : of the finer two
    """
    ratio = contraction(near, between)
    return SAFETY * (np.maximum(near, far) + ratio / (1.0 - ratio) * between)


def contraction(near: Floats, between: Floats) -> Floats:
    """Return what is left of a distance where both runs are refined, at most SLOWEST."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(between > 0.0, between / near, 0.0)
    return np.minimum(ratio, SLOWEST)


def factor(ratio: float) -> float:
    """Return what the distance to a companion is multiplied by, if it contracts by a ratio."""
    return SAFETY / (1.0 - min(ratio, SLOWEST))
