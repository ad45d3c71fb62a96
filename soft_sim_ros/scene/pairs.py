"""Which bodies touch one another: ``pairs`` of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

from soft_sim_ros.scene.attachment import Forest
from soft_sim_ros.scene.body import Body, Joint, RigidBody, Rod
from soft_sim_ros.scene.contact import ContactLaw, read_contact
from soft_sim_ros.scene.material import Material
from soft_sim_ros.scene.reader import Reader

ALL = "all"
KEYS = ("bodies", "self", "contact", "overlap")


@dataclass(frozen=True)
class Pair:
    """Two bodies that touch one another; twice the same: a rod that touches itself.

    law : what it says about contact
    overlap : whether they may begin in one another
    key : where it is written
    """

    bodies: tuple[str, str]
    law: ContactLaw = ContactLaw()  # noqa: RUF009 - it is immutable
    overlap: bool = False
    key: str = "pairs"


def read_pairs(
    reader: Reader, materials: Mapping[str, Material], forest: Forest
) -> tuple[Pair, ...]:
    """Read ``pairs``: all, or a list."""
    if not reader.has("pairs"):
        return ()
    able = [body for body in forest.bodies if can_touch(body)]
    names = [body.name for body in able]
    if not reader.is_list("pairs"):
        if not reader.says("pairs", ALL):
            reader.refuse("all, or a list of entries with bodies: [...] or self: [...]", "pairs")
        found = [Pair((body.name,) * 2) for body in able if isinstance(body, Rod)]
        found += [Pair(two) for two in combinations(names, 2) if not attached(forest, *two)]
        if not found:
            reader.refuse("at least two bodies that can touch one another, or a rod", "pairs")
        return tuple(found)
    found = []
    for entry in reader.entries("pairs", required=True):
        found += _read_entry(entry, materials, forest, names)
    return tuple(found)


def _read_entry(
    entry: Reader, materials: Mapping[str, Material], forest: Forest, names: list[str]
) -> list[Pair]:
    entry.only(*KEYS)
    which = entry.one_of(("bodies", "self"))
    what = "body that can touch (a rod, or a rigid body with a shape)"
    named = entry.references(which, names, what)
    law = read_contact(entry.mapping("contact"), materials)
    overlap = entry.choice("overlap", ("true", "false"), default="false") == "true"
    by_name = {body.name: body for body in forest.bodies}
    if which == "self":
        for name in named:
            if not isinstance(by_name[name], Rod):
                entry.refuse(f"names of rods: {name} cannot touch itself", "self")
        pairs = [(name, name) for name in named]
    else:
        pairs = list(combinations(named, 2))
        if not pairs:
            entry.refuse("two names or more (self: is for a rod that touches itself)", "bodies")
        if len(named) > 2:
            pairs = [two for two in pairs if not attached(forest, *two)]
    return [Pair(two, law, overlap, f"{entry.path}.{which}") for two in pairs]


def can_touch(body: Body) -> bool:
    """Return whether a body can touch another one."""
    if isinstance(body, Rod):
        return body.contact.possible
    return isinstance(body, RigidBody) and body.shape is not None and body.contact.possible


def attached(forest: Forest, one: str, two: str) -> bool:
    """Return whether one of two bodies is attached to the other, or both by joints to one frame."""
    return two in carriers(forest, one) or one in carriers(forest, two)


def carriers(forest: Forest, name: str) -> list[str]:
    """Return the bodies up to the next rod or rigid body with a mass that a body is attached to."""
    bodies = {body.name: body for body in forest.bodies}
    found: list[str] = []
    at = forest.parent(name)
    while at is not None:
        found.append(at)
        if not isinstance(bodies[at], Joint):
            break
        at = forest.parent(at)
    return found


def related(forest: Forest, one: str, two: str) -> bool:
    """Return whether one of two bodies is between the other and the base; shapes never are."""
    names = {body.name for body in forest.bodies}
    for name, other in ((one, two), (two, one)):
        at = forest.parent(name) if name in names else None
        while at is not None:
            if at == other:
                return True
            at = forest.parent(at)
    return False
