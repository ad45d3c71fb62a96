"""The rows of rods in a forest, its ends, and its inputs: by names, from the scene alone."""

from __future__ import annotations

from dataclasses import dataclass

from soft_sim_ros.scene.body import Body, FlexibleLink, RigidBody, Rod
from soft_sim_ros.scene.joint import Joint
from soft_sim_ros.scene.load_scene import Scene
from soft_sim_ros.scene.pose import Pose


@dataclass(frozen=True)
class Limbs:
    """What of an arm has a shape, an end, or an input of its own.

    Parameters
    ----------
    backbones : rods and links in a row, named by the first of them
    tips : bodies that nothing is attached to the end of; the last one is what a scene's tip is
    rows : the rods and links of each backbone, base to tip
    branched : whether some body does not go on from the end of the one before
    wrenches : input loads
    posed : free joints that follow poses
    commanded : driven coordinates that follow commands
    held : constraints
    touches : whether bodies can touch anything
    bodies, shapes : names, in the order of the scene
    """

    backbones: tuple[str, ...] = ()
    tips: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    branched: bool = False
    wrenches: tuple[str, ...] = ()
    posed: tuple[str, ...] = ()
    commanded: tuple[str, ...] = ()
    held: tuple[str, ...] = ()
    touches: bool = False
    bodies: tuple[str, ...] = ()
    shapes: tuple[str, ...] = ()

    @property
    def several_backbones(self) -> tuple[str, ...]:
        """The backbones where there is more than one."""
        return self.backbones if len(self.backbones) > 1 else ()

    @property
    def several_tips(self) -> tuple[str, ...]:
        """The tips where there is more than one."""
        return self.tips if len(self.tips) > 1 else ()

    def facts(self) -> dict[str, list[str]]:
        """Return the names of several backbones and tips, for summaries; nothing of a chain."""
        found = {"backbones": self.several_backbones, "tips": self.several_tips}
        return {key: list(names) for key, names in found.items() if names}


CHAIN = Limbs()  # one backbone, one tip: nobody asks for their names


def limbs_of(scene: Scene) -> Limbs:
    """Return the backbones and tips of a scene, both in the order of its bodies."""
    rows: list[list[str]] = [[]]
    place: dict[str | None, str | None] = {None: None}  # where a body ends: the end of which one
    left: set[str | None] = set()  # ends that something is attached to
    before: str | None = None
    for body in scene.bodies:
        attachment = scene.attachments.get(body.name)
        if attachment is not None:
            rows.append([])
            if attachment.s is None:
                left.add(place[attachment.parent])
        elif _takes_room(body):
            left.add(place[before])
        goes_on = attachment is None and not _takes_room(body)
        place[body.name] = place[before] if goes_on else body.name
        if isinstance(body, Rod | FlexibleLink):
            rows[-1].append(body.name)
        before = body.name
    ends = {end: name for name, end in place.items() if name and end not in left}
    rows = [row for row in rows if row]
    return Limbs(
        tuple(row[0] for row in rows),
        tuple(ends.values()),
        tuple(map(tuple, rows)),
        bool(scene.attachments),
        tuple(load.name for load in scene.input_loads),
        scene.posed,
        tuple(scene.commanded),
        tuple(one.name for one in scene.constraints),
        scene.touches,
        tuple(body.name for body in scene.bodies),
        tuple(shape.name for shape in scene.environment),
    )


def _takes_room(body: Body) -> bool:
    """Return whether the end of a body is another place than its beginning."""
    if isinstance(body, RigidBody):
        return _moves(body.com)
    return not isinstance(body, Joint) or body.kind != "fixed" or _moves(body.offset)


def _moves(pose: Pose) -> bool:
    return bool(pose.position.any() or pose.quaternion[:3].any())
