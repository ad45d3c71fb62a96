"""Floating-frame links: rigid motion times linear modes, B (3.23)–(3.36), as segments of the chain.

The floating frame is that of the link's first section. What the motion sees of the link's mass are
the integrals of (3.31) and (3.33); a few masses have them too (moments.py), and one node of the
chain bears each. Such a node stands at X + Φ q in the floating frame, exactly: between two nodes
lies a segment that only shifts, by the difference of X + Φ q, so positions are linear in the modal
coordinates as B (3.25), (3.26) ask for. Rotary inertia has nodes of its own that only turn; at the
tip one segment turns by the modes' rotation there. Nothing else distinguishes such a link: the one
recursion finds 𝓙, the bias terms of (3.33) and the couplings of (3.34)–(3.36).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh, null_space

from ..scene import Basis, FlexibleLink, Rod
from . import se3
from .chain import Chain
from .model import Floats
from .moments import concentrated
from .quadrature import lobatto
from .segments import Block, Segment

# Degree of the strains, in every section, from which modes are computed.
FINE = 9
# Gauss–Lobatto points in every section, at which the integrals over modes are taken.
POINTS = 40
# Strains that move together where the rod is straight: twisting, two planes of bending, stretching.
GROUPS = {"torsion": (0,), "bend_y": (1, 5), "bend_z": (2, 4), "stretch": (3,)}


class Modes:
    """The lowest modes of a straight rod that is clamped at its start.

    Eigenvectors of the rod linearised at rest, with its strains as polynomials. Scaled so that
    the largest displacement of a mode is 1 m per unit coordinate; twisting modes, which displace
    nothing, so that their largest angle times the length is.

    Attributes
    ----------
    frequencies : (m,) rad/s
    stiffness, damping, branch : (m, m), the last of Maxwell branches with branch_time in s
    """

    def __init__(self, link: FlexibleLink) -> None:
        self._rod = link.rod
        self._chain = Chain()
        self._chain.rod(link.rod, Basis(order=dict.fromkeys(link.rod.strains, FINE)), set())
        stiffness, damping, branch = (
            _assembled(self._chain.blocks, x) for x in ("stiffness", "damping", "branch")
        )
        nodes = [0.0, *(segment.span[1] for segment in self._chain.segments)]
        small = self._small_motions(np.array(nodes))
        inertia = np.array(self._chain.inertia)
        mass = np.einsum("kcn,k,kcm->nm", small[:, 3:], inertia[:, 0], small[:, 3:])
        if link.rotary_inertia:
            mass += np.einsum("kcn,kc,kcm->nm", small[:, :3], inertia[:, 1:], small[:, :3])
        mass += link.tip_mass * small[-1, 3:].T @ small[-1, 3:]
        found: list[tuple[float, Floats]] = []
        for name, group in GROUPS.items():
            own = self._columns_of(group)
            rows = small[-1, 4:, own].T if link.tip == "pinned" else np.zeros((2, len(own)))
            free = np.eye(len(mass))[:, own] @ null_space(rows)
            if free.shape[1] == 0:
                continue
            # K is as well conditioned as a rod is slender, M is not: high strains hardly move
            values, vectors = eigh(free.T @ mass @ free, free.T @ stiffness @ free)
            count = link.modes if link.each is None else link.each.get(name, 0)
            for value, vector in zip(values[::-1][:count], vectors.T[::-1], strict=False):
                found.append((1.0 / np.sqrt(value), free @ vector))
        # equal frequencies (a round rod in two planes) in the order of the groups
        found = sorted(found, key=lambda mode: float(f"{mode[0]:.8e}"))[: link.modes]
        self.frequencies = np.array([frequency for frequency, _ in found])
        shapes = np.stack([_scaled(shape, small, link.rod.length) for _, shape in found], axis=1)
        self._shapes = shapes
        self.stiffness = np.diag(np.diag(shapes.T @ stiffness @ shapes))
        self.damping = shapes.T @ damping @ shapes
        self.branch = shapes.T @ branch @ shapes
        self.branch_time = self._chain.blocks[0].branch_time

    def fields(self, s: Floats) -> tuple[Floats, Floats]:
        """Return rotations and displacements (N, 3, m) per unit coordinate at arc lengths s."""
        motions = self._small_motions(s) @ self._shapes
        return motions[:, :3], motions[:, 3:]

    def _columns_of(self, group: tuple[int, ...]) -> list[int]:
        """Return the coordinates of some strain components."""
        elements = self._chain.rods[self._rod.name].elements
        own = [columns for element in elements for columns in element.columns]
        return [first + j for component, first, count in own if component in group
                for j in range(count)]  # fmt: skip

    def _small_motions(self, s: Floats) -> Floats:
        """Return rotation and displacement (N, 6, n) at arc lengths, per unit strain coordinate."""
        out = np.zeros((len(s), 6, len(self._chain.names)))
        elements = self._chain.rods[self._rod.name].elements
        for i, where in enumerate(s):
            # twist of the section at ``where``, in the frame of the clamp: straight, so Ad is p×
            twist = np.zeros((6, len(self._chain.names)))
            for element in elements:
                begin, end = element.span
                if where > begin:
                    step = element.step(begin, min(where, end))
                    twist += _columns(step, begin, len(self._chain.names))
            out[i, :3] = twist[:3]
            out[i, 3:] = twist[3:] + np.cross(twist[:3], [where, 0.0, 0.0], axisa=0, axisc=0)
        return out


def _scaled(shape: Floats, small: Floats, length: float) -> Floats:
    """Return a mode (n,) with the sign and size that the class promises."""
    motions = small @ shape
    turn, shift = motions[:, :3] * length, motions[:, 3:]
    moves = shift if np.abs(shift).max() > 1e-6 * np.abs(turn).max() else turn
    scaled: Floats = shape / moves.ravel()[np.abs(moves).argmax()]
    return scaled


def _columns(step: Segment, begin: float, count: int) -> Floats:
    """Return the twist (6, n), in the frame of the clamp, that a straight step adds per coordinate.

    The step carries mean and first moment of the strain exactly, which is all that a small motion
    of the end of a straight step depends on.
    """
    rest = step.half * (step.xi0[0] + step.xi0[1])
    frame = se3.exp(rest)
    frame[0, 3] += begin
    carried = se3.Ad(frame) @ se3.right_tangent(rest)
    out = np.zeros((6, count))
    for column, component, first, second in step.entries:
        unit = np.zeros(6)
        unit[component] = 1.0
        bracket = second * se3.ad(step.xi0[0]) @ unit - first * se3.ad(step.xi0[1]) @ unit
        out[:, column] += carried @ (step.half * (first + second) * unit + step.kappa * bracket)
    return out


def _assembled(blocks: list[Block], name: str) -> Floats:
    """Return stiffness, damping or branch of all blocks as one matrix."""
    out = np.zeros((blocks[-1].end, blocks[-1].end))
    for block in blocks:
        out[block.begin : block.end, block.begin : block.end] = getattr(block, name)
    return out


@dataclass
class LinkMap:
    """Where a link lies in the chain.

    Attributes
    ----------
    nodes : nodes along the floating frame's axes, at ``rest`` (K, 3) + ``shift`` (K, 3, m) q in it
    """

    link: FlexibleLink
    modes: Modes
    columns: range
    first_node: int
    nodes: list[int]
    rest: Floats
    shift: Floats

    @property
    def length(self) -> float:
        """Reference length in m."""
        return self.link.rod.length

    def reach(self, beyond: float) -> Floats:
        """Return (m,) how far in m a unit of each coordinate moves what is ``beyond`` m further."""
        turn, shift = self.modes.fields(np.linspace(0.0, self.length, 3 * FINE))
        far = np.abs(shift).max(axis=(0, 1)) + beyond * np.abs(turn[-1]).max(axis=0)
        return np.maximum(far, self.length * np.abs(turn).max(axis=(0, 1)))

    def sample(self, s: float) -> tuple[int, Segment]:
        """Return a node and the step from it to the section at arc length s.

        The section's turn after its shift, in one exponential: [ξ₁, ξ₂] takes out what the turn
        would add to the shift, up to its square times the distance from the node.
        """
        k = int(np.argmin(np.abs(self.rest[:, 0] - s)))
        turn, shift = self.modes.fields(np.array([s]))
        step = Segment(1.0, -0.5, np.zeros((2, 6)))
        step.xi0[1, 3:] = [s, 0.0, 0.0] - self.rest[k]
        for j, column in enumerate(self.columns):
            for c in range(3):
                step.entries.append((column, c, turn[0, c, j], 0.0))
                step.entries.append((column, 3 + c, 0.0, shift[0, c, j] - self.shift[k, c, j]))
        return self.nodes[k], step


def append_link(chain: Chain, link: FlexibleLink) -> None:
    """Append a floating-frame link to a chain."""
    modes = Modes(link)
    begin = len(chain.names)
    columns = range(begin, begin + link.modes)
    chain.blocks.append(
        Block(
            begin,
            columns.stop,
            chain.node,
            modes.stiffness,
            modes.damping,
            modes.branch,
            modes.branch_time,
        )
    )
    chain.names += link.coordinates
    first = chain.node
    end = np.array([link.rod.length])
    tip_turn, tip_shift = (field[0] for field in modes.fields(end))
    rest, shift, nodes = np.zeros((1, 3)), np.zeros((1, 3, link.modes)), [first]

    def step_to(where: Floats, how: Floats, mass: float, drag: float) -> None:
        """Append a shift to where + how q, and a mass there."""
        nonlocal rest, shift
        step = _linear(columns, 3, how - shift[-1])
        step.xi0[:, 3:] = where - rest[-1]
        inertia = np.array([mass, 0.0, 0.0, 0.0])
        chain.add(step, inertia, drag * inertia)
        rest, shift = np.vstack([rest, [where]]), np.vstack([shift, [how]])
        nodes.append(chain.node)

    turns: list[tuple[Floats, Floats, float]] = []
    for drag, s, inertia in _distributions(link.rod):
        turn, moved = modes.fields(s)
        mass, at = concentrated(np.column_stack([s, moved.reshape(len(s), -1)]), inertia[:, 0], s)
        frame = inertia.sum(axis=0)
        frame[0] -= mass.sum()
        for amount, value in zip(mass, at, strict=True):
            where, how = np.array([value[0], 0.0, 0.0]), value[1:].reshape(3, -1)
            step_to(where, how, float(amount), drag)
        if link.rotary_inertia:
            for moments, how in _turning(turn, inertia[:, 1:], s):
                turns.append((how, moments, drag))
                frame[1:] -= moments
        # what the nodes do not have moves with the frame; never less than nothing
        frame = np.maximum(frame, 0.0)
        chain.inertia[first] += frame
        chain.drag[first] += drag * frame
    step_to(np.array([link.rod.length, 0.0, 0.0]), tip_shift, 0.0, 0.0)
    chain.segments[-1].span = (0.0, link.rod.length)
    for how, moments, drag in turns:
        row = np.array([0.0, *moments])
        chain.add(_linear(columns, 0, how), row, drag * row)
        chain.add(_linear(columns, 0, -how))
    chain.add(_linear(columns, 0, tip_turn))
    chain.frames[link.name] = chain.node
    chain.links[link.name] = LinkMap(link, modes, columns, first, nodes, rest, shift)


def _linear(columns: range, component: int, fields: Floats) -> Segment:
    """Return a segment that shifts (component 3) or turns (0) by fields (3, m) times q."""
    segment = Segment(0.5, 0.0, np.zeros((2, 6)))
    for j, column in enumerate(columns):
        for c in range(3):
            if fields[c, j] != 0.0:
                segment.entries.append((column, component + c, fields[c, j], fields[c, j]))
    return segment


def _turning(turn: Floats, moments: Floats, s: Floats) -> list[tuple[Floats, Floats]]:
    """Return (moments (3,), turn (3, m) per unit coordinate) of few bodies that turn alike.

    Alike in ∫ I ϑ and ∫ I ϑ ϑᵀ about each axis by itself: what linear modes see of the rotary
    inertia ``moments`` (N, 3) at arc lengths s. One node of the chain may bear one body per axis.
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
    for drag, part in parts.items():
        out.append((drag, np.concatenate([s for s, _ in part]), np.vstack([i for _, i in part])))
    return out
