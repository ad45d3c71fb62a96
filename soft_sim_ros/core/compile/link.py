"""Floating-frame links, rigid motion times linear modes, as segments of the chain.

Boyer & Primault 2005 (3.23)–(3.36).

The floating frame is that of the link's first section. The link's mass enters the motion only by
the integrals of (3.31) and (3.33). A few point masses have the same integrals (moments.py); each
sits at one node of the chain. Such a node stands at X + Φ q in the floating frame, exactly: between
two nodes lies a segment that only shifts, by the difference of X + Φ q, so positions are linear in
the modal coordinates as required by Boyer & Primault 2005 (3.25), (3.26). Rotary inertia has nodes
of its own that only turn; at the tip one segment turns by the modes' rotation there. Such a link
needs nothing else: the common recursion yields 𝓙, the bias terms of (3.33) and the couplings of
(3.34)–(3.36).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.segments import Block, Segment
from soft_sim_ros.core.quadrature import lobatto
from soft_sim_ros.scene import DistributedLoad, FlexibleLink, InputLoad, PointLoad, Rod

from .chain import Chain
from .link_map import LinkMap
from .link_modes import modes_of
from .moments import concentrated

Load = PointLoad | DistributedLoad | InputLoad
# Gauss–Lobatto points in every section, at which the integrals over modes are taken.
POINTS = 40


def append_link(chain: Chain, link: FlexibleLink, loads: Sequence[Load] = ()) -> None:
    """Append a floating-frame link, and nodes for the loads along it, to a chain."""
    modes = modes_of(link)
    begin, first = len(chain.names), chain.node
    columns = range(begin, begin + link.modes)
    laws = modes.stiffness, modes.damping, modes.branch, modes.branch_time
    chain.blocks.append(Block(begin, columns.stop, first, *laws))
    chain.names += link.coordinates
    rest, shift = np.zeros((1, 3)), np.zeros((1, 3, link.modes))
    own = LinkMap(link, modes, columns, first, [first], rest, shift)
    chain.links[link.name] = own
    chain.span(own)
    turns: list[tuple[Floats, Floats, float]] = []
    for damping, s, inertia in _distributions(link.rod):
        turn, moved = modes.fields(s)
        mass, at = concentrated(np.column_stack([s, moved.reshape(len(s), -1)]), inertia[:, 0], s)
        frame = inertia.sum(axis=0)
        frame[0] -= mass.sum()
        for amount, value in zip(mass, at, strict=True):
            _shift_to(chain, own, value, np.array([amount, 0.0, 0.0, 0.0]), damping)
        if link.rotary_inertia:
            for moments, how in _turning(turn, inertia[:, 1:], s):
                turns.append((how, moments, damping))
                frame[1:] -= moments
        # inertia that the nodes lack is fixed to the floating frame; it must not be negative
        frame = np.maximum(frame, 0.0)
        chain.inertia[first] += frame
        chain.mass_damping[first] += damping * frame
    for load in loads:
        own.loaded[load.name] = _bearers(chain, own, load)
    turn, moved = (field_[0] for field_ in modes.fields(np.array([own.length])))
    _shift_to(chain, own, np.concatenate([[own.length], moved.ravel()]), np.zeros(4), 0.0)
    chain.segments[-1].span = (0.0, own.length)
    for how, moments, damping in turns:
        _turn_to_and_fro(chain, own, how, np.array([0.0, *moments]), damping)
    chain.add(_linear(columns, 0, turn))
    chain.frames[link.name] = chain.node
    for load in loads:
        if _at_tip(load, own):
            own.loaded[load.name] = [(chain.node, 1.0)]


def _shift_to(chain: Chain, own: LinkMap, value: Floats, inertia: Floats, damping: float) -> None:
    """Append a shift from the last node to X + Φ q, ``value`` being X and Φ (3, m) in a row."""
    rest, how = np.array([value[0], 0.0, 0.0]), value[1:].reshape(3, -1)
    step = _linear(own.columns, 3, how - own.shift[-1])
    step.xi0[:, 3:] = rest - own.rest[-1]
    chain.add(step, inertia, damping * inertia)
    own.nodes.append(chain.node)
    own.rest, own.shift = np.vstack([own.rest, [rest]]), np.vstack([own.shift, [how]])


def _turn_to_and_fro(
    chain: Chain, own: LinkMap, how: Floats, inertia: Floats, damping: float
) -> int:
    """Append a node turned by how (3, m) q, then a segment that turns back; return the node."""
    chain.add(_linear(own.columns, 0, how), inertia, damping * inertia)
    node = chain.node
    chain.add(_linear(own.columns, 0, -how))
    return node


def _linear(columns: range, component: int, fields: Floats) -> Segment:
    """Return a segment that shifts (component 3) or turns (0) by fields (3, m) times q."""
    segment = Segment(0.5, 0.0, np.zeros((2, 6)))
    for j, column in enumerate(columns):
        for c in range(3):
            if fields[c, j] != 0.0:
                segment.entries.append((column, component + c, fields[c, j], fields[c, j]))
    return segment


def _at_tip(load: Load, own: LinkMap) -> bool:
    return not isinstance(load, DistributedLoad) and load.s >= own.length


def _bearers(chain: Chain, own: LinkMap, load: Load) -> list[tuple[int, float]]:
    """Append nodes for a load along a link; return them with the share of the load on each.

    A load per length acts on a few nodes whose shifts and turns have the same moments as it.
    """
    if _at_tip(load, own):
        return []
    if not isinstance(load, DistributedLoad):
        s, length = np.array([load.s]), np.ones(1)
    else:
        x, w = lobatto(POINTS)
        marks = np.unique(np.clip(own.link.rod.boundaries, load.start, load.end))
        s = np.concatenate([a + (b - a) * x for a, b in zip(marks[:-1], marks[1:], strict=True)])
        length = np.concatenate([(b - a) * w for a, b in zip(marks[:-1], marks[1:], strict=True)])
    turn, moved = (field_.reshape(len(s), -1) for field_ in own.modes.fields(s))
    amount, at = length, np.column_stack([s, moved, turn])
    if len(s) > 1:
        amount, at = concentrated(at, length, s)
    bearers = [(own.first_node, float(length.sum() - amount.sum()))]
    size = moved.shape[1]
    for share, value in zip(amount, at, strict=True):
        _shift_to(chain, own, value[: 1 + size], np.zeros(4), 0.0)
        node = _turn_to_and_fro(chain, own, value[1 + size :].reshape(3, -1), np.zeros(4), 0.0)
        bearers.append((node, float(share)))
    return bearers


def _turning(turn: Floats, moments: Floats, s: Floats) -> list[tuple[Floats, Floats]]:
    """Return (moments (3,), turn (3, m) per unit coordinate) of few bodies that turn alike.

    They share ∫ I ϑ and ∫ I ϑ ϑᵀ about each axis: the only integrals by which the rotary inertia
    ``moments`` (N, 3) at arc lengths s enters linear modes. A node may carry one body per axis.
    """
    axes = [concentrated(turn[:, c], moments[:, c], s) for c in range(3)]
    count = max(len(amount) for amount, _ in axes)
    bodies = np.zeros((count, 3)), np.zeros((count, 3, turn.shape[2]))
    for c, (amount, value) in enumerate(axes):
        bodies[0][: len(amount), c], bodies[1][: len(amount), c] = amount, value
    return list(zip(*bodies, strict=True))


def _distributions(rod: Rod) -> list[tuple[float, Floats, Floats]]:
    """Return (Rayleigh's α, arc lengths (N,), inertia (N, 4)) of the sections of equal α."""
    x, w = lobatto(POINTS)
    parts: dict[float, list[tuple[Floats, Floats]]] = {}
    for section, begin in zip(rod.sections, rod.boundaries, strict=False):
        inertia = section.inertia(x) * (section.length * w)[:, None]
        own = parts.setdefault(section.material.mass_damping, [])
        own.append((begin + section.length * x, inertia))
    out = []
    for damping, part in parts.items():
        out.append((damping, np.concatenate([s for s, _ in part]), np.vstack([i for _, i in part])))
    return out
