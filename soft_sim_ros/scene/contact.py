"""How bodies resist what they touch: keys of ``contact``, for a scene, a shape or a body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

from soft_sim_ros.scene.interval import NONNEGATIVE, POSITIVE
from soft_sim_ros.scene.material import Material
from soft_sim_ros.scene.reader import Reader

KEYS = (
    "stiffness", "material", "onset", "dissipation", "friction", "tangential_stiffness",
    "tangential_time",
)  # fmt: skip


@dataclass(frozen=True)
class Friction:
    """Coefficients of Coulomb friction.

    Along a rod when it sticks and when it slides, and across it when it slides.
    """

    static: float
    kinetic: float
    across: float


@dataclass(frozen=True)
class ContactLaw:
    """What is written about a contact; None: nothing is.

    stiffness in Pa: force per length of a rod and per depth; that of a material is Hertz's.
    onset in m: depth up to which the force grows with its square; dissipation in s/m: force of
    damping over elastic force, per speed; tangential_stiffness in Pa and tangential_time in s: of
    the bristles that friction bends before it slides.
    """

    stiffness: float | None = None
    material: Material | None = None
    onset: float | None = None
    dissipation: float | None = None
    friction: Friction | None = None
    tangential_stiffness: float | None = None
    tangential_time: float | None = None

    def over(self, other: ContactLaw) -> ContactLaw:
        """Return this law, and of another one what this one does not say."""
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        own = {name: value for name, value in own.items() if value is not None}
        if "stiffness" in own and "material" not in own:  # the last word decides which it is
            other = replace(other, material=None)
        if "material" in own and "stiffness" not in own:
            other = replace(other, stiffness=None)
        return replace(other, **own)


@dataclass(frozen=True)
class BodyContact:
    """Whether a body can touch anything, and what its own law says."""

    possible: bool = True
    law: ContactLaw = ContactLaw()


def read_contact(reader: Reader, materials: Mapping[str, Material]) -> ContactLaw:
    """Read the keys of a ``contact``."""
    reader.only(*KEYS)
    if reader.has("stiffness"):
        reader.no_effect("material", "the stiffness is given")
    name = (
        reader.reference("material", materials, "material", default=None)
        if (reader.has("material"))
        else None
    )
    return ContactLaw(
        stiffness=reader.number("stiffness", POSITIVE, default=None),
        material=None if name is None else materials[name],
        onset=reader.number("onset", NONNEGATIVE, default=None),
        dissipation=reader.number("dissipation", NONNEGATIVE, default=None),
        friction=_read_friction(reader) if reader.has("friction") else None,
        tangential_stiffness=reader.number("tangential_stiffness", POSITIVE, default=None),
        tangential_time=reader.number("tangential_time", NONNEGATIVE, default=None),
    )


def _read_friction(reader: Reader) -> Friction:
    if not reader.is_mapping("friction"):
        both = float(reader.number("friction", NONNEGATIVE))
        return Friction(both, both, both)
    own = reader.mapping("friction").only("static", "kinetic", "across")
    kinetic = float(own.number("kinetic", NONNEGATIVE))
    static = float(own.number("static", NONNEGATIVE, default=kinetic))
    across = float(own.number("across", NONNEGATIVE, default=kinetic))
    if static < kinetic:
        own.refuse(f"a number >= kinetic = {kinetic:g}: sliding holds less than sticking", "static")
    if kinetic == 0.0 and (across > 0.0 or static > 0.0):
        own.refuse("a number > 0, or no friction at all", "kinetic")
    return Friction(static, kinetic, across)


def read_body_contact(reader: Reader, materials: Mapping[str, Material]) -> BodyContact:
    """Read the ``contact`` of a body: ``false``, or a mapping."""
    if not reader.has("contact"):
        return BodyContact()
    if reader.is_mapping("contact"):
        return BodyContact(True, read_contact(reader.mapping("contact"), materials))
    written = reader.choice("contact", ("true", "false"))
    return BodyContact(written == "true")
