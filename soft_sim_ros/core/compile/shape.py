"""The strain field of a rod as a matrix: ξ(s) = ξ₀(s) + Φ(s) q.

Dynamics of Soft Robots (1.21)–(1.22).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from soft_sim_ros.core.arguments import real, vector
from soft_sim_ros.core.floats import Floats, Ints
from soft_sim_ros.errors import NoSuchPlace
from soft_sim_ros.scene.strains import STRAINS

from .element import Element
from .scene import Compiled


def selection_matrix(strains: Sequence[str]) -> Floats:
    """Return B_a (6, m): the columns of the unit matrix that belong to active strains."""
    unknown = [name for name in strains if name not in STRAINS]
    if unknown:
        raise NoSuchPlace(unknown[0], f"one of the strains {', '.join(STRAINS)}")
    return np.eye(6)[:, [STRAINS.index(name) for name in strains]]


def shape_matrix(compiled: Compiled, rod: str, s: Floats) -> Floats:
    """Return Φ (P, 6, n) of a rod at arc lengths s (P,) in m.

    Parameters
    ----------
    compiled : Compiled
        the arm; Φ has a column for each of its coordinates, zero for those of other bodies
    rod : name of the rod
    s : (P,) arc lengths along it; where two elements meet, those of the one that begins there

    Raises
    ------
    NoSuchPlace
        if there is no such rod, or s is outside of it.

    Notes
    -----
    With the same order for all active strains, this is B_a ⊗ [φ₁ … φ_N] of Dynamics of Soft Robots,
    (1.22) on an element.
    """
    elements, s, index = _elements_at(compiled, rod, s)
    out = np.zeros((len(s), 6, len(compiled.coordinate_names)))
    for i, element in enumerate(elements):
        at = np.flatnonzero(index == i)
        for component, first, count in element.columns:
            out[at, component, first : first + count] = element.values(
                (component, first, count), s[at]
            )
    return out


def strain(compiled: Compiled, rod: str, q: Floats, s: Floats) -> Floats:
    """Return ξ (P, 6) of a rod at arc lengths s (P,) for coordinates q (n,)."""
    elements, s, index = _elements_at(compiled, rod, s)
    out: Floats = shape_matrix(compiled, rod, s) @ vector("q", q, len(compiled.coordinate_names))
    for i, element in enumerate(elements):
        at = np.flatnonzero(index == i)
        out[at] += element.section.strain0(element.normalised(s[at]))
    return out


def _elements_at(compiled: Compiled, rod: str, s: Floats) -> tuple[list[Element], Floats, Ints]:
    """Return the elements of a rod, s as an array (P,), and the index of its element for each."""
    if rod not in compiled.chain.rods:
        known = ", ".join(compiled.chain.rods) or "none"
        raise NoSuchPlace(rod, f"one of the rods {known}")
    rod_map = compiled.chain.rods[rod]
    s = np.atleast_1d(real("s", s))
    if not ((s >= 0.0) & (s <= rod_map.rod.length)).all():
        worst = float(s[np.argmax(np.abs(s - 0.5 * rod_map.rod.length))])
        raise NoSuchPlace(worst, f"an arc length of {rod} in [0, {rod_map.rod.length:g}] m")
    begins = [element.span[0] for element in rod_map.elements]
    index = np.searchsorted(begins, s, side="right").astype(np.int64) - 1
    return rod_map.elements, s, index
