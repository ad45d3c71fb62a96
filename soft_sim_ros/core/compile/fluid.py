"""The fluid of a scene, lumped to nodes as mass is: places at which it acts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.floats import Floats, Ints
from soft_sim_ros.core.model.model import Drives, Wetted, new_live
from soft_sim_ros.core.model.packing import floats, ints
from soft_sim_ros.core.terms.driven import known_motion
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import RigidBody, Scene
from soft_sim_ros.scene.driven import Formula
from soft_sim_ros.scene.fluid import LAWS, BodyFluid, Fluid, outline

from .chain import Chain
from .drives import flat_courses
from .element import Element
from .spans import RodMap


@dataclass
class _Place:
    """A row of the arrays of ``Wetted``."""

    node: int
    added: Floats
    displaced: float
    quadratic: Floats
    linear: Floats
    lift: Floats = field(default_factory=lambda: np.zeros(3))
    law: int = 0
    end: float = 0.0
    frame: Floats | None = None  # (4, 4) in that of the node
    element: Element | None = None
    share: float = 1.0  # length in m of a place of an element


def flat_fluid(scene: Scene, chain: Chain) -> Wetted:
    """Return the places at which the fluid acts, in the order of their nodes; none without it."""
    places = _places(scene, chain)
    counts = np.bincount([place.node for place in places], minlength=chain.node + 1)
    base = se3.pose_matrix(scene.base.position, scene.base.quaternion)
    frames = [np.eye(4) if place.frame is None else place.frame for place in places]
    surface = 0.0 if scene.fluid is None else scene.fluid.surface
    return Wetted(
        ptr=ints([0, *np.cumsum(counts)] if places else []),
        node=ints([place.node for place in places]),
        frame=floats([[*g[:3, :3].ravel(), *g[:3, 3]] for g in frames]).reshape(-1, 12),
        added=floats([place.added for place in places]).reshape(-1, 6),
        displaced=floats([place.displaced for place in places]),
        quadratic=floats([place.quadratic for place in places]).reshape(-1, 6),
        viscous=floats([place.linear for place in places]).reshape(-1, 6),
        lift=floats([place.lift for place in places]).reshape(-1, 3),
        law=ints([place.law for place in places]),
        end=floats([place.end for place in places]),
        base=floats([*base[:3, :3].ravel(), *base[:3, 3], surface]),
    )


def flat_current(scene: Scene) -> Drives:
    """Return the current along world x, y, z as programs in time; none where it stands still.

    Raises
    ------
    SceneError
        if it has no rate at the start
    """
    courses = () if scene.fluid is None else scene.fluid.current
    programs, nobody = flat_courses(courses, range(len(courses))), new_live(0, 0).course
    for i, (axis, course) in enumerate(zip("xyz", courses, strict=False)):
        motion = np.zeros(3)
        known_motion(programs, nobody, i, 0.0, motion)
        if not np.isfinite(motion[:2]).all():
            text = course.expression.text if isinstance(course, Formula) else "(table)"
            expected = "a formula with a rate at t = 0"
            raise SceneError(scene.file, f"fluid.current.{axis}", text, expected)
    return programs


def places_of(scene: Scene, chain: Chain) -> dict[int, tuple[Ints, Floats]]:
    """Return by the first segment of an element its places (N,) and their lengths (N,) in m."""
    own: dict[int, list[tuple[int, float]]] = {}
    for i, place in enumerate(_places(scene, chain)):
        if place.element is not None:
            own.setdefault(place.element.first_segment, []).append((i, place.share))
    return {
        first: (ints([i for i, _ in found]), floats([share for _, share in found]))
        for first, found in own.items()
    }


def _places(scene: Scene, chain: Chain) -> list[_Place]:
    fluid, found = scene.fluid, list[_Place]()
    if fluid is None:
        return found
    for rod_map in chain.rods.values():
        if not rod_map.rod.fluid.dry:
            for element in rod_map.elements:
                found += _along(fluid, rod_map, element)
            found += _dry_ends(fluid, chain, rod_map)
    for body in scene.bodies:
        if isinstance(body, RigidBody) and body.fluid is not None:
            found.append(_of_body(fluid, chain.frames[body.name], body.fluid))
    return sorted(found, key=lambda place: place.node)


def _along(fluid: Fluid, rod_map: RodMap, element: Element) -> list[_Place]:
    """Return the places along an element: those of its lumped masses."""
    section = element.section
    if section.fluid.dry:
        return []
    given = fluid.coefficients(rod_map.rod.fluid, section.fluid)
    _, x, weights = element.lumps
    length, shape, rho = weights[:, 0], outline(section.cross_section, x), fluid.density
    none = np.zeros(len(length))

    def six(along: Floats, across: Floats) -> Floats:
        return np.stack([none, none, none, along * length, *(across * length[:, None]).T], axis=1)

    circle = np.pi / 4.0 * shape.across**2
    water = given["flooded"][0] * rho * shape.bore[:, None]  # inside, carried along
    added = six(none, rho * circle * np.array(given["added_mass"]) + water)
    drag = six(
        0.5 * rho * given["drag_tangential"][0] * shape.perimeter,
        0.5 * rho * shape.across * np.array(given["drag_normal"]),
    )
    viscous = six(
        given["viscous_tangential"][0] + none, none[:, None] + np.array(given["viscous_normal"])
    )
    width = shape.across.mean(axis=1)
    lift = 0.5 * rho * (width * length)[:, None] * np.array(given["lift"])
    displaced = rho * fluid.displaced(rod_map.rod.fluid, section.fluid, shape) * length
    law = LAWS.index("split") if fluid.law == "split" else LAWS.index("whole")
    return [
        _Place(
            element.first_segment + i, added[i], float(displaced[i]), drag[i], viscous[i],
            lift[i], law, element=element, share=float(length[i]),
        )
        for i in range(len(length))
    ]  # fmt: skip


def _dry_ends(fluid: Fluid, chain: Chain, rod_map: RodMap) -> list[_Place]:
    """Return the pressure that is missing on the ends of a rod."""
    found = []
    for name in rod_map.rod.fluid.dry_ends:
        section = rod_map.rod.sections[0 if name == "start" else -1]
        if section.fluid.dry:
            continue
        x = np.array([0.0 if name == "start" else 1.0])
        shape = outline(section.cross_section, x)
        size = fluid.density * float(fluid.displaced(rod_map.rod.fluid, section.fluid, shape)[0])
        node = chain.node_at(rod_map, 0.0 if name == "start" else rod_map.length)
        end = -size if name == "start" else size
        found.append(_Place(node, np.zeros(6), 0.0, np.zeros(6), np.zeros(6), end=end))
    return found


def _of_body(fluid: Fluid, node: int, body: BodyFluid) -> _Place:
    rho = fluid.density
    mass = rho * body.added_volume if body.added_mass is None else body.added_mass
    turned = rho * body.added_moment if body.added_inertia is None else body.added_inertia
    return _Place(
        node=node,
        added=np.concatenate([turned, mass]),
        displaced=rho * body.volume,
        quadratic=np.concatenate([body.rotary_drag, 0.5 * rho * body.drag * body.area]),
        linear=np.concatenate([body.rotary_viscous, body.viscous]),
        lift=0.5 * rho * body.lift * float(body.area[1:].mean()),
        law=LAWS.index("whole"),
        frame=se3.pose_matrix(body.center.position, body.center.quaternion),
    )
