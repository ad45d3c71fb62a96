"""Pieces of a rod with smooth data: their coordinates, their steps, their stiffness."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial

import numpy as np

from soft_sim_ros.core.bases import ElementBasis, get_basis
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.segments import Segment, project_linear
from soft_sim_ros.core.quadrature import composite, gauss, lobatto, scattered
from soft_sim_ros.scene import Basis, Section
from soft_sim_ros.scene.strains import STRAINS

EXTRA = 5  # Gauss points beyond the number of functions: exact for laws of degree 8
SETTLED = 1e-12  # allowed relative change of ∫ φ_i φ_k
DENSEST = 8
SEGMENTS, GROWTH, MOST_SEGMENTS = 7, 2.1, 256  # for degree three; from one degree to the next


@dataclass
class Element:
    """A piece of a section with smooth data, and the coordinates that bend it."""

    section: Section
    section_span: tuple[float, float]  # arc lengths in the rod, m
    span: tuple[float, float]
    ends: Floats  # element ends of the section, m
    basis: Basis
    columns: list[tuple[int, int, int]]  # component, first coordinate, count
    first_segment: int
    winding: float = 0.0  # of tendons about it, rad/m

    @cached_property
    def nodes(self) -> int:
        """Gauss–Lobatto nodes along the element."""
        return self.basis.nodes or self._at_least(default_nodes(self.basis.order))

    @property
    def least_nodes(self) -> int:
        """Least number of nodes that carries all inertia and resolves the reference shape."""
        return self._at_least(fewest_nodes(self.basis.order))

    def _at_least(self, nodes: int) -> int:
        """Return enough nodes for reference shape and tendons as well.

        That is three segments per radian by which the reference shape turns, enough segments for
        the winding of tendons (ports.WINDING), and one more for each place where the data are not
        smooth.
        """
        begin, end = self.span
        s = scattered(begin, end)
        turn = float(np.linalg.norm(self.section.strain0(self.normalised(s))[:, :3], axis=1).max())
        length = end - begin
        shape = math.ceil(3.0 * turn * length), math.ceil(1.25 * self.winding * length)
        pieces = len(self.marks(begin, end)) - 1
        return max(nodes, 1 + max(shape)) + pieces - 1

    def marks(self, begin: float, end: float) -> list[float]:
        """Return two arc lengths and, between them, the places where the section is not smooth."""
        if not self.section.knots:
            return [begin, end]
        first, last = self.section_span
        knots = first + (last - first) * np.array(self.section.knots)
        slack = 1e-9 * (last - first)
        inner = knots[(knots > begin + slack) & (knots < end - slack)]
        return [begin, *inner.tolist(), end]

    def values(self, component_columns: tuple[int, int, int], s: Floats) -> Floats:
        """Return basis values (len(s), count) of one strain at arc lengths s of the rod."""
        component, _, _ = component_columns
        rule = get_basis(self.basis.kind)
        if isinstance(rule, ElementBasis):
            begin, end = self.span
            t = (2.0 * s - begin - end) / (end - begin)
            return rule.values(self.order(component), t)
        return rule.values(self.ends, s)

    def order(self, component: int) -> int:
        """Return the order of the basis of a strain."""
        return self.basis.order[STRAINS[component]]

    @property
    def density(self) -> int:
        """Gauss points that this element needs, as a multiple of what polynomials need."""
        rule = get_basis(self.basis.kind)
        if not isinstance(rule, ElementBasis):
            return 1
        return max((_density(rule, self.order(c[0]), c[2]) for c in self.columns), default=1)

    def normalised(self, s: Floats) -> Floats:
        """Return section coordinates x ∈ [0, 1] of arc lengths of the rod."""
        begin, end = self.section_span
        return np.clip((s - begin) / (end - begin), 0.0, 1.0)

    @cached_property
    def lumps(self) -> tuple[Floats, Floats, Floats]:
        """Nodes along the element: arc lengths, section coordinates, and weights in m (N, 1)."""
        nodes, weights = _lobatto(self.nodes)
        begin, end = self.span
        s = begin + (end - begin) * nodes
        s[-1] = end
        return s, self.normalised(s), ((end - begin) * weights)[:, None]

    @cached_property
    def points(self) -> tuple[Floats, Floats, list[Floats]]:
        """Gauss points of the stiffness: x (P,), weights in m (P,), and the functions there."""
        top = max((c[2] for c in self.columns), default=1)
        s, w = composite(gauss(self.density * (top + EXTRA)), self.marks(*self.span))
        return self.normalised(s), w, [self.values(columns, s) for columns in self.columns]

    def share(self, other: Element) -> None:
        """Take what depends on the shape of the rod alone from an element of the same shape."""
        self.nodes, self.lumps, self.points = other.nodes, other.lumps, other.points

    def step(self, begin: float, end: float) -> Segment:
        """Return the fourth-order Magnus step between two arc lengths inside the element."""
        h = end - begin
        segment = Segment(
            half=0.5 * h,
            kappa=math.sqrt(3.0) * h * h / 12.0,
            xi0=project_linear(
                lambda s: self.section.strain0(self.normalised(s)), self.marks(begin, end)
            ),
            span=(begin, end),
        )
        for columns in self.columns:
            _, first, count = columns
            phi = project_linear(partial(self.values, columns), (begin, end))
            segment.entries += [
                (first + j, columns[0], phi[0, j], phi[1, j])
                for j in range(count)
                if phi[0, j] != 0.0 or phi[1, j] != 0.0
            ]
        return segment


@lru_cache(maxsize=64)
def _lobatto(nodes: int) -> tuple[Floats, Floats]:
    """Return Lobatto's rule: many elements have the same, and it takes a while for many nodes."""
    return lobatto(nodes)


@lru_cache(maxsize=256)
def _density(rule: ElementBasis, order: int, count: int) -> int:
    """Return by how much to multiply count + EXTRA Gauss points so that ∫ φ_i φ_k is known.

    1 for polynomials. For other functions it grows until more points change nothing, or DENSEST
    is reached.
    """

    def products(density: int) -> Floats:
        x, w = gauss(density * (count + EXTRA))
        values = rule.values(order, 2.0 * x - 1.0)
        return np.asarray(values.T @ (w[:, None] * values))

    density, before = 1, products(1)
    while density < DENSEST:
        found = products(density + 1)
        size = np.sqrt(np.abs(np.outer(np.diag(found), np.diag(found))))
        if (np.abs(found - before) <= SETTLED * size).all():
            break
        density, before = density + 1, found
    return density


def fewest_nodes(order: Mapping[str, int]) -> int:
    """Return Gauss–Lobatto nodes that carry the inertia of strains of these degrees exactly."""
    return max(order.values(), default=0) + 5


def default_nodes(order: Mapping[str, int]) -> int:
    """Return Gauss–Lobatto nodes for an element with strains of these degrees.

    The error of the segments falls with the fourth power of their number; that of the basis falls
    by a factor of nearly 20 = 2.1⁴ per degree. So from degree four on the number of segments grows
    by 2.1 per degree, up to an error of about 1e-10 L (docs/theory.md has the measured errors).
    """
    top = max(order.values(), default=0)
    segments = SEGMENTS * GROWTH ** min(top - 3, 10) if top > 3 else 0.0
    return max(fewest_nodes(order), 1 + math.ceil(min(MOST_SEGMENTS, segments)))


def block_matrices(elements: list[Element], count: int) -> tuple[Floats, Floats, Floats]:
    """Return ∫ Φᵀ H Φ ds (the linear part), ∫ Φᵀ Γ Φ ds and that of the branch (count, count).

    Exact where stiffness and damping are piecewise polynomials of degree 8 at most.
    """
    matrices = np.zeros((3, count, count))
    base = min((c[1] for c in elements[0].columns), default=0)
    for element in elements:
        at, w, phis = element.points
        laws = np.stack(element.section.laws(at))
        used = np.any(laws, axis=(0, 1)).tolist()
        for i, (row, first, number) in enumerate(element.columns):
            own = slice(first - base, first - base + number)
            for j, (column, other, size) in enumerate(element.columns[: i + 1]):
                if not used[row][column]:
                    continue
                law = w[:, None] * laws[:, :, row, column, None]
                if not law.any():  # so small that it vanishes
                    continue
                far = slice(other - base, other - base + size)
                part = phis[i].T @ (law * phis[j])
                matrices[:, own, far] += part
                if i != j:
                    matrices[:, far, own] += part.transpose(0, 2, 1)
    return matrices[0], matrices[1], matrices[2]
