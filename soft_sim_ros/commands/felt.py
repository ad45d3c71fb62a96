"""Lines about what an arm feels: its constraints and contacts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from soft_sim_ros.core.mechanics.closures import Reaction
from soft_sim_ros.core.mechanics.contacts import Contact, resultants
from soft_sim_ros.core.mechanics.redundancy import Redundancy
from soft_sim_ros.scene import Scene

MOST = 12  # constraints or pairs that are told of


def felt_lines(
    scene: Scene,
    reactions: Mapping[str, Reaction],
    contacts: Sequence[Contact],
    redundant: Mapping[str, Redundancy] | None = None,
) -> Iterator[str]:
    """Yield a line for each constraint and for each pair that touches; nothing where none can."""
    for one in scene.constraints[:MOST]:
        reaction = reactions[one.name]
        force, moment = np.linalg.norm(reaction.force), np.linalg.norm(reaction.moment)
        said = f"; {redundant[one.name].words()}" if redundant and one.name in redundant else ""
        yield f"constraint        {one.name}, {one.kind}: {force:.4g} N, {moment:.4g} N·m{said}"
    if len(scene.constraints) > MOST:
        yield f"                  and {len(scene.constraints) - MOST} more constraints"
    named = {(one.body, one.shape) for one in contacts}  # what each does to the other is told once
    pairs = [item for item in resultants(contacts).items() if item[0] in named]
    for (body, shape), wrench in pairs[:MOST]:
        own = [one for one in contacts if (one.body, one.shape) == (body, shape)]
        normal = sum(one.normal_force for one in own)
        deepest = -min(one.gap for one in own)
        yield (
            f"contact           {body} on {shape}: {np.linalg.norm(wrench[3:]):.4g} N, "
            f"{normal:.4g} N of it along normals; points {len(own)}, of which "
            f"{sum(one.sticks for one in own)} stick, at most {deepest:.2g} m deep"
        )
    if len(pairs) > MOST:
        yield f"                  and {len(pairs) - MOST} more pairs"
    if scene.touches and not pairs:
        yield "contact           none"
