"""Bodies that touch one another: which press on which, and the laws between them."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.contact import coupling  # noqa: F401 - it offers its units
from soft_sim_ros.core.model import contact as columns
from soft_sim_ros.core.model.contact import SLOTS
from soft_sim_ros.core.model.packing import floats, ints
from soft_sim_ros.core.model.pairs import CURVE, STICK, Pairs, no_pairs
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import ContactLaw, Material, RigidBody, Rod, Scene
from soft_sim_ros.scene.pairs import Pair, related

from .cells import Cell, cells_of, moving_shapes
from .chain import Chain
from .contact import BRISTLE, DEFAULT, ONSET, body_contact, softness


def asked_pairs(scene: Scene) -> tuple[Pair, ...]:
    """Return all pairs of a scene: those that are written, and bodies with moving shapes.

    A moving shape comes second.
    """
    found = list(scene.pairs)
    for shape in moving_shapes(scene):
        for body in scene.bodies:
            allowed = shape.bodies is None or body.name in shape.bodies
            shaped = isinstance(body, Rod) or (isinstance(body, RigidBody) and body.shape)
            if allowed and shaped and body_contact(body).possible and body.name != shape.on:
                key = f"environment.{shape.name}"
                found.append(Pair((body.name, shape.name), shape.law, shape.overlap, key))
    return tuple(found)


def flat_pairs(scene: Scene, chain: Chain) -> Pairs:
    """Return the contact of bodies with one another.

    Raises
    ------
    SceneError
        for what has no stiffness to touch with, or has no shape that can be touched
    """
    asked = asked_pairs(scene)
    if not asked:
        return no_pairs()
    names = list(dict.fromkeys(name for pair in asked for name in pair.bodies))
    cells: list[Cell] = []
    first = [0]
    for name in names:
        cells += cells_of(scene, chain, name)
        first.append(len(cells))
    number = {name: i for i, name in enumerate(names)}
    groups = {group: i for i, group in enumerate(dict.fromkeys(cell.group for cell in cells))}
    example = {cell.group: cell for cell in reversed(cells)}
    law = np.zeros((len(groups), len(groups), 9))
    pressing: dict[tuple[int, int], int] = {}
    half = set()
    for pair in asked:
        one, two = pair.bodies
        kin = one == two or related(scene.forest, one, two)
        if one == two:
            half.add(one)
        for source, target in _directions(scene, cells, pair):
            pressing[number[source], number[target]] = int(kin)
            for a, row in groups.items():
                for b, column in groups.items():
                    if a[0] == source and b[0] == target:
                        law[row, column] = pair_law(scene, pair, example[a], example[b])
    rubs = bool((law[:, :, columns.KINETIC] > 0.0).any())
    stations = [(i, row) for i, cell in enumerate(cells) for row in cell.stations]
    counts = np.bincount([i for i, _ in stations], minlength=len(cells))
    rows = floats([row for _, row in stations]).reshape(-1, 13)
    # a rod that touches itself presses from both sides
    halved = np.array([0.5 if cells[i].body in half else 1.0 for i, _ in stations])
    bound = floats([cell.bound for cell in cells])
    length = np.array([cell.size[0] if cell.kind == CURVE else 0.0 for cell in cells])
    return Pairs(
        cell=ints([i for i, _ in stations]),
        weight=floats(rows[:, 1:5]),
        arm=floats(rows[:, 5:11]),
        radius=floats(rows[:, 11]),
        share=floats(rows[:, 12] * halved),
        arc=floats(rows[:, 0]),
        ptr=ints([0, *np.cumsum(counts)]),
        node=ints([cell.node for cell in cells]).reshape(-1, 2),
        body=ints([number[cell.body] for cell in cells]),
        group=ints([groups[cell.group] for cell in cells]),
        kind=ints([cell.kind for cell in cells]),
        size=floats([cell.size for cell in cells]),
        rotation=floats([cell.axes for cell in cells]),
        centre=floats([cell.ends[:3] for cell in cells]),
        far=floats([cell.ends[3:] for cell in cells]),
        sign=floats([cell.sign for cell in cells]),
        taper=floats([cell.taper for cell in cells]),
        reach=floats([cell.reach for cell in cells]),
        end=ints([cell.free for cell in cells]).reshape(-1, 2),
        bound=bound,
        law=floats(law),
        first=ints(first),
        pair=ints([(*two, kin) for two, kin in pressing.items()]).reshape(-1, 3),
        margin=floats([float(np.mean((bound + 0.5 * length)[bound >= 0.0]))]),
        slots=ints([SLOTS if rubs else 0]),
        components=ints(range(6)),
    )


def _directions(scene: Scene, cells: list[Cell], pair: Pair) -> list[tuple[str, str]]:
    """Return who presses with its stations on whom.

    Rods press on rigid bodies, balls on capsules and both on boxes, the thinner on the thicker of
    one kind; corners of boxes press on all but rods and balls, which feel the whole box.
    """
    one, two = pair.bodies
    if one == two:
        return [(one, one)]
    mine = [[cell for cell in cells if cell.body == name] for name in (one, two)]
    if not any(cell.stations for cell in mine[1]):
        return [(one, two)]

    def rank(own: list[Cell]) -> tuple[int, float]:
        if own[0].kind == CURVE:
            order = 0
        elif own[0].kind == STICK:
            order = 1 if own[0].single else 2
        else:
            order = 3
        return order, min(row[11] for cell in own for row in cell.stations)

    ranks = [rank(own) for own in mine]
    if ranks[1] < ranks[0]:
        one, two = two, one
        ranks.reverse()
    if ranks[1][0] == 3 and ranks[0][0] >= 2:
        return [(one, two), (two, one)]
    return [(one, two)]


def pair_law(scene: Scene, pair: Pair, one: Cell, two: Cell) -> list[float]:
    """Return the row of the law of stations of a cell that presses on another one."""
    bodies = {body.name: body for body in scene.bodies}
    shapes = {shape.name: shape for shape in scene.environment}
    written = pair.law
    for name in bodies:  # of two that say something, the first one counts
        if name in pair.bodies:
            written = written.over(body_contact(bodies[name]).law)
    for name in pair.bodies:
        if name in shapes:
            written = written.over(shapes[name].law)
    written = written.over(scene.contact)
    law = written.over(DEFAULT)
    friction = law.friction
    assert friction is not None and law.dissipation is not None
    radius = one.stations[0][11]
    kind, stiffness = columns.LINEAR, written.stiffness
    bristle = stiffness
    if stiffness is None:
        kind, stiffness, bristle = _of_materials(scene, pair, one, two, written)
    elif one.single:
        stiffness *= radius  # a ball stands for its radius
        bristle = stiffness
    assert bristle is not None
    if law.tangential_stiffness is not None:
        bristle = law.tangential_stiffness * (radius if one.single else 1.0)
    onset = ONSET if law.onset is None else law.onset / radius
    time = 0.0 if law.tangential_time is None else law.tangential_time
    across = friction.across / friction.kinetic if friction.kinetic > 0.0 else 1.0
    return [
        *(float(kind), stiffness, onset, law.dissipation, friction.static, friction.kinetic),
        *(across if one.section is not None else 1.0, bristle, time),
    ]


def _material(scene: Scene, cell: Cell) -> Material | None:
    shape = next((shape for shape in moving_shapes(scene) if shape.name == cell.body), None)
    if shape is not None:
        return shape.law.material or scene.contact.material
    own = body_contact(next(body for body in scene.bodies if body.name == cell.body)).law.material
    if own is None and cell.section is not None:
        own = cell.section.material
    return own or scene.contact.material


def _of_materials(
    scene: Scene, pair: Pair, one: Cell, two: Cell, written: ContactLaw
) -> tuple[int, float, float]:
    """Return kind, stiffness and that of the bristles by Hertz, as for shapes (contact.py)."""
    both = (_material(scene, one) or pair.law.material, _material(scene, two) or pair.law.material)
    found = [material for material in both if material is not None]
    if not found:
        expected = "a stiffness in Pa, or the name of a material, in its contact"
        raise SceneError(scene.file, pair.key, " and ".join(pair.bodies), expected)
    modulus = 1.0 / sum(softness(material) for material in found)
    if not one.single:
        return columns.LINEAR, 0.25 * np.pi * modulus, 0.25 * np.pi * modulus
    radius = one.stations[0][11]
    curved = 1.0 / radius
    if two.single:
        curved += 1.0 / two.stations[0][11]
    elif two.kind == columns.SPHERE:
        curved += two.sign / two.size[0]
    stiffness = 4.0 / 3.0 * modulus / np.sqrt(curved)
    return columns.HERTZ, stiffness, 1.5 * stiffness * np.sqrt(BRISTLE * radius)


def cells_by_name(scene: Scene, chain: Chain) -> list[tuple[str, float]]:
    """Return of every cell of ``flat_pairs`` its body, and the arc length at its begin in m."""
    found = []
    for name in dict.fromkeys(name for pair in asked_pairs(scene) for name in pair.bodies):
        begins = chain.behind[chain.rods[name].first_node] if name in chain.rods else 0.0
        found += [(name, begins) for _ in cells_of(scene, chain, name)]
    return found
