"""From bodies to segments: a growing chain that compile.py writes into flat arrays."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..scene import Basis, Joint, Pose, RigidBody, Rod, Section
from ..scene.strains import STRAINS
from . import se3
from .bases import ElementBasis, get_basis
from .model import Floats
from .quadrature import composite, gauss, lobatto

if TYPE_CHECKING:
    from .link import LinkMap

GAUSS2 = gauss(2)[0]
PROJECTION = gauss(16)
ANGULAR = 3  # strain components below this index are rotations

Entry = tuple[int, int, float, float]  # coordinate, component, value at the two Gauss points


@dataclass
class Segment:
    """One step of the chain (see model.py)."""

    half: float
    kappa: float
    xi0: Floats
    entries: list[Entry] = field(default_factory=list)
    span: tuple[float, float] = (0.0, 0.0)  # arc lengths in its rod, m


@dataclass
class Block:
    """Consecutive segments that share the coordinates begin … end − 1."""

    begin: int
    end: int
    first_segment: int
    stiffness: Floats
    damping: Floats
    branch: Floats  # stiffness of Maxwell branches
    branch_time: float = 1.0  # s


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

    @property
    def nodes(self) -> int:
        """Gauss–Lobatto nodes along the element."""
        if self.basis.nodes:
            return self.basis.nodes
        begin, end = self.span
        s = np.linspace(begin, end, 101)
        turn = float(np.linalg.norm(self.section.strain0(self.normalised(s))[:, :3], axis=1).max())
        length = end - begin
        pieces = len(self.marks(begin, end)) - 1
        return default_nodes(self.basis, turn * length, self.winding * length) + pieces - 1

    def marks(self, begin: float, end: float) -> list[float]:
        """Return two arc lengths, and between them those where the section is not smooth."""
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
            return rule.values(self.basis.order[STRAINS[component]], t)
        return rule.values(self.ends, s)

    def normalised(self, s: Floats) -> Floats:
        """Return section coordinates x ∈ [0, 1] of arc lengths of the rod."""
        begin, end = self.section_span
        return np.clip((s - begin) / (end - begin), 0.0, 1.0)

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


def project_linear(function: Callable[[Floats], Floats], marks: Sequence[float]) -> Floats:
    """Return the values (2, m) at the two Gauss points of the best linear fit to a function (N, m).

    The function is smooth between neighbours of ``marks``; first and last are the ends.

    Its mean and first moment are all that a fourth-order Magnus step sees. Taking them exactly,
    instead of point values, makes the step exact for strains that commute, whatever their degree:
    planar bending, twist, stretch of a straight rod.
    """
    s, w = composite(PROJECTION, marks)
    values = function(s)
    w /= marks[-1] - marks[0]
    mean = w @ values
    moment = (w * (s - marks[0]) / (marks[-1] - marks[0]) - 0.5 * w) @ values
    return np.stack([mean - 2.0 * math.sqrt(3.0) * moment, mean + 2.0 * math.sqrt(3.0) * moment])


@dataclass
class RodMap:
    """Where a rod lies in the chain."""

    rod: Rod
    first_node: int
    elements: list[Element]
    pivot: list[int] = field(default_factory=list)  # coordinates of the hinge of a limp rod
    last_node: int = 0

    @property
    def length(self) -> float:
        """Reference length in m."""
        return self.rod.length


class Chain:
    """A chain of segments under construction; node 0 is the base frame."""

    def __init__(self) -> None:
        self.segments: list[Segment] = []
        self.inertia: list[Floats] = [np.zeros(4)]
        self.drag: list[Floats] = [np.zeros(4)]  # Rayleigh's α times the inertia of the rods
        self.blocks: list[Block] = []
        self.names: list[str] = []
        self.rods: dict[str, RodMap] = {}
        self.links: dict[str, LinkMap] = {}
        self.frames: dict[str, int] = {}  # node of a joint, a rigid body, the tip of a link
        self.joints: dict[str, range] = {}  # coordinates of a joint
        self.charts: list[int] = []  # first coordinates of rotation vectors
        self.free: list[int] = []  # segment that turns a free base

    @property
    def node(self) -> int:
        """Index of the last node."""
        return len(self.segments)

    @property
    def spans(self) -> list[RodMap | LinkMap]:
        """Rods and floating-frame links, base to tip: what has a length."""
        return sorted([*self.rods.values(), *self.links.values()], key=lambda m: m.first_node)

    def columns(self, name: str) -> range:
        """Return the coordinates of a joint or of a floating-frame link."""
        return self.joints[name] if name in self.joints else self.links[name].columns

    def behind(self, node: int) -> float:
        """Return the length in m of rods and links that begin before a node."""
        return sum(span.length for span in self.spans if span.first_node < node)

    def add(
        self, segment: Segment, inertia: Floats | None = None, drag: Floats | None = None
    ) -> None:
        """Append a segment and the node after it."""
        self.segments.append(segment)
        self.inertia.append(np.zeros(4) if inertia is None else inertia.copy())
        self.drag.append(np.zeros(4) if drag is None else drag.copy())

    def rigid(self, pose: Pose) -> None:
        """Append a rigid offset, unless it is the identity."""
        twist = se3.log(se3.pose_matrix(pose.position, pose.quaternion))
        if np.any(twist != 0.0):
            self._open_block(0, np.zeros((0, 0)), np.zeros((0, 0)))
            self.add(Segment(0.5, 0.0, np.array([twist, twist])))

    def _open_block(
        self,
        count: int,
        stiffness: Floats,
        damping: Floats,
        branch: Floats | None = None,
        branch_time: float = 1.0,
    ) -> int:
        begin = len(self.names)
        branch = np.zeros_like(stiffness) if branch is None else branch
        block = Block(begin, begin + count, self.node, stiffness, damping, branch, branch_time)
        self.blocks.append(block)
        return begin

    def branch_time(self) -> Floats:
        """Return the relaxation time in s of the branch of every coordinate; 1 s without one."""
        return np.repeat(
            [b.branch_time for b in self.blocks], [b.end - b.begin for b in self.blocks]
        )

    def joint(self, joint: Joint) -> None:
        """Append a joint: its offset, then a segment per axis, or per shift and rotation vector."""
        self.rigid(joint.offset)
        begin = len(self.names)
        steps = _screws(joint)
        if steps:
            count = len(joint.coordinates)
            self._open_block(count, joint.stiffness * np.eye(count), joint.damping * np.eye(count))
            for screws in steps:
                entries = [(begin + j, c, x[c], x[c]) for j, x in screws for c in range(6) if x[c]]
                self.add(Segment(0.5, 0.0, np.zeros((2, 6)), entries))
            self.names += joint.coordinates
            self.joints[joint.name] = range(begin, len(self.names))
        if joint.kind in ("spherical", "free"):
            self.charts.append(begin)
        if joint.kind == "free":
            self.free.append(self.node - 1)
        self.frames[joint.name] = self.node

    def rigid_body(self, body: RigidBody) -> None:
        """Append a mass: out to its centre, and back."""
        self.frames[body.name] = self.node
        row = np.array([body.mass, *body.inertia])
        out = se3.pose_matrix(body.com.position, body.com.quaternion)
        twist = se3.log(out)
        if np.any(twist != 0.0):
            self.rigid(body.com)
            self.inertia[-1] += row
            self._open_block(0, np.zeros((0, 0)), np.zeros((0, 0)))
            self.add(Segment(0.5, 0.0, np.array([-twist, -twist])))
        else:
            self.inertia[-1] += row

    def rod_segments(self, rod_map: RodMap) -> list[tuple[int, Segment]]:
        """Return (index, segment) of all segments of a rod."""
        return [(k, self.segments[k]) for k in range(rod_map.first_node, rod_map.last_node)]

    def node_at(self, rod_map: RodMap, s: float) -> int:
        """Return the node of a rod at an arc length where the rod was cut."""
        if s <= 0.0:
            return rod_map.first_node
        return 1 + min(self.rod_segments(rod_map), key=lambda item: abs(item[1].span[1] - s))[0]

    def rod(self, rod: Rod, basis: Basis, cuts: set[float], winding: float = 0.0) -> None:
        """Append a rod, cut at section ends, element ends and the arc lengths ``cuts`` in m.

        ``winding`` in rad/m is by how much tendons wind about it.
        """
        pivot = self._pivot(rod) if rod.model.is_limp else []
        rod_map = RodMap(rod, self.node, [], pivot)
        self.rods[rod.name] = rod_map
        for i, section in enumerate(rod.sections):
            begin, end = rod.boundaries[i], rod.boundaries[i + 1]
            marks = set(np.linspace(begin, end, basis.elements + 1).tolist())
            marks |= {begin + (end - begin) * x for x in section.kinks}
            marks |= {s for s in cuts if begin < s < end}
            ends = _merge(sorted(marks), 1e-9 * rod.length)
            ends[0], ends[-1] = begin, end
            self._section(rod_map, section, (begin, end), np.array(ends), basis, winding)
        rod_map.last_node = self.node

    def _pivot(self, rod: Rod) -> list[int]:
        """Append the hinge at the start of a string or cable and return its coordinates.

        What cannot carry a moment cannot hold a direction either: in its frame's own axes the rod
        leaves along exp of a rotation vector that the bending strains span.
        """
        bending = [name for name in rod.model.limp if name in rod.strains]
        count = len(bending)
        begin = self._open_block(count, np.zeros((count, count)), np.zeros((count, count)))
        entries = [(begin + j, STRAINS.index(name), 1.0, 1.0) for j, name in enumerate(bending)]
        self.add(Segment(0.5, 0.0, np.zeros((2, 6)), entries))
        self.names += [f"{rod.name}/start/{name}" for name in bending]
        return [begin + j for j in range(count)]

    def _section(
        self,
        rod_map: RodMap,
        section: Section,
        span: tuple[float, float],
        ends: Floats,
        basis: Basis,
        winding: float,
    ) -> None:
        rod = rod_map.rod
        rule = get_basis(basis.kind)
        strains = [(STRAINS.index(name), name) for name in rod.strains]
        own = isinstance(rule, ElementBasis)
        elements: list[Element] = []
        for i in range(len(ends) - 1):
            if own or i == 0:
                columns: list[tuple[int, int, int]] = []
                labels: list[str] = []
                for component, name in strains:
                    count = (
                        rule.count(basis.order[name])
                        if isinstance(rule, ElementBasis)
                        else rule.count(ends)
                    )
                    columns.append((component, len(self.names) + len(labels), count))
                    where = f"[{i}]" if own and len(ends) > 2 else ""
                    labels += [f"{rod.name}/{section.name}{where}/{name}/{j}" for j in range(count)]
            elements.append(
                Element(
                    section, span, (ends[i], ends[i + 1]), ends, basis, columns, self.node, winding
                )
            )
            if own:
                self._fill([elements[-1]], labels, basis)
        if not own:
            self._fill(elements, labels, basis)
        rod_map.elements += elements

    def _fill(self, elements: list[Element], labels: list[str], basis: Basis) -> None:
        """Open one block over ``elements`` and append their segments and nodes."""
        matrices = block_matrices(elements, len(labels))
        branch = elements[0].section.material.maxwell
        self._open_block(len(labels), *matrices, branch.time if branch else 1.0)
        self.names += labels
        for element in elements:
            element.first_segment = self.node
            nodes, weights = lobatto(element.nodes)
            begin, end = element.span
            s = begin + (end - begin) * nodes
            s[-1] = end
            weights = ((end - begin) * weights)[:, None]
            lumped = element.section.inertia(element.normalised(s)) * weights
            drag = element.section.drag(element.normalised(s)) * weights
            self.inertia[-1] += lumped[0]
            self.drag[-1] += drag[0]
            for k in range(len(s) - 1):
                self.add(element.step(s[k], s[k + 1]), lumped[k + 1], drag[k + 1])


def _screws(joint: Joint) -> list[list[tuple[int, Floats]]]:
    """Return, for every segment of a joint, its (own coordinate, screw (6,)) pairs."""
    if joint.kind == "prismatic":
        return [[(0, np.concatenate([np.zeros(3), joint.axis]))]]
    if joint.kind in ("revolute", "universal"):
        return [[(j, np.concatenate([axis, np.zeros(3)]))] for j, axis in enumerate(joint.axes)]
    unit = np.eye(6)
    turn = [(j, unit[j]) for j in range(3)]
    if joint.kind == "spherical":
        return [turn]
    return [[(j, unit[j]) for j in range(3, 6)], turn] if joint.kind == "free" else []


def _merge(marks: list[float], tolerance: float) -> list[float]:
    """Drop marks closer than ``tolerance`` to the one before."""
    kept = marks[:1]
    for mark in marks[1:]:
        if mark - kept[-1] > tolerance:
            kept.append(mark)
    return kept


def default_nodes(basis: Basis, turn: float = 0.0, winding: float = 0.0) -> int:
    """Return Gauss–Lobatto nodes for an element whose reference shape turns by ``turn`` rad.

    Enough that segments, not more, limit the basis for strains of up to half a turn per element
    (docs/theory.md has the measured errors), at least three segments per radian of reference, and
    of those that tendons wind about it, ``winding`` rad, as many as ports.WINDING wants.
    """
    least = max(basis.order.values(), default=0) + 5
    return max(least, 1 + math.ceil(3.0 * turn), 1 + math.ceil(1.25 * winding))


def block_matrices(elements: list[Element], count: int) -> tuple[Floats, Floats, Floats]:
    """Return ∫ Φᵀ H Φ ds (the linear part), ∫ Φᵀ Γ Φ ds and that of the branch (count, count).

    Exact where stiffness and damping are piecewise polynomials of degree 8 at most.
    """
    matrices = np.zeros((3, count, count))
    base = min((c[1] for c in elements[0].columns), default=0)
    for element in elements:
        begin, end = element.span
        top = max((c[2] for c in element.columns), default=1)
        s, w = composite(gauss(top + 5), element.marks(begin, end))
        section, at = element.section, element.normalised(s)
        laws = (section.linear_stiffness(at), section.damping(at), section.branch(at))
        for columns in element.columns:
            component, first, number = columns
            phi = element.values(columns, s)
            own = slice(first - base, first - base + number)
            weights = w[:, None]
            for matrix, law in zip(matrices, laws, strict=True):
                matrix[own, own] += phi.T @ (weights * law[:, component, None] * phi)
    return matrices[0], matrices[1], matrices[2]
