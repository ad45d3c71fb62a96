"""Where rods lie in the forest of segments, and which of them lie in a row."""

from __future__ import annotations

from dataclasses import dataclass, field

from soft_sim_ros.scene import Rod

from .element import Element
from .link_map import LinkMap


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


@dataclass
class Branch:
    """Bodies in a row, each at the end of the one before: in a chain, all of them.

    spans : the rods and links among them, what has a length, base to tip
    behind : length in m of rods and links from the base to where the branch begins
    """

    first_node: int
    behind: float
    spans: list[RodMap | LinkMap] = field(default_factory=list)
    last_node: int = 0

    @property
    def length(self) -> float:
        """Length in m of its rods and links."""
        return sum(span.length for span in self.spans)

    @property
    def name(self) -> str:
        """The name of the first rod or link; empty without any."""
        return _name(self.spans[0]) if self.spans else ""


def _name(span: RodMap | LinkMap) -> str:
    return span.rod.name if isinstance(span, RodMap) else span.link.name
