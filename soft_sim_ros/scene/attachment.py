"""Where bodies are attached: a forest of bodies in the order of the one recursion over them.

A body leaves the end of the body listed before it, unless ``parent`` says otherwise. What comes
out is depth first: every body after its parent, a whole branch before the next one begins, and
right after a body the one that goes on from its end. A forest that is a chain is that chain,
however it is written down.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from soft_sim_ros.scene.body import Body
from soft_sim_ros.scene.pose import IDENTITY, Pose

BASE = "base"  # what scenes call the frame that their ``base`` places in the world


@dataclass(frozen=True, eq=False)
class Attachment:
    """Where a body begins that does not go on from the end of the body before it.

    parent : name of a body; None: the base
    s : arc length in m along the parent, a rod; None: the end of the parent
    offset : pose of the body's first frame in the frame it is attached to
    """

    parent: str | None
    s: float | None = None
    offset: Pose = IDENTITY


@dataclass(frozen=True)
class Forest:
    """Bodies depth first, and where those are attached that do not follow the one before."""

    bodies: tuple[Body, ...]
    attachments: Mapping[str, Attachment]

    def parent(self, name: str) -> str | None:
        """Return the name of the body that a body is attached to; None: the base."""
        if name in self.attachments:
            return self.attachments[name].parent
        index = [body.name for body in self.bodies].index(name)
        return self.bodies[index - 1].name if index else None
