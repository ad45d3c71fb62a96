"""Loads: wrenches at a point or along a rod, with a time schedule."""

from __future__ import annotations

import math
from dataclasses import dataclass

from soft_sim_ros.scene.body import ROUNDING, Body, FlexibleLink, Rod
from soft_sim_ros.scene.custom_load import CustomLoad, read_law
from soft_sim_ros.scene.interval import NONNEGATIVE, Interval
from soft_sim_ros.scene.read_route import read_arc_length, read_span
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats

FRAMES = ("world", "body")
COMMON = ("schedule", "force", "moment", "frame")
KINDS = ("point", "distributed", "custom", "input")


@dataclass(frozen=True)
class Schedule:
    """When a load acts, in s: from ``start`` on and until ``end``, with straight ramps inside.

    The factor rises from 0 to 1 within ``ramp`` after the start and falls back to 0 within
    ``ramp`` before the end. Without a ramp the load is on for start <= t < end.
    """

    start: float = 0.0
    end: float = math.inf
    ramp: float = 0.0

    def factor(self, t: float) -> float:
        """Return the fraction of the load that acts at time t in s, in [0, 1]."""
        if not self.start <= t < self.end:
            return 0.0
        if self.ramp == 0.0:
            return 1.0
        return min(1.0, (t - self.start) / self.ramp, (self.end - t) / self.ramp)

    @property
    def switch_times(self) -> tuple[float, ...]:
        """Times in s at which the factor jumps or changes its slope."""
        times = {self.start, self.start + self.ramp, self.end - self.ramp, self.end}
        return tuple(sorted(time for time in times if math.isfinite(time)))


@dataclass(frozen=True, eq=False)
class PointLoad:
    """A wrench at arc length s of a rod or link, or at the frame of a joint or rigid body (s = 0).

    force (3,) in N, moment (3,) in N·m; in the frame "world" the load is dead, in the frame
    "body" it follows the cross-section.
    """

    name: str
    schedule: Schedule
    body: str
    s: float
    force: Floats
    moment: Floats
    frame: str


@dataclass(frozen=True, eq=False)
class DistributedLoad:
    """A wrench per reference arc length, constant between arc lengths ``start`` and ``end``.

    force (3,) in N/m, moment (3,) in N·m/m; frames as for a PointLoad.
    """

    name: str
    schedule: Schedule
    body: str
    start: float
    end: float
    force: Floats
    moment: Floats
    frame: str


@dataclass(frozen=True)
class InputLoad:
    """A wrench that is commanded while the arm moves, at a place like that of a PointLoad.

    frame : "world": it is given along world axes, "body": along those of the cross-section
    force, moment : the largest, in N and N·m; infinite: no limit of its own
    """

    name: str
    body: str
    s: float
    frame: str
    force: float = math.inf
    moment: float = math.inf


Load = PointLoad | DistributedLoad | CustomLoad | InputLoad


def read_loads(entries: list[Reader], bodies: tuple[Body, ...]) -> tuple[Load, ...]:
    """Read ``loads``."""
    loads: list[Load] = []
    for reader in entries:
        kind = reader.one_of(KINDS)
        name = reader.name(kind, taken={load.name for load in loads})
        if kind in ("custom", "input"):
            special = _read_custom if kind == "custom" else _read_input
            loads.append(special(reader, name, bodies))
            continue
        schedule = _read_schedule(reader.mapping("schedule"))
        read = _read_point if kind == "point" else _read_distributed
        loads.append(read(reader, name, schedule, bodies))
    return tuple(loads)


def _read_point(
    reader: Reader, name: str, schedule: Schedule, bodies: tuple[Body, ...]
) -> PointLoad:
    reader.only("point", "body", "s", *COMMON)
    body, s = _read_place(reader, bodies)
    return PointLoad(name, schedule, body.name, s, *_read_wrench(reader, body))


def _read_input(reader: Reader, name: str, bodies: tuple[Body, ...]) -> InputLoad:
    reader.only("input", "body", "s", "frame", "limits")
    body, s = _read_place(reader, bodies)
    frame = reader.choice("frame", FRAMES, default="world")
    limits = reader.mapping("limits").only("force", "moment")
    most = [limits.number(key, NONNEGATIVE, default=math.inf) for key in ("force", "moment")]
    return InputLoad(name, body.name, s, frame, *most)


def _read_place(reader: Reader, bodies: tuple[Body, ...]) -> tuple[Body, float]:
    """Read ``body`` and ``s``: an arc length in m of a rod or link, 0 on other bodies."""
    by_name = {body.name: body for body in bodies}
    body = by_name[reader.reference("body", by_name, "body")]
    if (rod := _elastic(body)) is not None:
        return body, read_arc_length(reader, "s", rod, default=rod.length)
    reader.no_effect("s", f"{body.name} is not a rod")
    return body, 0.0


def _read_distributed(
    reader: Reader, name: str, schedule: Schedule, bodies: tuple[Body, ...]
) -> DistributedLoad:
    reader.only("distributed", "body", "start", "end", *COMMON)
    rods = {body.name: rod for body in bodies if (rod := _elastic(body)) is not None}
    rod = rods[reader.reference("body", rods, "rod")]
    start, end = read_span(reader, rod)
    return DistributedLoad(name, schedule, rod.name, start, end, *_read_wrench(reader, rod))


def _read_custom(reader: Reader, name: str, bodies: tuple[Body, ...]) -> CustomLoad:
    reader.only("custom", "law", "parameters", "body", "s", "start", "end")
    law, parameters = read_law(reader)
    by_name = {body.name: body for body in bodies}
    body = by_name[reader.reference("body", by_name, "body")]
    if not isinstance(body, Rod):
        for key in ("s", "start", "end"):
            reader.no_effect(key, f"{body.name} is not a rod")
        return CustomLoad(name, law, parameters, body.name, 0.0, 0.0)
    if reader.has("start") or reader.has("end"):
        reader.no_effect("s", "start and end say where it acts, per length")
        return CustomLoad(name, law, parameters, body.name, *read_span(reader, body))
    s = read_arc_length(reader, "s", body, default=body.length)
    return CustomLoad(name, law, parameters, body.name, s, s)


def _elastic(body: Body) -> Rod | None:
    """Return the rod of a body that has a length."""
    if isinstance(body, FlexibleLink):
        return body.rod
    return body if isinstance(body, Rod) else None


def _read_wrench(reader: Reader, body: Body) -> tuple[Floats, Floats, str]:
    if isinstance(body, Rod) and body.model.is_limp:
        reader.no_effect("moment", f"a {body.model.name} carries no moment")
    if not (reader.has("force") or reader.has("moment")):
        reader.refuse("a force or a moment")
    force = reader.vector("force", 3, default=(0, 0, 0))
    moment = reader.vector("moment", 3, default=(0, 0, 0))
    return force, moment, reader.choice("frame", FRAMES, default="world")


def _read_schedule(reader: Reader) -> Schedule:
    reader.only("start", "end", "ramp")
    start = reader.number("start", default=0.0)
    end = reader.number("end", Interval(start, math.inf, False, True), default=math.inf)
    ramp = reader.number("ramp", NONNEGATIVE, default=0.0)
    # 0.3 − 0.1 is not 0.2 in floating-point numbers
    if 2 * ramp > (end - start) * (1.0 + ROUNDING):
        reader.refuse(f"at most half the time between start and end, {end - start:g} s", "ramp")
    return Schedule(start, end, ramp)
