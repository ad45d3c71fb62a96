"""Frames at any arc length: one Magnus step from the node before."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Samples
from soft_sim_ros.core.model.packing import flat_entries, floats, ints
from soft_sim_ros.core.model.segments import Segment

from .chain import Branch, Chain, RodMap
from .element import Element

if TYPE_CHECKING:
    from .link import LinkMap

Place = tuple[int, Segment]  # a node, and the segment from it to the sample


def places_along(chain: Chain, branch: Branch, s: Floats) -> list[Place]:
    """Return places at arc lengths ``s`` (P,) in m, counted along the rods of a branch."""
    places = []
    for value in s:
        place = _locate(chain, branch, float(value))
        if value == s[-1] and value >= (branch.length or 1.0) * (1.0 - 1e-12):
            place = at_node(branch.last_node)  # the tip, tools too
        places.append(place)
    return places


def samples_at(places: list[Place]) -> Samples:
    """Return samples at places (P of them)."""
    steps = [segment for _, segment in places]
    entries = flat_entries(steps)
    return Samples(
        node=ints([node for node, _ in places]),
        half=floats([x.half for x in steps]),
        kappa=floats([x.kappa for x in steps]),
        xi0=floats([x.xi0 for x in steps]).reshape(-1, 2, 6),
        entry_ptr=entries[0],
        entry_col=entries[1],
        entry_comp=entries[2],
        entry_phi=entries[3],
    )


def at_node(node: int) -> Place:
    """Return the place that a node of the chain is."""
    return node, Segment(0.5, 0.0, np.zeros((2, 6)))


def _locate(chain: Chain, branch: Branch, s: float) -> Place:
    """Return the place at an arc length s in m along the rods of a branch."""
    spans = branch.spans
    for i, span in enumerate(spans):
        if s > span.length and i < len(spans) - 1:
            s -= span.length
            continue
        return locate_in(chain, span, s)
    return at_node(branch.last_node)


def locate_in(chain: Chain, span: RodMap | LinkMap, s: float) -> Place:
    """Return the place at an arc length s in m along one rod or floating-frame link."""
    if not isinstance(span, RodMap):
        return span.sample(min(s, span.length))
    element = _element_at(span, s)
    k = element.first_segment
    while chain.segments[k].span[1] < min(s, element.span[1]):
        k += 1
    begin = chain.segments[k].span[0]
    s = min(s, element.span[1])
    if s >= chain.segments[k].span[1]:
        return at_node(k + 1)
    return (k, element.step(begin, s)) if s > begin else at_node(k)


def _element_at(rod_map: RodMap, s: float) -> Element:
    for element in rod_map.elements:
        if s <= element.span[1]:
            return element
    return rod_map.elements[-1]
