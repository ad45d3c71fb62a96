"""Estimate of the error of a run from two finer runs.

Let r be the contraction: the distance between the two finer runs over that between the two coarser
ones. The error of the finest run is about r / (1 − r) of its distance to the middle one. So the
error of the coarsest run is at most its distance to the finest plus that. If refinement hardly
helps, r is near one and the estimate is large.
"""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.tips import apart

SAFETY = 1.25  # the finest run is not exact either
SLOWEST = 0.9  # largest contraction assumed: the finest run is then off by nine times the distance
ASSUMED = 1.0 / 3.0  # contraction where it was not measured
NOISE = 0.03  # of the tolerance: smaller distances say nothing about the contraction


def accuracy(
    tolerance: float, error: float, orientation: float | None, angle: float
) -> dict[str, float]:
    """Return the message about a tolerance and an estimate, with orientations if there are any."""
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
    """Return the contraction of a distance when both runs are refined, at most SLOWEST."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(between > 0.0, between / near, 0.0)
    return np.minimum(ratio, SLOWEST)


def factor(ratio: float) -> float:
    """Return what the distance to a companion is multiplied by, if it contracts by a ratio."""
    return SAFETY / (1.0 - min(ratio, SLOWEST))
