"""Poses: a position and an orientation relative to a parent frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene.reader import Reader, frozen
from soft_sim_ros.scene.taper import Floats


@dataclass(frozen=True, eq=False)
class Pose:
    """Position (3,) in m and unit quaternion (4,) x y z w, both in the parent frame."""

    position: Floats
    quaternion: Floats


IDENTITY = Pose(frozen((0, 0, 0)), frozen((0, 0, 0, 1)))


def read_pose(reader: Reader) -> Pose:
    """Read ``position`` and one of ``rpy``, ``quaternion``; what is absent is zero."""
    reader.only("position", "rpy", "quaternion")
    position = reader.vector("position", 3, default=(0, 0, 0))
    if reader.one_of(("rpy", "quaternion"), default="rpy") == "rpy":
        quaternion = quaternion_from_rpy(reader.vector("rpy", 3, default=(0, 0, 0)))
    else:
        quaternion = reader.vector("quaternion", 4)
        norm = float(np.linalg.norm(quaternion))
        if not abs(norm - 1.0) < 1e-3:
            reader.refuse(f"a unit quaternion [x, y, z, w], its norm is {norm:g}", "quaternion")
        quaternion = quaternion / norm
    return Pose(position, frozen(quaternion))


def quaternion_from_rpy(rpy: Floats) -> Floats:
    """Return the quaternion (4,) x y z w of Rz(yaw)·Ry(pitch)·Rx(roll), angles in rad (REP-103)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy / 2), np.sin(rpy / 2)
    return np.array([
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    ])  # fmt: skip
