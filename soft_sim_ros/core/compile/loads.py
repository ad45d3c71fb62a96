"""Loads lumped to nodes by Gauss–Lobatto weights."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Loads
from soft_sim_ros.core.model.packing import floats, ints
from soft_sim_ros.core.quadrature import lobatto
from soft_sim_ros.scene import Load, PointLoad, Scene

from .chain import Chain
from .drives import courses, flat_drives


def lump_loads(scene: Scene, chain: Chain, rotation: Floats) -> Loads:
    """Return the loads of a scene; rotation (3, 3) is that of the base in the world."""
    nodes: list[int] = []
    wrenches: list[Floats] = []
    ptr = [0]
    for load in scene.loads:
        wrench = np.concatenate([load.moment, load.force])
        if load.frame == "world":
            wrench = np.concatenate([rotation.T @ load.moment, rotation.T @ load.force])
        for node, share in _shares(chain, load):
            nodes.append(node)
            wrenches.append(share * wrench)
        ptr.append(len(nodes))
    times = {t for load in scene.loads for t in load.schedule.switch_times}
    times |= {t for course in courses(scene) for t in course.switches}
    switches = sorted(times)
    return Loads(
        ptr=ints(ptr),
        node=ints(nodes),
        wrench=floats(wrenches).reshape(-1, 6),
        follows=ints([load.frame == "body" for load in scene.loads]),
        schedule=floats(
            [(x.schedule.start, x.schedule.end, x.schedule.ramp) for x in scene.loads]
        ).reshape(-1, 3),
        switches=floats(switches),
        drives=flat_drives(scene, chain),
    )


def _shares(chain: Chain, load: Load) -> list[tuple[int, float]]:
    """Return the nodes on which a load acts and the share of each: 1, or a length in m.

    Gauss–Lobatto weights of the elements that a distributed load covers.
    """
    if load.body in chain.links:
        return chain.links[load.body].loaded[load.name]
    if isinstance(load, PointLoad):
        rod_map = chain.rods.get(load.body)
        return [(chain.node_at(rod_map, load.s) if rod_map else chain.frames[load.body], 1.0)]
    shares = []
    for element in chain.rods[load.body].elements:
        begin, end = element.span
        _, weights = lobatto(element.nodes)
        if load.start < 0.5 * (begin + end) < load.end:
            for i, weight in enumerate(weights):
                shares.append((element.first_segment + i, (end - begin) * weight))
    return shares
