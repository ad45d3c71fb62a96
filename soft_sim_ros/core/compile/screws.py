"""The screws that joints move along."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.scene import Joint


def screws_of(joint: Joint) -> list[list[tuple[int, Floats]]]:
    """Return, for every segment of a joint, its (own coordinate, screw (6,)) pairs."""
    if joint.kind == "prismatic":
        return [[(0, np.concatenate([np.zeros(3), joint.axis]))]]
    if joint.kind in ("revolute", "universal"):
        return [[(j, np.concatenate([axis, np.zeros(3)]))] for j, axis in enumerate(joint.axes)]
    unit = np.eye(6)
    turn = [(j, unit[j]) for j in range(3)]
    if joint.kind == "spherical":
        return [turn]
    return [[(j, unit[j]) for j in range(3, 6)], turn] if joint.kind == "free" else []
