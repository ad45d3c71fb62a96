"""From what is written of bodies, ``parent`` above all, to the forest that they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from soft_sim_ros.scene.attachment import BASE, Attachment, Forest
from soft_sim_ros.scene.body import ROUNDING, Body, Rod
from soft_sim_ros.scene.joint import Joint
from soft_sim_ros.scene.pose import IDENTITY, read_pose
from soft_sim_ros.scene.read_route import read_arc_length
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.words import nearest


def read_forest(entries: Sequence[Reader], bodies: Sequence[Body]) -> Forest:
    """Read ``parent`` of all bodies and return the forest; one entry for each body, as listed.

    Raises
    ------
    SceneError
        for a parent that does not exist, or that is attached to its own child
    """
    by_name = {body.name: body for body in bodies}
    wanted: dict[str, Attachment] = {}
    before: str | None = None
    for reader, body in zip(entries, bodies, strict=True):
        wanted[body.name] = _read(reader, body, by_name, before)
        before = body.name
    _refuse_circles(entries, bodies, wanted)
    return _depth_first(by_name, wanted)


def _read(reader: Reader, body: Body, known: Mapping[str, Body], before: str | None) -> Attachment:
    free = isinstance(body, Joint) and body.kind == "free"
    if not reader.has("parent"):
        if free and before is not None:
            reader.refuse("a free joint only on the base: the first body, or parent: base", "kind")
        return Attachment(before)
    s, offset = None, IDENTITY
    if reader.is_mapping("parent"):
        place = reader.mapping("parent").only("body", "s", "offset")
        parent = _parent(place, "body", known, body.name)
        if place.has("s"):
            s = _arc_length(place, parent, known)
        if place.has("offset") and isinstance(body, Joint):
            place.refuse("no offset here: a joint has its own", "offset")
        offset = read_pose(place.mapping("offset"))
    else:
        parent = _parent(reader, "parent", known, body.name)
    if free and parent is not None:
        reader.refuse("base: a free joint is attached to nothing else", "parent")
    return Attachment(parent, s, offset)


def _parent(reader: Reader, key: str, known: Mapping[str, Body], own: str) -> str | None:
    name = str(reader.word(key, expected=f"the name of a body, or {BASE}"))
    if name == BASE and BASE in known:
        expected = f"another name for the body {BASE}: as a parent, {BASE} is the scene's base"
        reader.refuse(expected, key)
    options = [BASE, *(other for other in known if other != own)]
    if name == own:
        reader.refuse(f"another body than itself, {nearest('', options)}", key)
    if name not in options:
        reader.refuse(f"the name of a body, or {BASE}: {nearest(name, options)}", key)
    return None if name == BASE else name


def _arc_length(place: Reader, parent: str | None, known: Mapping[str, Body]) -> float | None:
    rod = None if parent is None else known[parent]
    if not isinstance(rod, Rod):
        place.refuse(f"no s: {parent or BASE} is not a rod", "s")
    s = read_arc_length(place, "s", rod, default=rod.length)
    return None if s >= rod.length * (1.0 - ROUNDING) else s


def _refuse_circles(
    entries: Sequence[Reader], bodies: Sequence[Body], wanted: Mapping[str, Attachment]
) -> None:
    for reader, body in zip(entries, bodies, strict=True):
        seen, name = [body.name], wanted[body.name].parent
        while name is not None and name not in seen:
            seen.append(name)
            name = wanted[name].parent
        if name == body.name:
            circle = " → ".join([*seen, body.name])
            expected = f"a parent that is not attached to this body itself ({circle})"
            reader.refuse(expected, "parent" if reader.has("parent") else None)


def _goes_on(attachment: Attachment) -> bool:
    """Return whether a body leaves the very end of its parent."""
    offset = attachment.offset
    same = not offset.position.any() and not offset.quaternion[:3].any()
    return attachment.s is None and same


def _depth_first(by_name: Mapping[str, Body], wanted: Mapping[str, Attachment]) -> Forest:
    children: dict[str | None, list[str]] = {name: [] for name in [None, *by_name]}
    for name, attachment in wanted.items():
        children[attachment.parent].append(name)
    for own in children.values():
        on = next((name for name in own if _goes_on(wanted[name])), None)
        if on is not None:
            own.insert(0, own.pop(own.index(on)))
    bodies: list[Body] = []
    attachments: dict[str, Attachment] = {}
    waiting = children[None][::-1]
    before: str | None = None
    while waiting:
        name = waiting.pop()
        if wanted[name].parent != before or not _goes_on(wanted[name]):
            attachments[name] = wanted[name]
        bodies.append(by_name[name])
        waiting += children[name][::-1]
        before = name
    return Forest(tuple(bodies), attachments)
