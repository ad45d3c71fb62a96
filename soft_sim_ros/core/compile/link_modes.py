"""The modes of a floating-frame link, from the link's own data: Boyer & Primault 2005 (3.26)."""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np
import scipy

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.segments import Block, Segment
from soft_sim_ros.scene import Basis, FlexibleLink

from .chain import Chain
from .link_map import FINE
from .outline import Outline

# Strains that move together where the rod is straight: twisting, two planes of bending, stretching.
GROUPS = {"torsion": (0,), "bend_y": (1, 5), "bend_z": (2, 4), "stretch": (3,)}
FIELDS = 64  # sets of arc lengths at which a link's fields are remembered


class Modes:
    """The lowest modes of a straight rod that is clamped at its start.

    Eigenvectors of the rod linearised at rest, with its strains as polynomials. Scaled so that
    the largest displacement of a mode is 1 m per unit coordinate. Twisting modes displace nothing;
    they are scaled so that their largest angle times the length is 1 m.

    Attributes
    ----------
    frequencies : (m,) rad/s
    stiffness, damping, branch : (m, m), the last of Maxwell branches with branch_time in s
    """

    def __init__(self, link: FlexibleLink) -> None:
        self._rod = link.rod
        self._chain = Chain()
        basis = Basis(order=dict.fromkeys(link.rod.strains, FINE))
        outline = Outline()
        outline.rod(link.rod, basis, set())
        # nodes enough for the inertia: the rods are straight and at rest
        nodes = max(element.least_nodes for element in outline.rods[link.rod.name].elements)
        self._chain.rod(link.rod, replace(basis, nodes=nodes), set())
        stiffness, damping, branch = (
            _assembled(self._chain.blocks, x) for x in ("stiffness", "damping", "branch")
        )
        ends = [0.0, *(segment.span[1] for segment in self._chain.segments)]
        small = self._small_motions(np.array(ends))
        inertia = np.array(self._chain.inertia)
        mass = np.einsum("kcn,k,kcm->nm", small[:, 3:], inertia[:, 0], small[:, 3:])
        if link.rotary_inertia:
            mass += np.einsum("kcn,kc,kcm->nm", small[:, :3], inertia[:, 1:], small[:, :3])
        mass += link.tip_mass * small[-1, 3:].T @ small[-1, 3:]
        found: list[tuple[float, Floats]] = []
        for name, group in GROUPS.items():
            own = self._columns_of(group)
            if not own:
                continue
            rows = small[-1, 4:, own].T if link.tip == "pinned" else np.zeros((2, len(own)))
            free = np.eye(len(mass))[:, own] @ scipy.linalg.null_space(rows)
            if free.shape[1] == 0:
                continue
            # K is well conditioned, M is not: strains of high degree hardly move the rod
            values, vectors = scipy.linalg.eigh(free.T @ mass @ free, free.T @ stiffness @ free)
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
        # read-only: one link's modes are in all compiled scenes that have this link
        for array in (self.frequencies, self.stiffness, self.damping, self.branch):
            array.flags.writeable = False
        self._known: dict[bytes, Floats] = {}

    def fields(self, s: Floats) -> tuple[Floats, Floats]:
        """Return rotations and displacements (N, 3, m) per unit coordinate at arc lengths s."""
        key = s.tobytes()
        if key not in self._known:
            if len(self._known) == FIELDS:
                self._known.clear()
            motions = self._small_motions(s) @ self._shapes
            motions.flags.writeable = False
            self._known[key] = motions
        return self._known[key][:, :3], self._known[key][:, 3:]

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


_KNOWN: WeakKeyDictionary[FlexibleLink, Modes] = WeakKeyDictionary()


def modes_of(link: FlexibleLink) -> Modes:
    """Return the modes of a link, made once and remembered: no choice of numerics changes them."""
    if link not in _KNOWN:
        _KNOWN[link] = Modes(link)
    return _KNOWN[link]


def _scaled(shape: Floats, small: Floats, length: float) -> Floats:
    """Return a mode (n,) with the sign and size documented in the class."""
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
