"""Fixed shapes that bodies can touch: the entries of ``environment``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene.contact import ContactLaw, read_contact
from soft_sim_ros.scene.interval import POSITIVE
from soft_sim_ros.scene.material import Material
from soft_sim_ros.scene.pose import quaternion_from_rpy
from soft_sim_ros.scene.reader import Reader, frozen
from soft_sim_ros.scene.taper import Floats

KINDS = ("plane", "sphere", "capsule", "cylinder", "box", "ellipsoid")
COMMON = ("inside", "contact", "bodies", "overlap", "on")
BASE = "base"  # as in attachment.py
HOLLOW = ("sphere", "capsule", "cylinder", "ellipsoid")


@dataclass(frozen=True, eq=False)
class Shape:
    """A shape fixed in the world, or in a body.

    kind : one of KINDS
    size : (3,) in m. Radius; radius and half of the length between the ends (capsule: between the
        centres of its round ends); half edges; semi-axes. 0 what there is not
    position, axes : of its centre in m, and (3, 3) its axes as columns. Capsules and cylinders lie
        along z; a plane is z = 0, its free side above
    inside : whether bodies are in it and it is hollow
    law : what it says about contact
    bodies : names of those that can touch it; None: all
    overlap : whether bodies may begin in it
    on : name of a body that it moves with, at whose end it is placed, or BASE; None: it is fixed
        in the world
    """

    name: str
    kind: str
    size: Floats
    position: Floats
    axes: Floats
    inside: bool
    law: ContactLaw
    bodies: tuple[str, ...] | None
    overlap: bool
    on: str | None = None


@dataclass(frozen=True)
class Solid:
    """What a rigid body looks like to what it touches: balls at ``centres`` (N, 3), in its frame.

    A capsule (``segment`` (2, 3)) is a row of balls, found when its stations are chosen.

    reach : length in m that every ball stands for; of a ball alone its radius
    half, axes : (3,) half edges in m of a box, and its axes (9,), row by row
    """

    kind: str
    radius: float
    centres: tuple[tuple[float, float, float], ...]
    segment: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    reach: float = 0.0
    half: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axes: tuple[float, ...] = ()


def read_environment(
    entries: list[Reader], materials: Mapping[str, Material], bodies: tuple[str, ...]
) -> tuple[Shape, ...]:
    """Read ``environment``, the shapes; ``bodies``: names of those in the scene."""
    shapes: list[Shape] = []
    for reader in entries:
        kind = reader.one_of(KINDS)
        name = reader.name(kind, taken={shape.name for shape in shapes})
        size, position, axes = _GEOMETRY[kind](reader)
        places = (BASE, *bodies)
        on = reader.reference("on", places, "body") if reader.has("on") else None
        named = reader.references("bodies", bodies, "body") if reader.has("bodies") else None
        if reader.has("inside") and kind not in HOLLOW:
            reader.no_effect("inside", f"a {kind} has no inside to be in")
        shapes.append(
            Shape(
                name=name,
                kind=kind,
                size=frozen(size),
                position=frozen(position),
                axes=frozen(axes),
                inside=reader.choice("inside", ("true", "false"), default="false") == "true",
                law=read_contact(reader.mapping("contact"), materials),
                bodies=named,
                overlap=reader.choice("overlap", ("true", "false"), default="false") == "true",
                on=on,
            )
        )
    return tuple(shapes)


Geometry = tuple[list[float], Floats, Floats]


def _plane(reader: Reader) -> Geometry:
    reader.only("plane", "position", "normal", *COMMON)
    normal = reader.vector("normal", 3, default=(0, 0, 1))
    if not np.linalg.norm(normal) > 0.0:
        reader.refuse("a direction that is not zero", "normal")
    position = reader.vector("position", 3, default=(0, 0, 0))
    return [0.0, 0.0, 0.0], position, axes_along(normal)


def _sphere(reader: Reader) -> Geometry:
    reader.only("sphere", "position", "radius", *COMMON)
    radius = reader.number("radius", POSITIVE)
    return [radius, 0.0, 0.0], reader.vector("position", 3, default=(0, 0, 0)), np.eye(3)


def _round(reader: Reader) -> Geometry:
    kind = "capsule" if reader.has("capsule") else "cylinder"
    reader.only(kind, "from", "to", "radius", *COMMON)
    begin, end = reader.vector("from", 3), reader.vector("to", 3)
    length = float(np.linalg.norm(end - begin))
    if not length > 0.0:
        reader.refuse(f"another point than from = {begin.tolist()}", "to")
    radius = reader.number("radius", POSITIVE)
    return [radius, 0.5 * length, 0.0], 0.5 * (begin + end), axes_along(end - begin)


def _posed(reader: Reader, key: str, kind: str) -> tuple[Floats, Floats, Floats]:
    reader.only(kind, key, "position", "rpy", *COMMON)
    size = reader.vector(key, 3, POSITIVE)
    rpy = reader.vector("rpy", 3, default=(0, 0, 0))
    return size, reader.vector("position", 3, default=(0, 0, 0)), turned(quaternion_from_rpy(rpy))


def _box(reader: Reader) -> Geometry:
    size, position, axes = _posed(reader, "size", "box")
    return (0.5 * size).tolist(), position, axes


def _ellipsoid(reader: Reader) -> Geometry:
    size, position, axes = _posed(reader, "semi_axes", "ellipsoid")
    return size.tolist(), position, axes


_GEOMETRY = {
    "plane": _plane,
    "sphere": _sphere,
    "capsule": _round,
    "cylinder": _round,
    "box": _box,
    "ellipsoid": _ellipsoid,
}


def axes_along(direction: Floats) -> Floats:
    """Return axes (3, 3), as columns, of which z is along a direction (3,)."""
    z = direction / np.linalg.norm(direction)
    if (np.abs(z) > 1.0 - 1e-15).any():  # along an axis: exactly
        z = np.round(z)
    least = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(least, z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def turned(quaternion: Floats) -> Floats:
    """Return the rotation matrix (3, 3) of a unit quaternion x y z w."""
    x, y, z, w = quaternion
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def read_solid(reader: Reader) -> Solid | None:
    """Read the ``shape`` of a rigid body, None if it has none."""
    if not reader.has("shape"):
        return None
    own = reader.mapping("shape")
    kind = own.choice("kind", ("sphere", "capsule", "box"))
    if kind == "sphere":
        own.only("kind", "radius", "position")
        radius = float(own.number("radius", POSITIVE))
        at = own.vector("position", 3, default=(0, 0, 0)).tolist()
        return Solid(kind, radius, ((at[0], at[1], at[2]),), reach=radius)
    if kind == "capsule":
        own.only("kind", "radius", "from", "to")
        begin, end = own.vector("from", 3), own.vector("to", 3)
        if not float(np.linalg.norm(end - begin)) > 0.0:
            own.refuse(f"another point than from = {begin.tolist()}", "to")
        ends = tuple(begin.tolist()), tuple(end.tolist())
        return Solid(kind, float(own.number("radius", POSITIVE)), (), ends)
    own.only("kind", "size", "position", "rpy", "rounding")
    size = own.vector("size", 3, POSITIVE)
    at, rpy = own.vector("position", 3, default=(0, 0, 0)), own.vector("rpy", 3, default=(0, 0, 0))
    least = float(size.min())
    rounding = float(own.number("rounding", POSITIVE, default=0.05 * least))
    if rounding > 0.5 * least:
        own.refuse(f"at most half of the shortest edge, {0.5 * least:g} m", "rounding")
    signs = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
    axes = turned(quaternion_from_rpy(rpy))
    corners = at + (signs * (0.5 * size - rounding)) @ axes.T
    reach = float(np.prod(size) ** (1 / 3)) / 4.0
    half = 0.5 * float(size[0]), 0.5 * float(size[1]), 0.5 * float(size[2])
    return Solid(
        kind,
        rounding,
        tuple(tuple(c) for c in corners.tolist()),
        reach=reach,
        half=half,
        axes=tuple(axes.ravel().tolist()),
    )
