"""Frames at any arc length: one Magnus step from the node before."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Samples
from soft_sim_ros.core.model.packing import flat_entries, floats, ints
from soft_sim_ros.core.model.segments import Segment

from .chain import Chain, RodMap
from .element import Element
from .scene import Compiled


def sample_frames(compiled: Compiled, s: Floats) -> Samples:
    """Return samples at arc lengths ``s`` (P,) in m, counted along all rods, base to tip."""
    chain = compiled.chain
    nodes, steps = [], []
    for value in s:
        node, segment = _locate(chain, float(value))
        if value == s[-1] and value >= compiled.length * (1.0 - 1e-12):
            node, segment = chain.node, Segment(0.5, 0.0, np.zeros((2, 6)))  # the tip, tools too
        nodes.append(node)
        steps.append(segment)
    entries = flat_entries(steps)
    return Samples(
        node=ints(nodes),
        half=floats([x.half for x in steps]),
        kappa=floats([x.kappa for x in steps]),
        xi0=floats([x.xi0 for x in steps]).reshape(-1, 2, 6),
        entry_ptr=entries[0],
        entry_col=entries[1],
        entry_comp=entries[2],
        entry_phi=entries[3],
    )


def _locate(chain: Chain, s: float) -> tuple[int, Segment]:
    """Return the node before arc length s, and the step from it."""
    nothing = Segment(0.5, 0.0, np.zeros((2, 6)))
    spans = chain.spans
    for i, span in enumerate(spans):
        if s > span.length and i < len(spans) - 1:
            s -= span.length
            continue
        if not isinstance(span, RodMap):
            return span.sample(min(s, span.length))
        element = _element_at(span, s)
        k = element.first_segment
        while chain.segments[k].span[1] < min(s, element.span[1]):
            k += 1
        begin = chain.segments[k].span[0]
        s = min(s, element.span[1])
        if s >= chain.segments[k].span[1]:
            return k + 1, nothing
        return (k, element.step(begin, s)) if s > begin else (k, nothing)
    return chain.node, nothing


def _element_at(rod_map: RodMap, s: float) -> Element:
    for element in rod_map.elements:
        if s <= element.span[1]:
            return element
    return rod_map.elements[-1]
