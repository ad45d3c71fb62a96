"""Loads lumped to nodes by Gauss–Lobatto weights."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Loads
from soft_sim_ros.core.model.packing import floats, ints
from soft_sim_ros.core.quadrature import lobatto
from soft_sim_ros.scene import DistributedLoad, InputLoad, PointLoad, Scene

from .chain import Chain, RodMap
from .drives import courses, flat_drives
from .fluid import flat_current


def lump_loads(scene: Scene, chain: Chain, rotation: Floats) -> Loads:
    """Return the loads of a scene; rotation (3, 3) is that of the base in the world."""
    nodes: list[int] = []
    wrenches: list[Floats] = []
    ptr = [0]
    loads = scene.scheduled_loads
    for load in loads:
        wrench = np.concatenate([load.moment, load.force])
        if load.frame == "world":
            wrench = np.concatenate([rotation.T @ load.moment, rotation.T @ load.force])
        for node, share in node_shares(chain, load):
            nodes.append(node)
            wrenches.append(share * wrench)
        ptr.append(len(nodes))
    times = {t for load in loads for t in load.schedule.switch_times}
    times |= {t for course in courses(scene) for t in course.switches}
    times |= {t for course in (scene.fluid.current if scene.fluid else ()) for t in course.switches}
    times |= {t for one in scene.constraints for t in one.switch_times}
    switches = sorted(times)
    return Loads(
        ptr=ints(ptr),
        node=ints(nodes),
        wrench=floats(wrenches).reshape(-1, 6),
        follows=ints([load.frame == "body" for load in loads]),
        schedule=floats(
            [(x.schedule.start, x.schedule.end, x.schedule.ramp) for x in loads]
        ).reshape(-1, 3),
        switches=floats(switches),
        drives=flat_drives(scene, chain),
        current=flat_current(scene),
        push=ints([_node_of(chain, load) for load in scene.input_loads]),
    )


def _node_of(chain: Chain, load: InputLoad) -> int:
    """Return the node on which a commanded wrench acts."""
    return max(node_shares(chain, load), key=lambda share: share[1])[0]


def node_shares(
    chain: Chain, load: PointLoad | DistributedLoad | InputLoad
) -> list[tuple[int, float]]:
    """Return the nodes on which a load acts and the share of each: 1, or a length in m.

    Gauss–Lobatto weights of the elements that a distributed load covers.
    """
    if load.body in chain.links:
        return chain.links[load.body].loaded[load.name]
    if not isinstance(load, DistributedLoad):
        rod_map = chain.rods.get(load.body)
        return [(chain.node_at(rod_map, load.s) if rod_map else chain.frames[load.body], 1.0)]
    return shares_along(chain.rods[load.body], load.start, load.end)


def shares_along(rod_map: RodMap, start: float, end: float) -> list[tuple[int, float]]:
    """Return the nodes of a rod between two arc lengths in m, and the length in m of each."""
    shares = []
    for element in rod_map.elements:
        begin, stop = element.span
        _, weights = lobatto(element.nodes)
        if start < 0.5 * (begin + stop) < end:
            for i, weight in enumerate(weights):
                shares.append((element.first_segment + i, (stop - begin) * weight))
    return shares
