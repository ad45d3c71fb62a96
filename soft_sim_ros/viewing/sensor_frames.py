"""Frames that readings of sensors are given in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from soft_sim_ros.core.algebra.se3 import pose_matrix, skew
from soft_sim_ros.core.floats import Floats

from .frames import Frames

if TYPE_CHECKING:
    from soft_sim_ros.core.simulation.simulation import Simulation


class SensorFrames:
    """Poses of the sensors whose readings are given in a frame, in their order.

    Parameters
    ----------
    simulation : the arm
    """

    def __init__(self, simulation: Simulation) -> None:
        sensors = [one for one in simulation.scene.sensors if one.framed]
        spots = [(one.of, one.s[0] if one.s else 0.0) for one in sensors]
        self._frames = Frames(simulation.compiled, simulation.q, spots)
        self._places = [one.place for one in sensors]
        self._poses = np.zeros((len(sensors), 7))

    def poses(self) -> Floats:
        """Return poses (P, 7) x y z qx qy qz qw in the world, reused by the next call."""
        for out, pose, place in zip(self._poses, self._frames.poses(), self._places, strict=True):
            turn = pose_matrix(pose[:3], pose[3:])[:3, :3]
            out[:3] = pose[:3] + turn @ place.position
            (axis, w), (other, z) = ((x[:3], x[3]) for x in (pose[3:], place.quaternion))
            out[3:6] = w * other + z * axis + skew(axis) @ other
            out[6] = w * z - axis @ other
        return self._poses
