"""How far a unit of each coordinate may move the tip: the scale of residuals and Newton steps."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from soft_sim_ros.core.bases import ElementBasis, get_basis
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.segments import ANGULAR
from soft_sim_ros.core.quadrature import composite, gauss

from .chain import Chain
from .element import Element

# |φ| is integrated over two sets of panels that share no point, with 2 Gauss points per panel. The
# panels are refined until both integrals agree; only kinks of |φ| inside a panel leave an error.
PANELS = 8  # per function at first
AGREE = 2e-3
FINEST = 1 << 15
# Least weight relative to the largest of the same strain, so that no weight is zero.
LEAST = 1e-12


def weights(chain: Chain) -> Floats:
    """Return (n,) how far, in arm lengths, a unit of each coordinate may move the tip.

    In a forest the arm of a coordinate is the longest way from the base through it to a tip.

    For strains it is ∫ |φ| lever ds, the lever being 1 for stretch and shear and the arc length up
    to the tip for torsion and bending. Never zero, whatever the functions of the basis are.
    """
    out = np.zeros(len(chain.names))
    shifts = {e[0] for segment in chain.segments for e in segment.entries if e[1] >= ANGULAR}
    for name, own in chain.joints.items():
        node = chain.frames[name]
        length = chain.whole[node]
        reach = max(length - chain.behind[node], 0.1 * length)
        for column in own:
            out[column] = (1.0 if column in shifts else reach) / length
    for link_map in chain.links.values():
        length = chain.whole[link_map.first_node + 1]
        beyond = length - chain.behind[link_map.first_node] - link_map.length
        out[link_map.columns] = link_map.reach(beyond) / length
    for rod_map in chain.rods.values():
        length = chain.whole[rod_map.first_node + 1]
        ahead = length - chain.behind[rod_map.first_node]
        out[rod_map.pivot] = ahead / length
        for element in rod_map.elements:
            # what hangs on the rod before an element does not move with it
            length = chain.whole[element.first_segment + 1]
            ahead = length - chain.behind[rod_map.first_node]
            begin, end = element.span
            for columns in element.columns:
                component, first, count = columns
                size, moment = _moments(element, columns)
                lever = (ahead - begin, end - begin) if component < ANGULAR else (1.0, 0.0)
                amount = (end - begin) * (lever[0] * size - lever[1] * moment) / length
                out[first : first + count] += amount
        for element in rod_map.elements:
            for _, first, count in element.columns:
                part = slice(first, first + count)
                out[part] = np.maximum(out[part], LEAST * (out[part].max() or 1.0))
    return out


def _moments(element: Element, columns: tuple[int, int, int]) -> tuple[Floats, Floats]:
    """Return ∫ |φ| dx and ∫ |φ| x dx (count,) of one strain, x ∈ [0, 1] along the element."""
    rule = get_basis(element.basis.kind)
    if isinstance(rule, ElementBasis):
        return _element_moments(rule, columns[2], element.order(columns[0]))
    begin, end = element.span
    return absolute_moments(lambda x: element.values(columns, begin + (end - begin) * x))


@lru_cache(maxsize=256)
def _element_moments(rule: ElementBasis, count: int, order: int) -> tuple[Floats, Floats]:
    return absolute_moments(lambda x: rule.values(order, 2.0 * x - 1.0), count)


def absolute_moments(values: Callable[[Floats], Floats], count: int = 1) -> tuple[Floats, Floats]:
    """Return ∫₀¹ |φ| dx and ∫₀¹ |φ| x dx (m,) of functions given by their values (N, m) at x (N,).

    To about AGREE, for functions with up to FINEST changes of sign.

    count : a first guess of how many changes of sign there are
    """
    panels = PANELS * max(count, 1)
    before = _on_panels(values, panels)
    while True:
        panels = 2 * panels + 1
        found = _on_panels(values, panels)
        differ = np.abs(found[0] - before[0]) > AGREE * np.maximum(found[0], before[0])
        if panels >= FINEST or not differ.any():
            return found
        before = found


def _on_panels(values: Callable[[Floats], Floats], panels: int) -> tuple[Floats, Floats]:
    x, w = composite(gauss(2), np.linspace(0.0, 1.0, panels + 1).tolist())
    size = np.abs(values(x))
    return w @ size, (w * x) @ size
