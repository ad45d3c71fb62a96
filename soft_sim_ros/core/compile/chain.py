"""From bodies to segments: a growing forest that compile/scene.py writes into flat arrays."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.bases import ElementBasis, get_basis
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.segments import Block, Segment
from soft_sim_ros.scene import Basis, Joint, Pose, RigidBody, Rod, Section
from soft_sim_ros.scene.strains import STRAINS

from .element import Element, block_matrices
from .link_map import LinkMap
from .screws import screws_of
from .spans import Branch, RodMap


class Chain:
    """A forest of segments under construction, depth first; node 0 is the base frame."""

    def __init__(self) -> None:
        self.segments: list[Segment] = []
        self.inertia: list[Floats] = [np.zeros(4)]
        self.mass_damping: list[Floats] = [
            np.zeros(4)
        ]  # Rayleigh's α times the inertia of the rods
        self.blocks: list[Block] = []
        self.names: list[str] = []
        self.rods: dict[str, RodMap] = {}
        self.links: dict[str, LinkMap] = {}
        self.frames: dict[str, int] = {}  # node of a joint, a rigid body, the tip of a link
        self.joints: dict[str, range] = {}  # coordinates of a joint
        self.charts: list[int] = []  # first coordinates of rotation vectors
        self.free: list[tuple[int, int]] = []  # of free joints: segment that turns it, coordinate
        # of payloads: node of the centre of mass; mass in kg, principal moments in kg·m²; whether
        # they are there at first
        self.payloads: dict[str, tuple[int, Floats, bool]] = {}
        self.driven: list[tuple[int, int]] = []  # driven coordinates, and their blocks
        self.ends: dict[str, int] = {}  # last node of every body
        self.branches: list[Branch] = [Branch(0, 0.0)]
        # length in m of the rods and links from the base to every node, all of those that begin
        # before it
        self.behind: list[float] = [0.0]
        self._ahead = 0.0  # length of the rod or link that has just begun, m

    @property
    def node(self) -> int:
        """Index of the last node."""
        return len(self.segments)

    @property
    def spans(self) -> list[RodMap | LinkMap]:
        """Rods and floating-frame links, base to tip: the bodies that have a length."""
        return sorted([*self.rods.values(), *self.links.values()], key=lambda m: m.first_node)

    def columns(self, name: str) -> range:
        """Return the coordinates of a joint or of a floating-frame link."""
        return self.joints[name] if name in self.joints else self.links[name].columns

    def branch(self, node: int, pose: Pose, behind: float) -> None:
        """Begin a branch: what comes leaves a node by a rigid offset, which may be none.

        behind : length in m of rods and links from the base to there
        """
        self.branches[-1].last_node = self.node
        self._open_block(0, np.zeros((0, 0)), np.zeros((0, 0)))
        twist = se3.log(se3.pose_matrix(pose.position, pose.quaternion))
        self.add(Segment(0.5, 0.0, np.array([twist, twist]), origin=node))
        self.behind[-1] = behind
        self.branches.append(Branch(self.node, behind))

    def close(self) -> None:
        """Say that no body comes any more."""
        self.branches[-1].last_node = self.node
        origins = {segment.origin for segment in self.segments}
        roots = [k for k, segment in enumerate(self.segments) if segment.origin == 0]
        # segment, coordinate and the node after the last that a free joint carries
        self.carried = [
            (turn, begin, 1 + min((k for k in roots if k > turn), default=self.node))
            for turn, begin in self.free
        ]
        self.tips = [node for node in range(self.node + 1) if node not in origins]
        # the longest way through a node, base to tip
        self.whole = list(self.behind)
        for k in range(self.node - 1, -1, -1):
            at = self.segments[k].origin
            self.whole[at] = max(self.whole[at], self.whole[k + 1])
        longest = self.whole[0] or 1.0
        self.whole = [length or longest for length in self.whole]

    def add(
        self, segment: Segment, inertia: Floats | None = None, damping: Floats | None = None
    ) -> None:
        """Append a segment and the node after it."""
        if segment.origin < 0:
            segment.origin = self.node
        self.segments.append(segment)
        self.behind.append(self.behind[-1] + self._ahead)
        self._ahead = 0.0
        self.inertia.append(np.zeros(4) if inertia is None else inertia.copy())
        self.mass_damping.append(np.zeros(4) if damping is None else damping.copy())

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
        steps = screws_of(joint)
        if steps:
            count = len(joint.coordinates)
            self._open_block(count, joint.stiffness * np.eye(count), joint.damping * np.eye(count))
            for screws in steps:
                entries = [(begin + j, c, x[c], x[c]) for j, x in screws for c in range(6) if x[c]]
                self.add(Segment(0.5, 0.0, np.zeros((2, 6)), entries))
            self.names += joint.coordinates
            self.joints[joint.name] = range(begin, len(self.names))
        if joint.driven:
            self.driven += [(begin + i, len(self.blocks) - 1) for i in range(len(joint.driven))]
        elif joint.kind in ("spherical", "free"):
            self.charts.append(begin)
        if joint.kind == "free" and not joint.driven:
            self.free.append((self.node - 1, begin))
        self.frames[joint.name] = self.node

    def rigid_body(self, body: RigidBody) -> None:
        """Append a mass: out to its centre, and back."""
        self.frames[body.name] = self.node
        row = np.array([body.mass, *body.inertia])
        out = se3.pose_matrix(body.com.position, body.com.quaternion)
        twist = se3.log(out)
        if np.any(twist != 0.0):
            self.rigid(body.com)
            self._carry(body, row)
            self._open_block(0, np.zeros((0, 0)), np.zeros((0, 0)))
            self.add(Segment(0.5, 0.0, np.array([-twist, -twist])))
        else:
            self._carry(body, row)

    def _carry(self, body: RigidBody, row: Floats) -> None:
        """Put a mass on the last node; that of a payload comes and goes."""
        if body.attached is None:
            self.inertia[-1] += row
        else:
            self.payloads[body.name] = (self.node, row, body.attached)

    def inertia_with(self, attached: Sequence[bool] | None = None) -> Floats:
        """Return mass in kg and principal moments in kg·m² (N, 4) of all nodes.

        attached : (P,) which payloads are there; None: those that are at first
        """
        out: Floats = np.array(self.inertia)
        if attached is None:
            attached = [first for *_, first in self.payloads.values()]
        for (node, row, _), there in zip(self.payloads.values(), attached, strict=True):
            if there:
                out[node] += row
        return out

    def rod_segments(self, rod_map: RodMap) -> list[tuple[int, Segment]]:
        """Return (index, segment) of all segments of a rod."""
        return [(k, self.segments[k]) for k in range(rod_map.first_node, rod_map.last_node)]

    def node_at(self, rod_map: RodMap, s: float) -> int:
        """Return the node of a rod at an arc length where the rod was cut."""
        if s <= 0.0:
            return rod_map.first_node
        return 1 + min(self.rod_segments(rod_map), key=lambda item: abs(item[1].span[1] - s))[0]

    def span(self, span: RodMap | LinkMap) -> None:
        """Note that what comes is a rod or link of some length."""
        self.branches[-1].spans.append(span)
        self._ahead = span.length

    def rod(
        self,
        rod: Rod,
        basis: Basis,
        cuts: set[float],
        winding: float = 0.0,
        marked: Collection[float] = (),
    ) -> None:
        """Append a rod, cut at section ends, element ends and the arc lengths ``cuts`` in m.

        Where the data of a section change fast, each piece of it has its elements. At the arc
        lengths ``marked`` bodies are attached: blocks of coordinates end there.

        ``winding`` is the largest angle per length in rad/m by which a tendon winds about the rod.
        """
        pivot = self._pivot(rod) if rod.model.is_limp else []
        rod_map = RodMap(rod, self.node, [], pivot)
        self.rods[rod.name] = rod_map
        self.span(rod_map)
        for i, section in enumerate(rod.sections):
            begin, end = rod.boundaries[i], rod.boundaries[i + 1]
            marks = {begin + (end - begin) * x for x in section.kinks}
            pieces = begin + (end - begin) * np.array([0.0, *section.cuts, 1.0])
            pieces[-1] = end
            for piece in zip(pieces[:-1], pieces[1:], strict=True):
                marks |= set(np.linspace(*piece, basis.elements + 1).tolist())
            marks |= {s for s in cuts if begin < s < end}
            ends = _merge(sorted(marks), 1e-9 * rod.length)
            ends[0], ends[-1] = begin, end
            for label, part in _parts(ends, marked, basis):
                self._section(rod_map, section, (begin, end), part, basis, winding, label)
        rod_map.last_node = self.node

    def _pivot(self, rod: Rod) -> list[int]:
        """Append the hinge at the start of a string or cable and return its coordinates.

        A rod without bending stiffness cannot hold a direction at its start. The hinge turns it by
        the exponential of a rotation vector in the span of the bending strains.
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
        label: str,
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
                    where = f"[{i}]" if own and len(ends) > 2 else label
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
            s, at, weights = element.lumps
            inertia = element.section.inertia(at)
            lumped = inertia * weights
            damping = element.section.material.mass_damping * inertia * weights
            self.inertia[-1] += lumped[0]
            self.mass_damping[-1] += damping[0]
            for k in range(len(s) - 1):
                self.add(self._step(element, s[k], s[k + 1]), lumped[k + 1], damping[k + 1])

    def _step(self, element: Element, begin: float, end: float) -> Segment:
        return element.step(begin, end)


def _parts(ends: list[float], marked: Collection[float], basis: Basis) -> list[tuple[str, Floats]]:
    """Return the element ends of a section that share coordinates at most, each with a label.

    Functions of one element end with it anyway; others end where a body is attached, since a
    block of coordinates has to move all of it.
    """
    if isinstance(get_basis(basis.kind), ElementBasis):
        return [("", np.array(ends))]
    slack = 1e-9 * ends[-1]
    inner = [i for i in range(1, len(ends) - 1) if any(abs(ends[i] - s) <= slack for s in marked)]
    places = [0, *inner, len(ends) - 1]
    parts = [np.array(ends[a : b + 1]) for a, b in zip(places[:-1], places[1:], strict=True)]
    return [(f"[{i}]" if len(parts) > 1 else "", part) for i, part in enumerate(parts)]


def _merge(marks: list[float], tolerance: float) -> list[float]:
    """Drop marks closer than ``tolerance`` to the one before."""
    kept = marks[:1]
    for mark in marks[1:]:
        if mark - kept[-1] > tolerance:
            kept.append(mark)
    return kept
