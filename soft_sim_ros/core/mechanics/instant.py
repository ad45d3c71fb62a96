"""A motion at one instant, as sensors see it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Data
from soft_sim_ros.core.recursion.motions import AT, RATE, TURN, TWIST, WIDTH


class Instant(NamedTuple):
    """A motion at one instant.

    q, v : (n,) coordinates and rates
    data : what the recursion with accelerations has left; None if no sensor asks for it
    motions : (P, WIDTH) of frames that sensors are in (recursion/motions.py)
    time : s at which scheduled loads are taken
    base : (4, 4) the base in the world
    attached : whether the payloads of the scene are there
    ports : position, velocity and effort (A,) of the actuators; None if no sensor asks for them
    """

    q: Floats
    v: Floats
    data: Data | None
    motions: Floats
    time: float
    base: Floats
    attached: tuple[bool, ...]
    ports: tuple[Floats, Floats, Floats] | None


class Motion(NamedTuple):
    """What a frame does: rotation (3, 3) in the world; the rest along its own axes.

    omega : (3,) angular velocity, rad/s
    force : (3,) specific force in m/s²: acceleration of its origin minus gravity
    """

    rotation: Floats
    omega: Floats
    force: Floats


class MountedFrame:
    """A frame at a fixed pose (4, 4) in another one, whose motion is known."""

    def __init__(self, offset: Floats) -> None:
        self._turn, self._back = offset[:3, :3].copy(), se3.Ad(se3.inverse(offset))

    def motion(self, row: Floats, base: Floats) -> Motion:
        """Return what it does.

        The recursion counts accelerations from free fall, so they are specific forces already.

        Parameters
        ----------
        row : (WIDTH,) of the other frame
        base : (4, 4)
        """
        twist, rate = self._back @ row[TWIST:RATE], self._back @ row[RATE:WIDTH]
        rotation = base[:3, :3] @ row[TURN:AT].reshape(3, 3) @ self._turn
        return Motion(rotation, twist[:3], rate[3:] + cross(twist[:3], twist[3:]))


def cross(a: Floats, b: Floats) -> Floats:
    """Return a × b (3,); numpy's own takes 20 times as long for two vectors."""
    (a0, a1, a2), (b0, b1, b2) = a.tolist(), b.tolist()
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])
