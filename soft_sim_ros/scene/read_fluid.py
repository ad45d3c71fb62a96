"""Reads ``fluid`` of a scene and of its bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NoReturn

import numpy as np

from soft_sim_ros.scene.driven import Course, Formula, TimeTable, read_course
from soft_sim_ros.scene.expression import Expression
from soft_sim_ros.scene.fluid import (
    DEFAULTS,
    ENDS,
    LAWS,
    BodyFluid,
    Fluid,
    Numbers,
    RodFluid,
    ellipsoid,
)
from soft_sim_ros.scene.interval import FINITE, NONNEGATIVE, POSITIVE, Interval
from soft_sim_ros.scene.pose import Pose, read_pose
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats

AXES = ("x", "y", "z")
_ALONG = ("drag_tangential", "viscous_tangential")  # one number, whatever the section


def read_fluid(reader: Reader) -> Fluid | None:
    """Read the fluid of a scene; None without one."""
    if not reader.has("fluid"):
        return None
    own = reader.mapping("fluid", required=True)
    own.only("density", "current", "drag_law", "surface", *DEFAULTS)
    return Fluid(
        density=own.number("density", POSITIVE),
        current=_current(own),
        given=_coefficients(own),
        law=own.choice("drag_law", LAWS, default=LAWS[0]),
        surface=own.number("surface", default=0.0),
    )


def read_rod_fluid(reader: Reader, ends: bool = False) -> RodFluid:
    """Read ``fluid`` of a section, or (``ends``) of a rod."""
    if not reader.has("fluid"):
        return RodFluid()
    if reader.says("fluid", "none"):
        return RodFluid(dry=True)
    own = reader.mapping("fluid") if reader.is_mapping("fluid") else _no_mapping(reader)
    own.only(*DEFAULTS, *(("dry_ends",) if ends else ()))
    dry = own.choices("dry_ends", ENDS) if own.has("dry_ends") else ()
    return RodFluid(_coefficients(own), dry_ends=dry)


def read_link_fluid(reader: Reader) -> bool:
    """Read ``fluid`` of a flexible link, which can only be ``none``; return whether it is there."""
    if reader.has("fluid") and not reader.says("fluid", "none"):
        reader.refuse("none: a flexible link has no surface, a rod has one", "fluid")
    return reader.has("fluid")


def read_body_fluid(reader: Reader, com: Pose) -> BodyFluid | None:
    """Read ``fluid`` of a rigid body whose centre of mass is ``com``; None: it feels no fluid."""
    if not reader.has("fluid") or reader.says("fluid", "none"):
        return None
    own = reader.mapping("fluid") if reader.is_mapping("fluid") else _no_mapping(reader)
    own.only(
        "radius", "semi_axes", "volume", "center", "area", "drag", "viscous", "rotary_drag",
        "rotary_viscous", "lift", "added_mass", "added_inertia",
    )  # fmt: skip
    kind = own.one_of(("radius", "semi_axes", "volume"))
    if kind == "volume":
        volume, added, turned = own.number("volume", NONNEGATIVE), np.zeros(3), np.zeros(3)
        area = own.vector("area", 3, NONNEGATIVE, default=(0, 0, 0))
    else:
        for key in ("volume", "area"):
            own.no_effect(key, f"{kind} says it")
        axes = np.full(3, own.number("radius", POSITIVE)) if kind == "radius" else None
        axes = own.vector("semi_axes", 3, POSITIVE) if axes is None else axes
        volume, area, added, turned = ellipsoid(axes)
    for key in ("drag", "lift"):
        if own.has(key) and not area.any():
            own.refuse("an area beside it: without one there is nothing that the flow sees", key)
    return BodyFluid(
        center=read_pose(own.mapping("center")) if own.has("center") else com,
        volume=volume,
        added_mass=_three(own, "added_mass") if own.has("added_mass") else None,
        added_inertia=_three(own, "added_inertia") if own.has("added_inertia") else None,
        added_volume=added,
        added_moment=turned,
        area=area,
        drag=_three(own, "drag"),
        viscous=_three(own, "viscous"),
        rotary_drag=_three(own, "rotary_drag"),
        rotary_viscous=_three(own, "rotary_viscous"),
        lift=_three(own, "lift", FINITE),
    )


def check_fluid(fluid: Fluid | None, entries: Sequence[Reader]) -> None:
    """Refuse what bodies say of a fluid that is not there, and bodies that it has no place for."""
    for entry in entries:
        parts = [entry, *(entry.entries("sections") if entry.has("sections") else [])]
        for part in parts:
            if fluid is None:
                part.no_effect("fluid", "the scene has no fluid; fluid: {density: …} makes one")
        if fluid is not None and entry.has("flexible_link") and not entry.has("fluid"):
            expected = (
                "fluid: none for this body, which the fluid of the scene then does not touch: a "
                "flexible link has no surface, a rod has one"
            )
            entry.refuse(expected, "flexible_link")


def _coefficients(own: Reader) -> dict[str, Numbers]:
    found: dict[str, Numbers] = {}
    for key in DEFAULTS:
        within = FINITE if key == "lift" else NONNEGATIVE
        if not own.has(key):
            continue
        if key == "flooded":
            found[key] = (float(own.choice(key, ("true", "false")) == "true"),)
        elif key == "lift":
            found[key] = tuple(_three(own, key, within).tolist())
        elif key not in _ALONG and own.is_list(key):
            found[key] = tuple(own.vector(key, 2, within).tolist())
        else:
            found[key] = (own.number(key, within),) * 2
    return found


def _three(own: Reader, key: str, within: Interval = NONNEGATIVE) -> Floats:
    """Return a number for each axis: a list of three, or one for all (of a lift, for x)."""
    if key == "lift" and own.has(key) and not own.is_list(key):
        return np.array([own.number(key, within), 0.0, 0.0])
    if own.is_list(key):
        out: Floats = own.vector(key, 3, within)
        return out
    return np.full(3, own.number(key, within, default=0.0))


def _current(own: Reader) -> tuple[Course, ...]:
    """Return what the current does along world x, y, z; nothing if it stands still."""
    if not own.has("current"):
        return ()
    if not own.is_mapping("current"):
        u = own.vector("current", 3)
        return tuple(_constant(x) for x in u.tolist()) if u.any() else ()
    by_axis = own.mapping("current").only(*AXES)
    if not by_axis.keys():
        own.refuse("a list of three velocities, or courses of some of x, y, z", "current")
    courses = tuple(read_course(by_axis, c) if by_axis.has(c) else _constant(0.0) for c in AXES)
    for axis, course in zip(AXES, courses, strict=True):
        if not isinstance(course, Formula | TimeTable):
            by_axis.refuse("a formula in t, or a mapping: formula, table or file", axis)
    return courses


def _constant(value: float) -> Formula:
    return Formula(Expression(repr(value), "t"))


def _no_mapping(reader: Reader) -> NoReturn:
    reader.refuse("a mapping (key: value), or none", "fluid")
