"""Stations on bodies, shapes in the base frame, and the laws between them.

Stations of a rod are its nodes, each standing for the length of its weight, with the radius of the
cross-section there; a free end is round and stands for a length of one radius more. What is flat
(an ellipse, a rectangle) has several balls a node.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.contact import balance, force  # noqa: F401 - they offer their units
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model import contact as columns
from soft_sim_ros.core.model.contact import SLOTS, Contact, no_contact
from soft_sim_ros.core.model.packing import floats, ints
from soft_sim_ros.core.quadrature import lobatto
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import (
    BodyContact,
    ContactLaw,
    FlexibleLink,
    Friction,
    Material,
    RigidBody,
    Rod,
    Scene,
    Section,
    Shape,
)
from soft_sim_ros.scene.cross_section import Annulus, Circle, Ellipse, Rectangle
from soft_sim_ros.scene.environment import KINDS

from .chain import Chain, RodMap

# What is not written: friction, s/m, of a radius, s.
DEFAULT = ContactLaw(
    onset=None, dissipation=1.0, friction=Friction(0.5, 0.5, 0.5), tangential_time=1e-3
)
ONSET = 0.01  # of the radius
BRISTLE = 1e-3  # of the radius: depth whose slope the bristles of Hertz's law have
ROUNDED = 0.1  # of the shorter side of a rectangle
PIECES = 9  # stations of a rigid capsule
HOLDS = ("sdirk2", "sdirk3", "sdirk4", "adaptive")  # methods that end a step with its last stage


@dataclass(frozen=True)
class Station:
    """A ball on a body, with what it stands for.

    node : that it is fixed to; offset (3,) of its centre there, m
    radius : m; share: length that it stands for, m
    body : name; s: arc length in m along it, 0 on rigid bodies
    section : of a rod; None on a rigid body
    single : whether it is a ball of its own, not one of a row
    """

    node: int
    offset: tuple[float, float, float]
    radius: float
    share: float
    body: str
    s: float
    section: Section | None
    single: bool = False


def flat_contact(scene: Scene, chain: Chain) -> Contact:
    """Return the contact of a scene with the shapes of its environment.

    Raises
    ------
    SceneError
        for what has no stiffness to touch with, does not fit into what it is inside of, or cannot
        be stepped with contact
    """
    meets = bool(scene.pairs or scene.environment)
    if not meets:
        _refuse_without(scene)
        return no_contact()
    _refuse(scene)
    found = stations(scene, chain)
    if not found:
        raise SceneError(scene.file, "environment", scene.name, "a body that can touch it")
    groups: dict[tuple[str, str | None, float], int] = {}
    rows: list[list[list[float]]] = []
    group: list[int] = []
    for station in found:
        name = None if station.section is None else station.section.name
        key = station.body, name, station.radius if station.single else 0.0
        if key not in groups:
            groups[key] = len(rows)
            rows.append([_law(scene, i, station) for i in range(len(fixed_shapes(scene)))])
        group.append(groups[key])
    law = floats(rows).reshape(len(rows), -1, 9)
    _refuse_thick(scene, found, law, group)
    rubbing = int((law[:, :, columns.KINETIC] > 0.0).any(axis=0).sum())
    base = se3.pose_matrix(scene.base.position, scene.base.quaternion)
    shapes = fixed_shapes(scene)
    single = (law[:, :1, columns.KIND] == columns.HERTZ).any(axis=1)
    counts = np.bincount([station.node for station in found], minlength=chain.node + 1)
    return Contact(
        ptr=ints([0, *np.cumsum(counts)]),
        node=ints([station.node for station in found]),
        offset=floats([station.offset for station in found]).reshape(-1, 3),
        radius=floats([station.radius for station in found]),
        share=floats([1.0 if single[g] else s.share for g, s in zip(group, found, strict=True)]),
        group=ints(group),
        law=law,
        kind=ints([KINDS.index(shape.kind) for shape in shapes]),
        size=floats([shape.size for shape in shapes]).reshape(-1, 3),
        rotation=floats([(base[:3, :3].T @ shape.axes).ravel() for shape in shapes]).reshape(-1, 9),
        centre=floats(
            [base[:3, :3].T @ (shape.position - base[:3, 3]) for shape in shapes]
        ).reshape(-1, 3),
        sign=floats([-1.0 if shape.inside else 1.0 for shape in shapes]),
        bound=floats([_bound(shape) for shape in shapes]),
        slots=ints([min(SLOTS, rubbing)]),
        components=ints(range(6)),
    )


def _bound(shape: Shape) -> float:
    """Return the radius of a ball about the centre that holds a shape; −1 if none does."""
    if shape.kind == "plane" or shape.inside:
        return -1.0
    r, half, _ = shape.size.tolist()
    if shape.kind == "capsule":
        return r + half
    if shape.kind == "ellipsoid":
        return float(shape.size.max())
    return float(np.linalg.norm(shape.size))


def _refuse(scene: Scene) -> None:
    numerics = scene.numerics
    if numerics.integrator not in HOLDS:
        expected = f"one of {', '.join(HOLDS)}: contact needs a step that ends with a stage"
        raise SceneError(scene.file, "numerics.integrator", numerics.integrator, expected)
    for i, body in enumerate(scene.bodies):
        if isinstance(body, FlexibleLink) and body.rod.contact.possible:
            expected = "contact: false: a flexible_link cannot touch anything, a rod can"
            raise SceneError(scene.file, f"bodies[{i}].contact", None, expected)


def _refuse_without(scene: Scene) -> None:
    """Refuse keys that have no effect where nothing can be touched."""
    if scene.contact != ContactLaw():
        raise SceneError(
            scene.file, "contact", "(a mapping)", "an environment or pairs: nothing can be touched"
        )


def fixed_shapes(scene: Scene) -> tuple[Shape, ...]:
    """Return the shapes of the environment that do not move."""
    return tuple(shape for shape in scene.environment if shape.on is None)


def body_contact(body: object) -> BodyContact:
    """Return what a body says about contact; joints cannot touch."""
    return body.contact if isinstance(body, Rod | RigidBody) else BodyContact(False)


def stations(scene: Scene, chain: Chain) -> list[Station]:
    """Return the stations of all bodies that can touch, in the order of their nodes."""
    found: list[Station] = []
    for body in scene.bodies:
        if not body_contact(body).possible:
            continue
        if isinstance(body, Rod):
            found += _of_rod(chain, chain.rods[body.name])
        elif isinstance(body, RigidBody) and body.shape is not None:
            found += _of_solid(chain, body)
    return sorted((s for s in found if s.node > 0), key=lambda station: station.node)


def _of_rod(chain: Chain, rod_map: RodMap) -> list[Station]:
    rod = rod_map.rod
    fixed = _held_by_base(chain, rod_map.first_node)
    begins_free = any(turn + 1 == rod_map.first_node for turn, _ in chain.free)
    merged: dict[tuple[int, str], tuple[float, Section, float]] = {}
    for element in rod_map.elements:
        begin, end = element.span
        weights = lobatto(element.nodes)[1]
        for i, (s, weight) in enumerate(zip(element.lumps[0], weights, strict=True)):
            key = element.first_segment + i, element.section.name
            share = merged[key][0] if key in merged else 0.0
            merged[key] = share + (end - begin) * weight, element.section, float(s)
    out = []
    for (node, _), (share, section, s) in merged.items():
        begin = rod.boundaries[[x.name for x in rod.sections].index(section.name)]
        balls = _balls(section, (s - begin) / section.length)
        thick = max(radius + float(np.hypot(*offset[1:])) for offset, radius in balls)
        if fixed and s <= thick:
            continue  # where it is mounted
        at_end = (node == rod_map.last_node and node in chain.tips) or (
            node == rod_map.first_node and begins_free
        )
        for offset, radius in balls:
            cap = radius if at_end else 0.0
            length = share + cap if len(balls) == 1 else share / len(balls) + cap
            out.append(Station(node, offset, radius, length, rod.name, s, section))
    return out


def _held_by_base(chain: Chain, node: int) -> bool:
    """Return whether nothing can move a node."""
    while node > 0:
        segment = chain.segments[node - 1]
        if segment.entries:
            return False
        node = segment.origin
    return True


def _balls(section: Section, x: float) -> list[tuple[tuple[float, float, float], float]]:
    """Return the balls (offset, radius) of a cross-section at x ∈ [0, 1]."""
    shape, at = section.cross_section, np.array(min(max(x, 0.0), 1.0))
    if isinstance(shape, Circle):
        return [((0.0, 0.0, 0.0), float(shape.radius(at)))]
    if isinstance(shape, Annulus):
        return [((0.0, 0.0, 0.0), float(shape.outer(at)))]
    if isinstance(shape, Ellipse):
        y, z = float(shape.semi_axis_y(at)), float(shape.semi_axis_z(at))
        wide, flat = max(y, z), min(y, z)
        if wide - flat <= 1e-9 * wide:
            return [((0.0, 0.0, 0.0), flat)]
        ways = [(0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
        way = np.array(ways[0] if y > z else ways[1]) * (wide - flat)
        return [(_triple(-way), flat), (_triple(way), flat)]
    assert isinstance(shape, Rectangle)
    y, z = 0.5 * float(shape.width_y(at)), 0.5 * float(shape.width_z(at))
    radius = 2.0 * ROUNDED * min(y, z)
    corners = [(a * (y - radius), b * (z - radius)) for a in (-1, 1) for b in (-1, 1)]
    return [((0.0, a, b), radius) for a, b in corners]


def _triple(v: Floats) -> tuple[float, float, float]:
    return float(v[0]), float(v[1]), float(v[2])


def _of_solid(chain: Chain, body: RigidBody) -> list[Station]:
    node, solid = chain.frames[body.name], body.shape
    assert solid is not None
    if solid.segment is None:
        single = solid.kind == "sphere"
        return [
            Station(node, at, solid.radius, solid.reach, body.name, 0.0, None, single)
            for at in solid.centres
        ]
    begin, end = np.array(solid.segment)
    x, weights = lobatto(PIECES)
    shares = np.linalg.norm(end - begin) * weights
    shares[[0, -1]] += solid.radius
    return [
        Station(node, _triple(begin + t * (end - begin)), solid.radius, w, body.name, 0.0, None)
        for t, w in zip(x, shares.tolist(), strict=True)
    ]


def _law(scene: Scene, index: int, station: Station) -> list[float]:
    """Return the row of the law of a station with a shape."""
    shape = fixed_shapes(scene)[index]
    if shape.bodies is not None and station.body not in shape.bodies:
        return [0.0] * 9
    body = next(body for body in scene.bodies if body.name == station.body)
    own = body_contact(body).law
    written = own.over(shape.law.over(scene.contact))
    law = written.over(DEFAULT)
    friction = law.friction
    assert friction is not None and law.dissipation is not None
    kind, stiffness = columns.LINEAR, written.stiffness
    bristle = stiffness
    if stiffness is None:
        kind, stiffness, bristle = _of_materials(scene, index, station, written)
    assert bristle is not None
    onset = ONSET if law.onset is None else law.onset / station.radius
    if law.tangential_stiffness is not None:
        hertz = kind == columns.HERTZ  # a ball then stands for its radius
        bristle = law.tangential_stiffness * (station.radius if hertz else 1.0)
    time = 0.0 if law.tangential_time is None else law.tangential_time
    across = friction.across / friction.kinetic if friction.kinetic > 0.0 else 1.0
    return [
        *(float(kind), stiffness, onset, law.dissipation, friction.static, friction.kinetic),
        *(across if station.section is not None else 1.0, bristle, time),
    ]


def _of_materials(
    scene: Scene, index: int, station: Station, written: ContactLaw
) -> tuple[int, float, float]:
    """Return kind, stiffness and that of the bristles by Hertz, of a body on a shape.

    A row of balls is a cylinder: π/4 E* per length and depth. A ball is one: 4/3 E* √R.
    """
    shape = fixed_shapes(scene)[index]
    bodies = {body.name: body for body in scene.bodies}
    own = body_contact(bodies[station.body]).law.material
    if own is None and station.section is not None:
        own = station.section.material
    other = shape.law.material or scene.contact.material
    if own is None:
        own = other
    if own is None:
        i = list(bodies).index(station.body)
        expected = "a stiffness in Pa, or the name of a material"
        raise SceneError(scene.file, f"bodies[{i}].contact", None, expected)
    modulus = 1.0 / (softness(own) + (softness(other) if other is not None else 0.0))
    if not station.single:
        return columns.LINEAR, 0.25 * np.pi * modulus, 0.25 * np.pi * modulus
    radius = station.radius
    if shape.kind == "sphere":
        curved = 1.0 / radius + (-1.0 if shape.inside else 1.0) / float(shape.size[0])
        radius = 1.0 / curved
    stiffness = 4.0 / 3.0 * modulus * np.sqrt(radius)
    return columns.HERTZ, stiffness, 1.5 * stiffness * np.sqrt(BRISTLE * station.radius)


def softness(material: Material) -> float:
    """Return (1 − ν²)/E in 1/Pa."""
    return (1.0 - material.poisson_ratio**2) / material.young_modulus


def _refuse_thick(scene: Scene, found: list[Station], law: Floats, group: list[int]) -> None:
    """Refuse bodies that are thicker than what they are inside of."""
    for i, shape in enumerate(fixed_shapes(scene)):
        at = scene.environment.index(shape)
        if not shape.inside:
            continue
        room = float(shape.size.min() if shape.kind == "ellipsoid" else shape.size[0])
        for station, g in zip(found, group, strict=True):
            if law[g, i, columns.KIND] != columns.NONE and station.radius >= room:
                expected = (
                    f"more than the radius of what is inside: {station.body} has "
                    f"{station.radius:g} m at s = {station.s:g} m, {shape.name} has {room:g} m"
                )
                key = f"environment[{at}].{shape.kind}"
                raise SceneError(scene.file, key, shape.name, expected)
