"""Bodies: rods, floating-frame links, joints and rigid bodies."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from soft_sim_ros.scene.contact import BodyContact, read_body_contact
from soft_sim_ros.scene.environment import Solid, read_solid
from soft_sim_ros.scene.fluid import BodyFluid, RodFluid
from soft_sim_ros.scene.interval import NONNEGATIVE, POSITIVE, Interval
from soft_sim_ros.scene.joint import Joint, read_joint
from soft_sim_ros.scene.material import Material
from soft_sim_ros.scene.pose import IDENTITY, Pose, read_pose
from soft_sim_ros.scene.read_fluid import read_body_fluid, read_link_fluid, read_rod_fluid
from soft_sim_ros.scene.read_section import read_section
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.reference import Reference
from soft_sim_ros.scene.rod_model import COSSERAT, MODELS, RodModel
from soft_sim_ros.scene.section import Section
from soft_sim_ros.scene.taper import Floats

LINK_TIPS = ("free", "pinned")
MODES = 30  # of a floating-frame link, at most
ROUNDING = 1e-9  # of the length of a rod


@dataclass(frozen=True)
class Rod:
    """An elastic rod that leaves the frame it is attached to along that frame's x axis.

    ``strains`` are the components that can change, in the order of STRAINS: those of its model,
    or some of them. The others keep their reference values.
    """

    name: str
    strains: tuple[str, ...]
    sections: tuple[Section, ...]
    model: RodModel = COSSERAT
    fluid: RodFluid = field(default_factory=RodFluid)
    contact: BodyContact = BodyContact()  # noqa: RUF009 - it is immutable

    @property
    def length(self) -> float:
        """Reference length in m."""
        return self.boundaries[-1]

    @property
    def boundaries(self) -> tuple[float, ...]:
        """Arc lengths in m where sections begin and end: 0, …, length."""
        ends = [0.0]
        for section in self.sections:
            ends.append(ends[-1] + section.length)
        return tuple(ends)

    def snap(self, s: float) -> float:
        """Return the section boundary that an arc length means, else the arc length itself.

        0.2 + 0.2 + 0.2 is not 0.6 in floating-point numbers; a rod must not get a slice of that
        thickness.
        """
        nearest = min(self.boundaries, key=lambda boundary: abs(boundary - s))
        return nearest if abs(nearest - s) <= ROUNDING * self.length else s

    def section(self, name: str) -> Section:
        """Return the section of a name."""
        return next(section for section in self.sections if section.name == name)


@dataclass(frozen=True, eq=False)
class FlexibleLink:
    """A straight elastic rod that moves as a rigid body plus ``modes`` linear modes.

    Boyer & Primault 2005 (3.25).

    Modes are those of the rod clamped at its start, the lowest ``modes`` of all, or the lowest of
    each kind (torsion, bend_y, bend_z, stretch); ``tip``: free, or held in place (pinned);
    tip_mass in kg is a mass at the tip that the modes (not the link) are computed with.
    rotary_inertia: whether sections turn with the modes; else their inertia turns with the frame.
    """

    name: str
    rod: Rod
    modes: int
    each: dict[str, int] | None = None
    tip: str = "free"
    tip_mass: float = 0.0
    rotary_inertia: bool = False

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the modal coordinates; their unit is m."""
        return tuple(f"{self.name}/mode/{i}" for i in range(self.modes))


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A mass fixed to the frame before it; the chain goes on from that same frame.

    mass in kg; inertia (3,) principal moments in kg·m² about the centre of mass, along the axes
    of the frame ``com`` (whose origin is the centre of mass). attached: of a payload, which can be
    attached and dropped while the arm moves, whether it is there at first; None: it always is;
    shape: what it touches with.
    """

    name: str
    mass: float
    inertia: Floats
    com: Pose = IDENTITY
    attached: bool | None = None
    fluid: BodyFluid | None = None
    shape: Solid | None = None
    contact: BodyContact = BodyContact()  # noqa: RUF009 - it is immutable


Body = Rod | FlexibleLink | Joint | RigidBody


def read_bodies(entries: list[Reader], materials: dict[str, Material]) -> list[Body]:
    """Read ``bodies`` in the order of the list; where they are attached is read_forest.py's."""
    bodies: list[Body] = []
    taken: set[str] = set()
    for reader in entries:
        kind = reader.one_of(("rod", "flexible_link", "joint", "rigid_body"))
        name = reader.name(kind, taken=taken)
        taken.add(name)
        if kind == "rod":
            reader.only("rod", "parent", "model", "strains", "sections", "fluid", "contact")
            rod = _read_rod(reader, name, materials)
            bodies.append(replace(rod, fluid=read_rod_fluid(reader, ends=True)))
        elif kind == "flexible_link":
            bodies.append(_read_flexible_link(reader, name, materials))
        elif kind == "joint":
            bodies.append(read_joint(reader, name))
        else:
            bodies.append(_read_rigid_body(reader, name, materials))
    return bodies


def _read_rod(reader: Reader, name: str, materials: dict[str, Material]) -> Rod:
    model = MODELS[reader.choice("model", MODELS, default="cosserat")]
    strains = reader.choices("strains", model.strains)
    sections: list[Section] = []
    for entry in reader.entries("sections", required=True):
        taken = {section.name for section in sections}
        sections.append(read_section(entry, materials, model, strains, taken))
    contact = read_body_contact(reader, materials)
    rod = Rod(name, strains, tuple(sections), model, contact=contact)
    if not np.isfinite(rod.length):
        reader.refuse("sections of a finite length together", "sections")
    return rod


def _read_flexible_link(reader: Reader, name: str, materials: dict[str, Material]) -> FlexibleLink:
    reader.only(
        "flexible_link",
        "contact",
        "parent",
        "strains",
        "sections",
        "modes",
        "tip",
        "tip_mass",
        "rotary_inertia",
        "fluid",
    )
    read_link_fluid(reader)
    rod = _read_rod(reader, name, materials)
    for entry, section in zip(reader.entries("sections"), rod.sections, strict=True):
        if section.reference != Reference():
            entry.refuse("no reference shape: a flexible link is straight", "reference")
        if section.material.law is not None:
            entry.refuse("a material without law: modes are linear", "material")
        entry.no_effect("coupling", "modes of a flexible link are of one kind each")
        if section.material.maxwell != rod.sections[0].material.maxwell:
            entry.refuse("one Maxwell branch for all sections of a flexible link", "material")
    twists = "torsion" in rod.strains
    rotary = reader.choice("rotary_inertia", ("true", "false"), default=str(twists).lower())
    if twists and rotary == "false":
        reader.refuse("true: torsion moves nothing but rotary inertia", "rotary_inertia")
    each = None
    if reader.is_mapping("modes"):
        kinds = reader.mapping("modes").only(*(x for x in rod.strains if "shear" not in x))
        each = {kind: kinds.whole(kind, Interval.parse("[0, 30]")) for kind in kinds.keys()}
        if not 0 < sum(each.values()) <= MODES:
            reader.refuse(f"1 to {MODES} modes in all", "modes")
    return FlexibleLink(
        name,
        rod,
        modes=sum(each.values()) if each else reader.whole("modes", Interval(1, MODES, True, True)),
        each=each,
        tip=reader.choice("tip", LINK_TIPS, default="free"),
        tip_mass=reader.number("tip_mass", NONNEGATIVE, default=0.0),
        rotary_inertia=rotary == "true",
    )


def _read_rigid_body(reader: Reader, name: str, materials: dict[str, Material]) -> RigidBody:
    reader.only(
        "rigid_body", "parent", "mass", "inertia", "com", "attached", "fluid", "shape", "contact"
    )
    mass = reader.number("mass", POSITIVE)
    inertia = reader.vector("inertia", 3, NONNEGATIVE, default=(0, 0, 0))
    largest = float(inertia.max())
    if largest > (inertia.sum() - largest) * (1 + 1e-9):
        reader.refuse("principal moments none of which exceeds the sum of the others", "inertia")
    attached = None
    if reader.has("attached"):
        attached = reader.choice("attached", ("true", "false")) == "true"
        for key in ("fluid", "shape"):
            reader.no_effect(key, "a payload comes and goes: it has mass and nothing else")
    com = read_pose(reader.mapping("com"))
    fluid, shape = read_body_fluid(reader, com), read_solid(reader)
    touch = read_body_contact(reader, materials)
    return RigidBody(name, mass, inertia, com, attached, fluid, shape, touch)
