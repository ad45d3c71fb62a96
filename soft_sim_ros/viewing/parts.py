"""Parts of a picture of an arm: each draws one shape from the frames of the arm."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.scene.taper import Floats
from soft_sim_ros.viewing.shapes import REMOVED, SHOWN, TRIANGLE_LIST, Canvas, Colour, Shape, ramp
from soft_sim_ros.viewing.tube import around, triangles

if TYPE_CHECKING:
    from soft_sim_ros.core.mechanics.closures import Reaction
    from soft_sim_ros.core.mechanics.contacts import Contact

LONGEST = 0.4  # of the arm's length: an arrow of a force far above the arm's weight


@dataclass
class State:
    """What parts are drawn from.

    Parameters
    ----------
    time : s
    poses : (P, 7) of all frames
    turns : (P, 3, 3) their rotations
    points : (Q, 3) in m, all that is fixed in frames: tendons and chambers
    efforts : (A,) of the actuators
    wrench : (6,) moment and force held at the tip, in world axes
    contacts : what touches
    reactions : what constraints do, by name
    """

    time: float
    poses: Floats
    turns: Floats
    points: Floats
    efforts: Floats
    wrench: Floats
    contacts: Sequence[Contact] = ()
    reactions: Mapping[str, Reaction] = field(default_factory=dict)


class Part(Protocol):
    """One shape, and how it is drawn."""

    shape: Shape

    def draw(self, state: State, canvas: Canvas) -> None:
        """Write what has changed."""


class Tube:
    """A closed tube around frames ``at`` (P,), its rings (P, M, 2) in m in their y-z planes."""

    def __init__(
        self, name: tuple[str, int], at: Sequence[int], rings: Floats, colour: Colour
    ) -> None:
        self._at, self._rings = stretch(at), rings
        self._corners = triangles(*rings.shape[:2]).ravel()
        points = len(self._corners)
        self.shape = Shape(*name, TRIANGLE_LIST, (1.0, 1.0, 1.0), colour, points)

    def draw(self, state: State, canvas: Canvas) -> None:
        """Write the corners of all triangles."""
        corners = around(state.poses[self._at, :3], state.turns[self._at], self._rings)
        np.take(corners.reshape(-1, 3), self._corners, axis=0, out=canvas.points, mode="clip")


class Line:
    """A line through the points ``own`` of all that are fixed in frames."""

    def __init__(self, shape: Shape, own: slice, shade: Shade) -> None:
        self.shape, self._own, self._shade = shape, own, shade
        self._coloured = math.nan

    def draw(self, state: State, canvas: Canvas) -> None:
        """Write points, and the colour where it has changed."""
        canvas.points[:] = state.points[self._own]
        if (share := self._shade(state)) != self._coloured:
            canvas.colour[:3], self._coloured = ramp(share), share


class Solid:
    """Something rigid in frame ``at``, moved by a position (3,) and turned by a quaternion (4,)."""

    def __init__(self, shape: Shape, at: int, position: Floats, quaternion: Floats) -> None:
        self.shape, self._at = shape, at
        self._position, self._quaternion = np.array(position), np.array(quaternion)

    def draw(self, state: State, canvas: Canvas) -> None:
        """Write its pose."""
        canvas.pose[:3] = state.poses[self._at, :3] + state.turns[self._at] @ self._position
        canvas.pose[3:] = multiply(state.poses[self._at, 3:], self._quaternion)


class Arrow:
    """A vector at frame ``at``; its length grows with the vector, never beyond LONGEST.

    A vector as large as ``unit`` is drawn at half of ``longest`` in m. None at all is removed.
    """

    def __init__(
        self, shape: Shape, at: int, vector: Callable[[State], Floats], unit: float, longest: float
    ) -> None:
        self.shape, self._at, self._vector = shape, at, vector
        self._unit, self._longest = unit, longest

    def draw(self, state: State, canvas: Canvas) -> None:
        """Write its two ends."""
        start, vector = state.poses[self._at, :3], self._vector(state)
        draw_arrow(canvas, start, vector, self._unit, self._longest)


def draw_arrow(canvas: Canvas, start: Floats, vector: Floats, unit: float, longest: float) -> None:
    """Write both ends of a vector (3,) that begins at a point (3,); remove one that is none."""
    size = math.hypot(*vector.tolist())
    shown = 0.0 < size < math.inf
    canvas.action[0] = SHOWN if shown else REMOVED
    if shown:
        canvas.points[:] = start
        canvas.points[1] += vector * (longest / (size + unit))


class Shade:
    """The share of its full effort that colours an actuator."""

    def __init__(self, index: int, full: float) -> None:
        self._index, self._full = index, full

    def __call__(self, state: State) -> float:
        """Return the effort as a share of the full one, in hundredths: colours are no finer."""
        return round(state.efforts.item(self._index) / self._full, 2)


def stretch(at: Sequence[int]) -> slice | NDArray[np.int64]:
    """Return indices as a slice where they are one after the other, which is cheaper."""
    if list(at) == list(range(at[0], at[-1] + 1)):
        return slice(at[0], at[-1] + 1)
    return np.array(at)


def multiply(a: Floats, b: Floats) -> Floats:
    """Return the product of two quaternions (4,) x y z w: first b, then a."""
    ax, ay, az, aw = a.tolist()
    bx, by, bz, bw = b.tolist()
    return np.array(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )


def upright(axis: Floats) -> Floats:
    """Return the quaternion (4,) that turns z into a unit vector (3,)."""
    x, y, z = axis.tolist()
    if z < -1.0 + 1e-12:
        return np.array([1.0, 0.0, 0.0, 0.0])
    quaternion = np.array([-y, x, 0.0, 1.0 + z])
    upright: Floats = quaternion / np.linalg.norm(quaternion)
    return upright
