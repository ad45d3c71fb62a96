"""Where paths of tendons and chambers run, and places along rods."""

from __future__ import annotations

import itertools

from soft_sim_ros.scene.attachment import Attachment, Forest
from soft_sim_ros.scene.body import ROUNDING, Body, RigidBody, Rod
from soft_sim_ros.scene.interval import Interval
from soft_sim_ros.scene.joint import Joint
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.tendon import PATHS, Lane, Stretch, read_path, read_points


def read_lane(reader: Reader, forest: Forest) -> Lane:
    """Read along which rods a path runs: ``rod``, or ``rods`` that nothing moves against another.

    What joins them is rigid, so the straight piece of path from one to the next has one length.
    """
    rods = {body.name: body for body in forest.bodies if isinstance(body, Rod)}
    if reader.one_of(("rod", "rods"), default="rod") == "rod":
        return Lane((rods[reader.reference("rod", rods, "rod")],))
    reader.no_effect("section", "it is for a path along one rod")
    names = reader.references("rods", rods, "rod")
    for one, other in itertools.pairwise(names):
        between, last = _between(forest, one, other)
        if last is None:
            expected = f"rods in the order from base to tip, but {other} is not beyond {one}"
            reader.refuse(expected, "rods")
        moving = [b.name for b in between if not (isinstance(b, RigidBody) or _is_fixed(b))]
        if rods[other].model.is_limp:
            moving.append(f"the hinge at the start of {other}")
        if moving:
            what = f"{', '.join(moving)} moves {other} against {one}"
            reader.refuse(f"rods that are rigidly joined, but {what}", "rods")
        if last.s is not None:
            expected = f"rods from end to start, but {other} hangs on {one} at s = {last.s:g} m"
            reader.refuse(expected, "rods")
    return Lane(tuple(rods[name] for name in names))


def _between(forest: Forest, one: str, other: str) -> tuple[list[Body], Attachment | None]:
    """Return the bodies between two, and how the first of them, or the other, hangs on the one.

    None if the other is not beyond the one.
    """
    by_name = {body.name: body for body in forest.bodies}
    between: list[Body] = []
    name = other
    while (parent := forest.parent(name)) != one:
        if parent is None:
            return [], None
        name = parent
        between.insert(0, by_name[name])
    return between, forest.attachments.get(name, Attachment(one))


def _is_fixed(body: Body) -> bool:
    return isinstance(body, Joint) and body.kind == "fixed"


def read_route(reader: Reader, lane: Lane) -> tuple[Stretch, ...]:
    """Read a path, and from where to where along its rods it runs."""
    if reader.one_of(PATHS) == "points":
        reader.no_effect("section", "the first and the last of the points say where")
        return lane.stretches(*read_points(reader, lane))
    if reader.has("section"):
        rod = lane.rods[0]
        names = [section.name for section in rod.sections]
        for key in ("start", "end"):
            reader.no_effect(key, "the section says it")
        index = names.index(reader.reference("section", names, "section of the rod"))
        start, end = rod.boundaries[index], rod.boundaries[index + 1]
    else:
        start, end = read_span(reader, lane)
    return lane.stretches(start, end, read_path(reader, end - start))


def read_arc_length(reader: Reader, key: str, rod: Rod | Lane, default: float) -> float:
    """Read an arc length along a rod (or rods in a row) in m."""
    inside = Interval(0.0, rod.length * (1.0 + ROUNDING), True, True)
    return rod.snap(reader.number(key, inside, default))


def read_span(reader: Reader, rod: Rod | Lane) -> tuple[float, float]:
    """Read ``start`` and ``end`` along a rod in m; by default the whole rod."""
    start = read_arc_length(reader, "start", rod, default=0.0)
    end = read_arc_length(reader, "end", rod, default=rod.length)
    if not start < end:
        wrong = "start" if reader.has("start") else "end"
        reader.refuse(f"start < end, they are {start:g} and {end:g}", wrong)
    return start, end
