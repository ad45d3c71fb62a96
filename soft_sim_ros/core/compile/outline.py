"""Elements of rods without their segments: enough to ask how many nodes they need."""

from __future__ import annotations

from soft_sim_ros.scene import Basis

from .chain import Chain
from .element import Element
from .spans import RodMap


class Outline(Chain):
    """A chain that has elements but no nodes: it tells how many nodes the rods need."""

    def _fill(self, elements: list[Element], labels: list[str], basis: Basis) -> None:
        self.names += labels

    def node_at(self, rod_map: RodMap, s: float) -> int:
        """Return the first node of a rod: it has no others here."""
        return rod_map.first_node
