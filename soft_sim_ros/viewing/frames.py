"""Frames anywhere on an arm: at arc lengths of its rods, at joints, rigid bodies, base and tip."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from soft_sim_ros.core.compile.samples import Place, at_node, locate_in
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics import sampler
from soft_sim_ros.errors import BadArgument

if TYPE_CHECKING:
    from soft_sim_ros.core.compile.scene import Compiled

BASE, TIP = "base", "tip"
Spot = tuple[str, float]  # a body (or BASE, TIP), and an arc length in m for a rod or link


class Frames(sampler.Frames):
    """Poses of spots of an arm; quaternions keep their sign from call to call.

    Parameters
    ----------
    compiled : the arm
    q : (n,) its coordinates, contiguous doubles, read anew at every call
    spots : P of them
    """

    def __init__(self, compiled: Compiled, q: Floats, spots: Sequence[Spot]) -> None:
        super().__init__(compiled, q, [_place(compiled, spot) for spot in spots])
        self.spots = tuple(spots)


def _place(compiled: Compiled, spot: Spot) -> Place:
    name, s = spot
    chain = compiled.chain
    if name in chain.rods:
        return locate_in(chain, chain.rods[name], s)
    if name in chain.links:
        return locate_in(chain, chain.links[name], s)
    if name in chain.frames:
        return at_node(chain.frames[name])
    if name not in (BASE, TIP):
        raise BadArgument("name", name, "a body of the scene, 'base' or 'tip'")
    return at_node(0 if name == BASE else chain.node)
