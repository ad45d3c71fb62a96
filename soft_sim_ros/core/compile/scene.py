"""Compile a validated scene into the flat arrays of model.py.

Nothing that the scene lacks gets an array entry.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.algebra.motion_space import Spatial
from soft_sim_ros.core.arguments import vector
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Loads, Model
from soft_sim_ros.core.model.packing import flat_entries, flat_tree, floats, ints
from soft_sim_ros.core.quadrature import scattered
from soft_sim_ros.errors import NoSuchPlace, SceneError
from soft_sim_ros.scene import (
    Attachment,
    FlexibleLink,
    InputLoad,
    Joint,
    PointLoad,
    RigidBody,
    Rod,
    Scene,
)
from soft_sim_ros.scene.custom_load import CustomLoad

from .chain import Branch, Chain
from .closures import flat_closures
from .contact import flat_contact
from .custom import flat_custom
from .drives import refuse_undriven
from .fingerprint import fingerprint, sums
from .fluid import flat_fluid
from .link import append_link
from .loads import lump_loads
from .materials import of_materials
from .other_materials import SameShape, differ_in_materials, same_laws
from .overflow import refuse_overflow
from .pairs import flat_pairs
from .ports import Path, flat_ports, winding
from .size import refuse_size
from .weights import weights


@dataclass(frozen=True, eq=False)
class Compiled:
    """A model, with the names and places of the scene's bodies, actuators and loads in it."""

    scene: Scene  # its numerics are complete
    chain: Chain
    model: Model
    loads: Loads
    base: Floats  # (4, 4) base pose in the world
    gravity: Floats  # (3,) in the base frame, m/s²
    coordinate_names: tuple[str, ...]
    # of rods and links on the longest way from the base to a tip, m; 1 for a scene without any
    length: float
    tips: tuple[int, ...]  # nodes that nothing is beyond of, in the order of the bodies
    # (T,) length over that on the way to a tip: what errors and ways of a tip are multiplied by
    # before they are measured by the length
    tip_scale: Floats

    # It is immutable, so a copy is the same object; a pickle holds the scene only.

    def __copy__(self) -> Compiled:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Compiled:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return compile_scene, (self.scene,)

    @property
    def backbones(self) -> dict[str, Branch]:
        """Rods and links in a row, by the name of the first of each row, in the order of bodies."""
        return {branch.name: branch for branch in self.chain.branches if branch.spans}

    def backbone(self, name: str | None = None) -> Branch:
        """Return a backbone by its name, by default the last one.

        Raises
        ------
        NoSuchPlace
            if there is none of that name
        """
        found = self.backbones
        if name is None:
            return list(found.values())[-1] if found else self.chain.branches[-1]
        if name not in found:
            raise NoSuchPlace(name, f"one of the backbones {', '.join(found) or '(none)'}")
        return found[name]

    def node_of(self, frame: str | None = None) -> int:
        """Return the node at the end of a body; without a name, the last one of all.

        Raises
        ------
        NoSuchPlace
            if there is no body of that name
        """
        ends = self.chain.ends
        if frame is None:
            return self.chain.node
        if frame not in ends:
            raise NoSuchPlace(frame, f"one of the bodies {', '.join(ends)}")
        return ends[frame]

    @cached_property
    def fingerprint(self) -> dict[str, Floats]:
        """A few numbers of every array that decides how the model moves."""
        found = fingerprint(self.model) | fingerprint(self.loads)
        return found | {"gravity": sums(self.gravity)}

    def to_base(self, wrench: Floats) -> Floats:
        """Return the base-frame components of a wrench (6,) given along the world axes."""
        rotation, wrench = self.base[:3, :3].T, vector("wrench", wrench, 6)
        return np.concatenate([rotation @ wrench[:3], rotation @ wrench[3:]])


def compile_scene(scene: Scene, like: Compiled | None = None) -> Compiled:
    """Return the model of a scene: what all its simulations share.

    Parameters
    ----------
    scene : with numerics that leave nothing free (`settle` chooses them)
    like : the model of a scene that differs in the materials of rods alone: all that they do not
        change is taken from there, with the same bits as without it. That of any other scene is
        of no use, and does no harm

    Raises
    ------
    SceneError
        if its numerics are incomplete: ``settle`` completes them (accuracy/contract.py);
        if its numbers overflow when combined
    """
    if scene.numerics.free:
        expected = "numerics that leave nothing free: settle the scene first"
        raise SceneError(scene.file, "numerics", scene.name, expected)
    refuse_undriven(scene)
    refuse_size(scene)
    shared = like if like is not None and differ_in_materials(scene, like.scene) else None
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        compiled = _compiled(scene) if shared is None else _of_other_materials(scene, shared)
    refuse_overflow(scene, compiled.model, compiled.loads)
    return compiled


def _compiled(scene: Scene) -> Compiled:
    base = se3.pose_matrix(scene.base.position, scene.base.quaternion)
    chain = build_chain(scene)
    return Compiled(
        scene=scene,
        chain=chain,
        model=_flatten(scene, chain),
        loads=lump_loads(scene, chain, base[:3, :3]),
        base=base,
        gravity=base[:3, :3].T @ scene.gravity,
        coordinate_names=tuple(chain.names),
        length=chain.whole[0],
        tips=tuple(chain.tips),
        tip_scale=chain.whole[0] / np.array([chain.whole[node] for node in chain.tips]),
    )


def _of_other_materials(scene: Scene, like: Compiled) -> Compiled:
    """Return the model of a scene that differs from another one in the materials of rods."""
    chain = build_chain(scene, SameShape(like.chain))
    fibres = like.model.fibres if same_laws(scene, like.scene) else None
    changed = of_materials(chain, like.model.seg_block, fibres)
    contact, pairs = flat_contact(scene, chain), flat_pairs(scene, chain)
    model = like.model._replace(**changed, contact=contact, pairs=pairs)
    return replace(like, scene=scene, chain=chain, model=model)


def build_chain(scene: Scene, chain: Chain | None = None) -> Chain:
    """Return the forest of segments of a scene, rods cut where loads, tendons and bodies jump in.

    They are appended to ``chain`` if that is given.
    """
    cuts: dict[str, set[float]] = {body.name: set() for body in scene.bodies}
    turning = dict.fromkeys(cuts, 0.0)
    for load in scene.loads:
        if isinstance(load, PointLoad | InputLoad):
            cuts[load.body].add(load.s)
        elif isinstance(load, CustomLoad) and load.start == load.end:
            cuts[load.body].add(load.start)
        else:
            cuts[load.body] |= {load.start, load.end}
    for actuator in scene.actuators:
        if isinstance(actuator, Path):
            for stretch in actuator.stretches:
                cuts[stretch.rod] |= stretch.cuts
                if isinstance(chain, SameShape):  # its nodes are counted
                    continue
                s = scattered(stretch.start, stretch.end)
                turning[stretch.rod] = max(turning[stretch.rod], float(winding(stretch, s).max()))
    marked: dict[str, set[float]] = {name: set() for name in cuts}
    for attachment in scene.attachments.values():
        if attachment.parent is not None and attachment.s is not None:
            marked[attachment.parent].add(attachment.s)
    for constraint in scene.constraints:
        for place in constraint.frames:
            if place.body is not None and place.s is not None:
                marked[place.body].add(place.s)
    chain = Chain() if chain is None else chain
    for body in scene.bodies:
        if body.name in scene.attachments:
            _begin_branch(chain, scene.attachments[body.name])
        if isinstance(body, Rod):
            own = marked[body.name]
            basis, all_cuts = scene.numerics.rods[body.name], cuts[body.name] | own
            chain.rod(body, basis, all_cuts, turning[body.name], own)
            _check_nodes(scene, chain, body)
        elif isinstance(body, FlexibleLink):
            append_link(
                chain,
                body,
                [
                    load
                    for load in (*scene.scheduled_loads, *scene.input_loads)
                    if load.body == body.name
                ],
            )
        elif isinstance(body, Joint):
            chain.joint(body)
        elif isinstance(body, RigidBody):
            chain.rigid_body(body)
        chain.ends[body.name] = chain.node
    chain.close()
    return chain


def _begin_branch(chain: Chain, attachment: Attachment) -> None:
    """Begin a branch at the base, at the end of a body, or somewhere along a rod."""
    parent, s = attachment.parent, attachment.s
    if parent is None:
        chain.branch(0, attachment.offset, 0.0)
    elif s is None:
        node = chain.ends[parent]
        chain.branch(node, attachment.offset, chain.behind[node])
    else:
        rod_map = chain.rods[parent]
        node = chain.node_at(rod_map, s)
        chain.branch(node, attachment.offset, chain.behind[rod_map.first_node] + s)


def _check_nodes(scene: Scene, chain: Chain, rod: Rod) -> None:
    """Refuse too few nodes: strains without inertia, or a reference shape that is not resolved."""
    basis = scene.numerics.rods[rod.name]
    if basis.nodes is None:
        return
    key = f"numerics.rods.{rod.name}.nodes"
    least = max(basis.order.values(), default=0) + 2
    if basis.kind not in ("constant", "linear") and basis.nodes < least:
        expected = f"at least {least}, the order of the basis and two more"
        raise SceneError(scene.file, key, basis.nodes, expected)
    for _, segment in chain.rod_segments(chain.rods[rod.name]):
        turn = 2.0 * segment.half * float(np.linalg.norm(segment.xi0[:, :3], axis=1).max())
        if turn >= np.pi:
            expected = (
                f"more nodes or elements: the reference shape turns by {turn:.3g} rad in a segment"
            )
            raise SceneError(scene.file, key, basis.nodes, expected)


def _flatten(scene: Scene, chain: Chain) -> Model:
    blocks, segments = chain.blocks, chain.segments
    block_seg = ints([*(block.first_segment for block in blocks), len(segments)])
    seg_block = ints(np.repeat(np.arange(len(blocks)), np.diff(block_seg)))
    entries = flat_entries(segments)
    return Model(
        half=floats([s.half for s in segments]),
        kappa=floats([s.kappa for s in segments]),
        xi0=floats([s.xi0 for s in segments]).reshape(-1, 2, 6),
        entry_ptr=entries[0],
        entry_col=entries[1],
        entry_comp=entries[2],
        entry_phi=entries[3],
        block_col=ints([*(block.begin for block in blocks), len(chain.names)]),
        block_seg=block_seg,
        seg_block=seg_block,
        tree=flat_tree(segments, blocks),
        weight=weights(chain),
        **(of_materials(chain, seg_block) | flat_ports(scene, chain)),
        chart=ints(chain.charts),
        free=ints(chain.carried).reshape(-1, 3),
        custom=flat_custom(scene, chain),
        driven=ints(chain.driven).reshape(-1, 2),
        fluid=flat_fluid(scene, chain),
        contact=flat_contact(scene, chain),
        pairs=flat_pairs(scene, chain),
        closures=flat_closures(scene, chain),
        space=Spatial(),
    )
