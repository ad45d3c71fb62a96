"""Where a floating-frame link lies in the chain."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.segments import Segment
from soft_sim_ros.scene import FlexibleLink

# Degree of the strains, in every section, from which modes are computed.
FINE = 9


class Shapes(Protocol):
    """The m modes of a link."""

    def fields(self, s: Floats) -> tuple[Floats, Floats]:
        """Return rotations and displacements (N, 3, m) per unit coordinate at arc lengths s."""


@dataclass
class LinkMap:
    """Where a link lies in the chain.

    Attributes
    ----------
    nodes : nodes along the floating frame's axes, at ``rest`` (K, 3) + ``shift`` (K, 3, m) q in it
    loaded : by name of a load, the nodes it acts on and their shares: 1, or a length in m
    """

    link: FlexibleLink
    modes: Shapes
    columns: range
    first_node: int
    nodes: list[int]
    rest: Floats
    shift: Floats
    loaded: dict[str, list[tuple[int, float]]] = field(default_factory=dict)

    @property
    def length(self) -> float:
        """Reference length in m."""
        return self.link.rod.length

    def reach(self, beyond: float) -> Floats:
        """Return (m,) how far in m a unit of each coordinate moves a point ``beyond`` m further."""
        turn, shift = self.modes.fields(np.linspace(0.0, self.length, 3 * FINE))
        far = np.abs(shift).max(axis=(0, 1)) + beyond * np.abs(turn[-1]).max(axis=0)
        return np.maximum(far, self.length * np.abs(turn).max(axis=(0, 1)))

    def sample(self, s: float) -> tuple[int, Segment]:
        """Return a node and the step from it to the section at arc length s.

        One exponential stands for the section's shift followed by its turn. The term [ξ₁, ξ₂]
        removes what the turn would add to the shift, up to the square of the turn times the
        distance from the node.
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
