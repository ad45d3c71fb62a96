"""Bodies in absolute coordinates, tied together by Lagrange multipliers, in plain numpy.

Every body has its own six accelerations in the world, and whatever moves inside it; what holds
bodies together are equations between their accelerations (Featherstone 2008, section 8.2, has the
matrix; here no tree is walked and nothing is carried from body to body). For tests only: dense.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def cross(vector: Floats) -> Floats:
    """Return the matrix (3, 3) of a cross product from the left."""
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


@dataclass
class Frame:
    """A frame that moves with some body, everything along the axes of the world.

    place, turn : position (3,) in m and rotation (3, 3)
    spin, speed : angular velocity and velocity (3,)
    turns, ways : (3, N) their accelerations by the unknowns, and what is added to them (3,)
    """

    place: Floats
    turn: Floats
    spin: Floats
    speed: Floats
    turns: Floats
    ways: Floats
    turns_rest: Floats
    ways_rest: Floats

    def fixed(self, offset: Floats) -> Frame:
        """Return a frame at an offset (4, 4) from this one, in the same rigid body."""
        arm = self.turn @ offset[:3, 3]
        return Frame(
            self.place + arm,
            self.turn @ offset[:3, :3],
            self.spin,
            self.speed + np.cross(self.spin, arm),
            self.turns,
            self.ways - cross(arm) @ self.turns,
            self.turns_rest,
            self.ways_rest
            + np.cross(self.turns_rest, arm)
            + np.cross(self.spin, np.cross(self.spin, arm)),
        )


class Absolute:
    """Equations of motion of bodies in absolute coordinates, under gravity (3,) in m/s²."""

    def __init__(self, unknowns: int, gravity: Any) -> None:
        self.gravity = np.asarray(gravity, dtype=float)
        self.mass = np.zeros((unknowns, unknowns))
        self.force = np.zeros(unknowns)
        self.rows: list[Floats] = []
        self.sides: list[float] = []
        self.errors: list[float] = []  # of positions and rates: how far joints are open
        self._used = 0

    def _blank(self) -> Floats:
        return np.zeros((3, len(self.force)))

    def ground(self) -> Frame:
        """Return the world."""
        rest = np.zeros(3)
        return Frame(rest, np.eye(3), rest, rest, self._blank(), self._blank(), rest, rest)

    def body(self, pose: Floats, spin: Floats, speed: Floats) -> Frame:
        """Return a new body's frame; its unknowns are its accelerations, angular ones first."""
        turns, ways = self._blank(), self._blank()
        turns[:, self._take(3)] = np.eye(3)
        ways[:, self._take(3)] = np.eye(3)
        rest = np.zeros(3)
        return Frame(pose[:3, 3], pose[:3, :3], spin, speed, turns, ways, rest, rest)

    def inner(self, count: int) -> slice:
        """Return the unknowns of what moves inside a body."""
        return self._take(count)

    def _take(self, count: int) -> slice:
        self._used += count
        return slice(self._used - count, self._used)

    def inside(
        self, base: Frame, pose: Floats, columns: slice, moves: Floats, twist: Floats, rest: Floats
    ) -> Frame:
        """Return a frame that moves inside the body of ``base``.

        pose : (4, 4) in the body
        columns, moves : unknowns of the inside; body Jacobian (6, n), moments first
        twist, rest : body twist (6,) in the body, and its rate (6,) without the unknowns
        """
        turn = base.turn @ pose[:3, :3]
        spin, speed = turn @ twist[:3], turn @ twist[3:]
        out = base.fixed(pose)
        turns, ways = out.turns.copy(), out.ways.copy()
        turns[:, columns] += turn @ moves[:3]
        ways[:, columns] += turn @ moves[3:]
        drift = turn @ (rest[3:] + np.cross(twist[:3], twist[3:]))
        return Frame(
            out.place,
            turn,
            out.spin + spin,
            out.speed + speed,
            turns,
            ways,
            out.turns_rest + np.cross(base.spin, spin) + turn @ rest[:3],
            out.ways_rest + 2.0 * np.cross(base.spin, speed) + drift,
        )

    def inertia(self, frame: Frame, mass: float, moments: Any) -> None:
        """Add a mass in kg at the origin of a frame and moments (3,) in kg·m² about its axes."""
        tensor = frame.turn @ np.diag(moments) @ frame.turn.T
        self.mass += frame.turns.T @ tensor @ frame.turns + mass * frame.ways.T @ frame.ways
        gyroscopic = np.cross(frame.spin, tensor @ frame.spin)
        self.load(
            frame,
            mass * (self.gravity - frame.ways_rest),
            -tensor @ frame.turns_rest - gyroscopic,
        )

    def load(self, frame: Frame, force: Floats, moment: Floats) -> None:
        """Add a force in N and a moment in N·m (3,) at a frame, along the world's axes."""
        self.force += frame.ways.T @ force + frame.turns.T @ moment

    def _tie(self, row: Floats, side: float, *errors: float) -> None:
        self.rows.append(row)
        self.sides.append(side)
        self.errors += errors

    def ball(self, one: Frame, other: Frame) -> None:
        """Hold the origins of two frames together."""
        for i in range(3):
            self._tie(
                one.ways[i] - other.ways[i],
                other.ways_rest[i] - one.ways_rest[i],
                one.place[i] - other.place[i],
                one.speed[i] - other.speed[i],
            )

    def square(self, one: Frame, first: Floats, other: Frame, second: Floats) -> None:
        """Hold a direction (3,) of one frame at a right angle to a direction of another."""
        e, d = one.turn @ first, other.turn @ second
        normal, spin = np.cross(e, d), one.spin - other.spin
        moving = np.cross(np.cross(one.spin, e), d) + np.cross(e, np.cross(other.spin, d))
        rest = normal @ (one.turns_rest - other.turns_rest) + spin @ moving
        self._tie(normal @ (one.turns - other.turns), -rest, e @ d, spin @ normal)

    def hinge(self, one: Frame, other: Frame, axis: Floats) -> None:
        """Leave a rotation about an axis (3,), the same in both frames."""
        self.ball(one, other)
        for first in np.linalg.svd(axis[None, :])[2][1:]:
            self.square(one, first, other, axis)

    def weld(self, one: Frame, other: Frame) -> None:
        """Hold two frames together."""
        self.ball(one, other)
        axes = np.eye(3)
        for i, j in ((0, 1), (0, 2), (1, 2)):
            self.square(one, axes[i], other, axes[j])

    def motor(self, one: Frame, other: Frame, axis: Floats, torque: float) -> None:
        """Add a torque in N·m about an axis (3,) on the other of two frames, and back on one."""
        arm = torque * (other.turn @ axis)
        self.load(other, np.zeros(3), arm)
        self.load(one, np.zeros(3), -arm)

    def accelerations(self) -> Floats:
        """Return the unknowns."""
        assert self._used == len(self.force)
        ties, n = np.array(self.rows), len(self.force)
        whole = np.block([[self.mass, ties.T], [ties, np.zeros((len(ties), len(ties)))]])
        return np.linalg.solve(whole, np.concatenate([self.force, self.sides]))[:n]

    def of(self, frame: Frame, found: Floats) -> tuple[Floats, Floats]:
        """Return the angular acceleration and the acceleration (3,) of a frame."""
        return frame.turns @ found + frame.turns_rest, frame.ways @ found + frame.ways_rest
