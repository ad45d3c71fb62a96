"""Arrays of contact between bodies: cells that touch, stations on them, by which law they do.

A cell is a piece of a rod between two nodes, or the shape of a rigid body, or a shape that moves
with a body. Stations are balls on cells; they press on other cells. So the same cell may press
with its stations and be pressed upon.
"""

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.algebra.motion_space import Space
from soft_sim_ros.core.backend.structs import struct
from soft_sim_ros.core.floats import Floats, Ints

from .contact import BOX, CAPSULE, CYLINDER, ELLIPSOID, PLANE

# Pairs.kind beyond those of shapes (contact.py): a curve between two nodes, a rod with round ends
CURVE, STICK = 10, 11
# Meet.call
MEET, COUPLE, STORED, SETTLE = range(4)
# columns of Meet.report: gap, normal, point, forces on the station, whether it sticks, velocity
GAP, NORMAL, POINT, PUSH, PULL, STICKS, SLIDE = 0, 1, 4, 7, 8, 11, 12
REPORTED = 15
SOURCE, TARGET, KIN = 0, 1, 2  # columns of Pairs.pair
HITS = 4  # places a station may touch at, on average
# (S, T) pairs of cells that are near are kept, up to so many per cell
NEIGHBOURS = 32


@struct
class Pairs(NamedTuple):
    """Q stations on T cells of B bodies; all arrays empty where bodies do not touch one another."""

    cell: Ints  # (Q,) that a station is on
    weight: Floats  # (Q, 4) shares of its two nodes in its place, and in its spin
    arm: Floats  # (Q, 6) along the axes of its two nodes, m
    radius: Floats  # (Q,) m
    share: Floats  # (Q,) length that it stands for, m; 1 for HERTZ
    arc: Floats  # (Q,) arc length from the base, m
    ptr: Ints  # (T + 1,) stations on a cell
    node: Ints  # (T, 2) its nodes, twice the same for what is rigid
    body: Ints  # (T,)
    group: Ints  # (T,) row of the laws
    kind: Ints  # (T,) of a shape, CURVE or STICK
    size: Floats  # (T, 3) of a shape; the length of a CURVE
    rotation: Floats  # (T, 9) axes of a shape in the frame of its node
    centre: Floats  # (T, 3) of a shape; one end of a STICK, along the axes of its node
    far: Floats  # (T, 3) the other end of a STICK
    sign: Floats  # (T,) 1, or −1: hollow
    taper: Floats  # (T, 4) radius at both ends of a CURVE or STICK, and its slopes times length
    reach: Floats  # (T, 2) arc lengths from the base, m
    end: Ints  # (T, 2) whether a CURVE ends there
    bound: Floats  # (T,) radius about the middle that holds the cell, but for stretch; < 0: none
    law: Floats  # (G, G, 9) of stations of a group on cells of a group (contact.py)
    first: Ints  # (B + 1,) cells of a body
    pair: Ints  # (K, 3) bodies that press and are pressed upon; whether they are of one rod
    margin: Floats  # (1,) how far cells may move before those that are near are looked for again, m
    slots: Ints  # (1,) bristles of a station
    components: Ints  # components of twists that may not vanish


@struct
class Meet(NamedTuple):
    """Scratch of contact between bodies."""

    ball: Floats  # (T, 4) centre and radius of a ball that holds a cell
    seen: Floats  # (T, 3) centres when cells that are near were looked for
    near: Ints  # (N, 3) cells that press and are pressed upon; whether they are of one rod
    counts: Ints  # (3,) of them (−1: not looked for; −2: too many), hits, bristles in use
    hit: Ints  # (H, 3) station, cell, bristle (−1: none)
    spot: Floats  # (H,) where on the cell
    report: Floats  # (H, 15) see GAP …
    taken: Ints  # (Q,) bits of bristles in use
    call: Ints  # (4,) addresses: MEET, COUPLE, STORED, SETTLE


def no_pairs() -> Pairs:
    """Return the contact of bodies that do not touch one another."""
    none = np.zeros(0, dtype=np.int64)
    one = np.zeros(0)
    return Pairs(
        cell=none,
        weight=np.zeros((0, 4)),
        arm=np.zeros((0, 6)),
        radius=one,
        share=one,
        arc=one,
        ptr=none,
        node=np.zeros((0, 2), dtype=np.int64),
        body=none,
        group=none,
        kind=none,
        size=np.zeros((0, 3)),
        rotation=np.zeros((0, 9)),
        centre=np.zeros((0, 3)),
        far=np.zeros((0, 3)),
        sign=one,
        taper=np.zeros((0, 4)),
        reach=np.zeros((0, 2)),
        end=np.zeros((0, 2), dtype=np.int64),
        bound=one,
        law=np.zeros((0, 0, 9)),
        first=none,
        pair=np.zeros((0, 3), dtype=np.int64),
        margin=one,
        slots=none,
        components=none,
    )


def new_meet(pairs: Pairs) -> Meet:
    """Allocate scratch; addresses are filled in by who knows the model."""
    cells, stations = len(pairs.kind), len(pairs.cell)
    some = min(stations, 1)
    hits = HITS * stations + 64 * some
    return Meet(
        ball=np.zeros((cells, 4)),
        seen=np.zeros((cells, 3)),
        near=np.zeros((NEIGHBOURS * cells + 64 * some, 3), dtype=np.int64),
        counts=np.array([-1, 0, 0][: 3 * some], dtype=np.int64),
        hit=np.zeros((hits, 3), dtype=np.int64),
        spot=np.zeros(hits),
        report=np.zeros((hits, REPORTED)),
        taken=np.zeros(stations, dtype=np.int64),
        call=np.zeros(4 * some, dtype=np.int64),
    )


def columns_of(pairs: Pairs, n: int) -> int:
    """Return by how many columns contact of bodies may couple n coordinates at most."""
    return min(n, 6 * len(np.unique(pairs.node[pairs.node > 0]))) if len(pairs.cell) else 0


def pairs_within(pairs: Pairs, space: Space) -> Pairs | None:
    """Return the contact of bodies of a model that moves in a plane; None if it pushes it out."""
    if not len(pairs.cell):
        return pairs
    out = next(c for c in range(3) if 3 + c not in space.components)
    if pairs.arm[:, [out, 3 + out]].any() or pairs.centre[:, out].any() or pairs.far[:, out].any():
        return None
    turned = np.abs(pairs.rotation.reshape(-1, 3, 3)[:, out])
    straight = (np.isclose(turned, 0.0, atol=1e-12) | np.isclose(turned, 1.0, atol=1e-12)).all(1)
    aligned = np.isin(pairs.kind, (BOX, CAPSULE, CYLINDER, ELLIPSOID, PLANE))
    if (aligned & ~straight).any() or ((pairs.kind == PLANE) & (turned[:, 2] > 1e-12)).any():
        return None
    return pairs._replace(components=np.array(space.components, dtype=np.int64))
