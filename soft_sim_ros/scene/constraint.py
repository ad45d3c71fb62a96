"""Constraints between two frames, or between a frame and the world: what closes loops.

The first frame is held at the second one, but for what the kind leaves free, in the axes of the
second frame.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene.body import ROUNDING, Body, FlexibleLink, Rod
from soft_sim_ros.scene.interval import POSITIVE, Interval
from soft_sim_ros.scene.pose import IDENTITY, Pose, read_pose
from soft_sim_ros.scene.read_route import read_arc_length
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats

# What a kind holds: components of the position, and of the turn; "axis": all but that about an
# axis, "across": what is across an axis, "along": along an axis.
HOLDS: dict[str, tuple[str, str]] = {
    "weld": ("all", "all"),
    "ball": ("all", ""),
    "hinge": ("all", "axis"),
    "slider": ("across", "all"),
    "line": ("across", ""),
    "plane": ("along", ""),
    "distance": ("distance", ""),
    "orientation": ("", "all"),
}
CONSTRAINT_KINDS = tuple(HOLDS)
WITH_AXIS = ("hinge", "slider", "line", "plane")
HERE = "here"


@dataclass(frozen=True, eq=False)
class Place:
    """A frame.

    body : its name; None: the world
    s : arc length in m along a rod; None: the end of the body
    offset : pose in the frame there; None: where the other frame is when the scene begins
    """

    body: str | None
    s: float | None = None
    offset: Pose | None = IDENTITY


@dataclass(frozen=True, eq=False)
class Constraint:
    """Holds the first frame at the second.

    kind : one of CONSTRAINT_KINDS
    axis : unit vector (3,) of the second frame: of the hinge, along the slider or the line, across
        the plane
    length : m, of a distance; NaN: what it is when the scene begins
    start, end : s, when it is made and when it is released
    """

    name: str
    kind: str
    frames: tuple[Place, Place]
    axis: Floats
    length: float
    start: float
    end: float

    @property
    def switch_times(self) -> tuple[float, ...]:
        """Times in s at which it is made or released while the arm moves."""
        return tuple(t for t in (self.start, self.end) if math.isfinite(t))


def read_constraints(entries: list[Reader], bodies: tuple[Body, ...]) -> tuple[Constraint, ...]:
    """Read ``constraints``."""
    found: list[Constraint] = []
    by_name = {body.name: body for body in bodies}
    for reader in entries:
        reader.only("name", "kind", "frames", "axis", "length", "start", "end")
        name = reader.name("name", taken={one.name for one in found})
        kind = reader.choice("kind", CONSTRAINT_KINDS)
        start = reader.number("start", default=-math.inf)
        end = reader.number("end", Interval(start, math.inf, False, True), default=math.inf)
        frames = _read_frames(reader, by_name)
        axis, length = np.zeros(3), 0.0
        if kind in WITH_AXIS:
            axis = _direction(reader)
        else:
            reader.no_effect("axis", f"a {kind} has none")
        if kind == "distance":
            length = _length(reader)
        else:
            reader.no_effect("length", f"it is for a distance, not for a {kind}")
        axis.setflags(write=False)
        found.append(Constraint(name, kind, frames, axis, length, start, end))
    return tuple(found)


def _length(reader: Reader) -> float:
    if not reader.has("length") or reader.says("length", HERE):
        return math.nan
    return float(reader.number("length", POSITIVE))


def _direction(reader: Reader) -> Floats:
    axis = reader.vector("axis", 3)
    norm = float(np.linalg.norm(axis))
    if not 1e-100 < norm < 1e100:
        reader.refuse(f"a direction, not a vector of length {norm:g}", "axis")
    unit: Floats = axis / norm
    return unit


def _read_frames(reader: Reader, bodies: Mapping[str, Body]) -> tuple[Place, Place]:
    entries = reader.entries("frames", required=True)
    if len(entries) > 2:
        reader.refuse(f"one frame or two, not {len(entries)}", "frames")
    first = _read_place(entries[0], bodies)
    if first.body is None:
        entries[0].refuse("a frame of a body: the world comes second", "world")
    if first.offset is None:
        entries[0].refuse("here only at the second frame", "offset")
    second = _read_place(entries[1], bodies) if len(entries) == 2 else Place(None, None, None)
    if (first.body, first.s) == (second.body, second.s):
        expected = f"another place than that of the first frame, {first.body}"
        entries[1].refuse(expected, "body")
    return first, second


def _read_place(reader: Reader, bodies: Mapping[str, Body]) -> Place:
    if reader.one_of(("body", "world")) == "world":
        reader.only("world")
        if reader.says("world", HERE):
            return Place(None, None, None)
        return Place(None, None, read_pose(reader.mapping("world")))
    reader.only("body", "s", "offset")
    body = bodies[reader.reference("body", bodies, "body")]
    s = None
    if reader.has("s"):
        if not isinstance(body, Rod):
            what = "a link is held at its end" if isinstance(body, FlexibleLink) else "it is no rod"
            reader.refuse(f"no s: {body.name}: {what}", "s")
        s = read_arc_length(reader, "s", body, default=body.length)
        if s >= body.length * (1.0 - ROUNDING):
            s = None
    if reader.says("offset", HERE):
        return Place(body.name, s, None)
    return Place(body.name, s, read_pose(reader.mapping("offset")))
