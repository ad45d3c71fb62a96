"""Loads by laws of the user's, lumped to nodes."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.backend.laws import key_of
from soft_sim_ros.core.model.model import Custom
from soft_sim_ros.core.model.packing import floats, ints
from soft_sim_ros.scene import Scene
from soft_sim_ros.scene.custom_load import CustomLoad

from .chain import Chain
from .loads import shares_along


def flat_custom(scene: Scene, chain: Chain) -> Custom:
    """Return the laws on all nodes of a scene."""
    found: list[tuple[int, float, CustomLoad]] = []
    for load in scene.loads:
        if not isinstance(load, CustomLoad):
            continue
        rod_map = chain.rods.get(load.body)
        if rod_map is None:
            found.append((chain.ends[load.body], 1.0, load))
        elif load.start == load.end:
            found.append((chain.node_at(rod_map, load.start), 1.0, load))
        else:
            places = shares_along(rod_map, load.start, load.end)
            found += [(node, share, load) for node, share in places]
    found.sort(key=lambda item: item[0])
    most = max((len(load.parameters) for _, _, load in found), default=0)
    base = se3.pose_matrix(scene.base.position, scene.base.quaternion)
    counts = np.bincount([node for node, _, _ in found], minlength=chain.node + 1)
    return Custom(
        ptr=ints([0, *np.cumsum(counts)] if found else []),
        node=ints([node for node, _, _ in found]),
        share=floats([share for _, share, _ in found]),
        key=ints([key_of(load.law) for _, _, load in found]),
        parameters=floats(
            [[*load.parameters, *[0.0] * (most - len(load.parameters))] for _, _, load in found]
        ).reshape(len(found), -1 if found else 0),
        base=np.concatenate([base[:3, :3].ravel(), base[:3, 3]]),
    )
