"""Ways and distances of all tips of a forest, each measured by its own way from the base."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats

from .dynamics import Dynamics


def tip_ways(dynamics: Dynamics, moves: Floats, q: Floats) -> tuple[Floats, Floats]:
    """Return turns (T, 3, k) in rad and ways (T, 3, k) in m of all tips by moves (n, k) about q.

    Ways are scaled to the length of the whole (``Compiled.tip_scale``).
    """
    twists = dynamics.tip_jacobians(q) @ moves
    return twists[:, :3], twists[:, 3:] * dynamics.compiled.tip_scale[:, None, None]


def apart(one: Floats, other: Floats, compiled: Compiled) -> Floats:
    """Return the largest distance (…) of tips (…, T, 3), each over the length on the way to it."""
    away = np.linalg.norm(one - other, axis=-1) * compiled.tip_scale
    return np.asarray(away.max(axis=-1) / compiled.length)
