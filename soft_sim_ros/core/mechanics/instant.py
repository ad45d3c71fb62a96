"""A motion at one instant, as sensors see it, and what a place of the arm does in it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.compile.samples import Place
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Data

_NEGLIGIBLE = 1e-18  # of the series of the tangent map, over its sum
_TERMS = 60


class Instant(NamedTuple):
    """A motion at one instant.

    q, v, a : (n,) coordinates, rates and accelerations
    data : what the recursion has left of it, nodes placed; None if no sensor asks for it
    time : s at which scheduled loads are taken
    base : (4, 4) the base in the world
    attached : (P,) whether the payloads of the scene are there
    ports : position, velocity and effort (A,) of the actuators; None if no sensor asks for them
    """

    q: Floats
    v: Floats
    a: Floats
    data: Data | None
    time: float
    base: Floats
    attached: tuple[bool, ...]
    ports: tuple[Floats, Floats, Floats] | None


class Motion(NamedTuple):
    """What a frame does: pose (4, 4) in the world; the rest along its own axes.

    twist : (6,) angular and linear velocity, rad/s and m/s
    force : (3,) specific force in m/s²: acceleration of its origin minus gravity
    """

    pose: Floats
    twist: Floats
    force: Floats


class MovingFrame:
    """A frame of the arm: a place (compile/samples.py), and a pose in the frame there.

    Parameters
    ----------
    place : a node, and the segment from it
    offset : (4, 4)
    n : number of coordinates
    """

    def __init__(self, place: Place, offset: Floats, n: int) -> None:
        self._node, segment = place
        self._half, self._kappa, self._xi0 = segment.half, segment.kappa, segment.xi0
        self._phi = np.zeros((2, 6, n))
        for column, component, first, second in segment.entries:
            self._phi[0, component, column] += first
            self._phi[1, component, column] += second
        self._still = not (self._xi0.any() or segment.entries)
        self._offset, self._to_offset = offset, se3.Ad(se3.inverse(offset))

    def motion(self, now: Instant) -> Motion:
        """Return what it does: Boyer & Primault 2005 (3.6)–(3.8) over one more segment.

        The recursion counts accelerations from free fall, so they are specific forces already.
        """
        data = now.data
        assert data is not None
        pose = np.eye(4)
        pose[:3, :3] = data.rotation[self._node].reshape(3, 3)
        pose[:3, 3] = data.position[self._node]
        twist, rate = data.eta[self._node], data.acc[self._node]
        if not self._still:
            pose, twist, rate = self._further(now, pose, twist, rate)
        pose = now.base @ pose @ self._offset
        twist, rate = self._to_offset @ twist, self._to_offset @ rate
        return Motion(pose, twist, rate[3:] + np.cross(twist[:3], twist[3:]))

    def _further(
        self, now: Instant, pose: Floats, twist: Floats, rate: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Return pose, twist and its rate at the end of the segment."""
        x1, x2 = self._xi0 + self._phi @ now.q
        u1, u2 = self._phi @ now.v
        z1, z2 = self._phi @ now.a
        half, kappa = self._half, self._kappa
        omega = half * (x1 + x2) + kappa * (se3.ad(x1) @ x2)
        speed = half * (u1 + u2) + kappa * (se3.ad(u1) @ x2 + se3.ad(x1) @ u2)
        bend = se3.ad(z1) @ x2 + se3.ad(x1) @ z2 + 2.0 * (se3.ad(u1) @ u2)
        velocity, change = own_twist(omega, speed, half * (z1 + z2) + kappa * bend)
        step = se3.exp(omega)
        back = se3.Ad(se3.inverse(step))
        carried = back @ twist
        rate = back @ rate - se3.ad(velocity) @ carried + change
        return pose @ step, carried + velocity, rate


def own_twist(omega: Floats, speed: Floats, bend: Floats) -> tuple[Floats, Floats]:
    """Return the body twist (6,) of exp(Ω) and its rate, for Ω (6,), its rate and second rate.

    By the series T(Ω) Ω̇ = Σ (−ad_Ω)ᵏ Ω̇ / (k + 1)!, which converges for every Ω.
    """
    turn, turning = -se3.ad(omega), -se3.ad(speed)
    term, slope = speed.copy(), bend.copy()
    twist, rate = speed.copy(), bend.copy()
    for k in range(2, _TERMS):
        slope = (turning @ term + turn @ slope) / k
        term = turn @ term / k
        twist += term
        rate += slope
        size = np.abs(twist).max() + np.abs(rate).max()
        if np.abs(term).max() + np.abs(slope).max() <= _NEGLIGIBLE * size:
            break
    return twist, rate
