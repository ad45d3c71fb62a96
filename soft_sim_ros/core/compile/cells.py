"""Cells of bodies that touch one another: pieces of rods, rigid bodies, shapes that move.

Stations of a rod are so close that nothing slips between them, however few nodes it has.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.core.model import contact as columns
from soft_sim_ros.core.model.pairs import CURVE, STICK
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import BASE, RigidBody, Rod, Scene, Section, Shape
from soft_sim_ros.scene.cross_section import Annulus, Circle
from soft_sim_ros.scene.environment import KINDS

from .chain import Chain

SPACING = 0.25  # of stations along a rod or a capsule, over its radius
MOST = 100_000  # stations on a piece of a body
SLOPE = 1e-6  # of a section: over which slopes of its radius are taken


@dataclass(frozen=True)
class Cell:
    """A piece of a body that touches and is touched.

    node : its two nodes; kind: of a shape, CURVE or STICK
    body, section : names
    size, axes, ends, sign, taper, reach, free, bound : as Pairs has them
    stations : rows (arc length, shares of nodes (4,), arms (6,), radius, length it stands for)
    single : whether its station is a ball of its own, not one of a row
    """

    node: tuple[int, int]
    kind: int
    body: str
    section: Section | None
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axes: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    ends: tuple[float, ...] = (0.0,) * 6
    sign: float = 1.0
    taper: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    reach: tuple[float, float] = (0.0, 0.0)
    free: tuple[int, int] = (0, 0)
    bound: float = -1.0
    stations: tuple[tuple[float, ...], ...] = ()
    single: bool = False

    @property
    def group(self) -> tuple[str, str | None, float]:
        """What decides its law."""
        name = None if self.section is None else self.section.name
        return self.body, name, self.taper[0] if self.single else 0.0


def moving_shapes(scene: Scene) -> tuple[Shape, ...]:
    """Return the shapes of the environment that move with a body."""
    return tuple(shape for shape in scene.environment if shape.on is not None)


def cells_of(scene: Scene, chain: Chain, name: str) -> list[Cell]:
    """Return the cells of a body, or of a shape that moves."""
    shape = next((shape for shape in moving_shapes(scene) if shape.name == name), None)
    if shape is not None:
        return [_of_shape(chain, shape)]
    body = next(body for body in scene.bodies if body.name == name)
    if isinstance(body, Rod):
        return _of_rod(scene, chain, body)
    assert isinstance(body, RigidBody) and body.shape is not None
    return [_of_solid(scene, chain, body)]


def _of_shape(chain: Chain, shape: Shape) -> Cell:
    assert shape.on is not None
    node = 0 if shape.on == BASE else chain.frames.get(shape.on, chain.ends.get(shape.on, 0))
    size = shape.size.tolist()
    bound = float(np.linalg.norm(shape.size))
    if shape.kind == "plane" or shape.inside:
        bound = -1.0
    elif shape.kind == "capsule":
        bound = size[0] + size[1]
    return Cell(
        (node, node),
        KINDS.index(shape.kind),
        shape.name,
        None,
        size=(size[0], size[1], size[2]),
        axes=tuple(shape.axes.ravel().tolist()),
        ends=(*shape.position.tolist(), 0.0, 0.0, 0.0),
        sign=-1.0 if shape.inside else 1.0,
        bound=bound,
    )


def _of_solid(scene: Scene, chain: Chain, body: RigidBody) -> Cell:
    node, solid = chain.frames[body.name], body.shape
    assert solid is not None
    arc, r = chain.behind[node], solid.radius
    if solid.kind == "box":
        half, axes = solid.half, solid.axes
        middle = np.mean(solid.centres, axis=0)
        rows = [
            (arc, 1.0, 0.0, 1.0, 0.0, *at, 0.0, 0.0, 0.0, r, solid.reach) for at in solid.centres
        ]
        bound = float(np.linalg.norm(half))
        return Cell(
            (node, node),
            columns.BOX,
            body.name,
            None,
            size=half,
            axes=axes,
            ends=(*middle.tolist(), 0.0, 0.0, 0.0),
            bound=bound,
            reach=(arc, arc),
            stations=tuple(rows),
        )
    single = solid.segment is None
    ends = np.array([solid.centres[0]] * 2 if solid.segment is None else solid.segment)
    length = float(np.linalg.norm(ends[1] - ends[0]))
    if single:
        places = [(0.0, 1.0)]
    else:
        count = _count(scene, body.name, length, r)
        places = [((i + 0.5) / count, length / count) for i in range(count)]
        places = [(0.0, r), *places, (1.0, r)]
    rows = [
        (arc, 1.0, 0.0, 1.0, 0.0, *(ends[0] + t * (ends[1] - ends[0])), 0.0, 0.0, 0.0, r, share)
        for t, share in places
    ]
    return Cell(
        (node, node),
        STICK,
        body.name,
        None,
        ends=(*ends[0].tolist(), *ends[1].tolist()),
        taper=(r, r, 0.0, 0.0),
        reach=(arc, arc),
        bound=0.5 * length + r,
        stations=tuple(rows),
        single=single,
    )


def _of_rod(scene: Scene, chain: Chain, rod: Rod) -> list[Cell]:
    rod_map = chain.rods[rod.name]
    before = chain.behind[rod_map.first_node]
    begins = _begins_free(chain, rod_map.first_node)
    pieces = [(k, s) for k, s in chain.rod_segments(rod_map) if s.span[1] > s.span[0]]
    slopes = _radius_slopes(scene, rod, [s.span for _, s in pieces])
    cells = []
    for i, (k, segment) in enumerate(pieces):
        begin, end = segment.span
        length = end - begin
        section = _section_at(rod, 0.5 * (begin + end))
        r0, r1 = _radius(scene, rod, section, begin), _radius(scene, rod, section, end)
        last = i == len(pieces) - 1 and k + 1 in chain.tips
        free = int(i == 0), int(i == len(pieces) - 1)
        count = _count(scene, rod.name, length, 0.5 * (r0 + r1))
        places = [((j + 0.5) / count, length / count) for j in range(count)]
        if i == 0 and begins:
            places.insert(0, (0.0, r0))
        if last:
            places.append((1.0, r1))
        taper = (r0, r1, length * slopes[i], length * slopes[i + 1])
        rows = []
        for t, share in places:
            w1, w2 = t * t * (3.0 - 2.0 * t), (1.0 - t)
            o1, o2 = length * t * w2 * w2, -length * t * t * w2
            own = _hermite(taper, t)
            arms = (o1, 0.0, 0.0, o2, 0.0, 0.0)
            arc = before + begin + t * length
            rows.append((arc, 1.0 - w1, w1, w2, t, *arms, own, share))
        cells.append(
            Cell(
                (segment.origin, k + 1),
                CURVE,
                rod.name,
                section,
                size=(length, 0.0, 0.0),
                taper=taper,
                reach=(before + begin, before + end),
                free=free,
                bound=max(r0, r1, *(row[11] for row in rows)),
                stations=tuple(rows),
            )
        )
    return cells


def _count(scene: Scene, name: str, length: float, radius: float) -> int:
    """Return how many stations there are on a length in m of a body.

    Raises
    ------
    SceneError
        if there are too many
    """
    count = length / (SPACING * radius) if radius > 0.0 else np.inf
    if not count <= MOST:
        i = [body.name for body in scene.bodies].index(name)
        expected = (
            f"a thicker or shorter body: of {length:g} m with a radius of {radius:g} m, it would "
            f"touch others at {count:.3g} stations, at most {MOST} are allowed"
        )
        raise SceneError(scene.file, f"bodies[{i}]", name, expected)
    return max(1, int(np.ceil(count)))


def _begins_free(chain: Chain, node: int) -> bool:
    return any(turn + 1 == node for turn, _ in chain.free)


def _hermite(taper: tuple[float, float, float, float], t: float) -> float:
    u = 1.0 - t
    r0, r1, d0, d1 = taper
    return r0 * (1 + 2 * t) * u * u + r1 * t * t * (3 - 2 * t) + d0 * t * u * u - d1 * t * t * u


def _section_at(rod: Rod, s: float) -> Section:
    ends = rod.boundaries
    i = int(np.clip(np.searchsorted(ends, s, side="right") - 1, 0, len(rod.sections) - 1))
    return rod.sections[i]


def _radius(scene: Scene, rod: Rod, section: Section, s: float) -> float:
    """Return the radius in m of a round section at an arc length of its rod."""
    i = [own.name for own in rod.sections].index(section.name)
    x = np.array(np.clip((s - rod.boundaries[i]) / section.length, 0.0, 1.0))
    shape = section.cross_section
    if isinstance(shape, Circle):
        return float(shape.radius(x))
    if isinstance(shape, Annulus):
        return float(shape.outer(x))
    where = [body.name for body in scene.bodies].index(rod.name)
    key = f"bodies[{where}].sections[{i}].cross_section"
    expected = "a circle or an annulus: only round rods touch other bodies"
    raise SceneError(scene.file, key, section.name, expected)


def _radius_slopes(scene: Scene, rod: Rod, spans: list[tuple[float, float]]) -> list[float]:
    """Return dr/ds at the ends of cells; where sections meet, the mean of both."""
    marks = [spans[0][0], *(end for _, end in spans)]
    slopes = []
    for i, s in enumerate(marks):
        own = []
        for begin, end in spans[max(0, i - 1) : i + 1]:
            section = _section_at(rod, 0.5 * (begin + end))
            d = SLOPE * section.length
            a, b = max(s - d, begin), min(s + d, end)
            change = _radius(scene, rod, section, b) - _radius(scene, rod, section, a)
            own.append(change / (b - a))
        slopes.append(float(np.mean(own)))
    return [0.0 if abs(slope) < 1e-9 else slope for slope in slopes]
