"""Bodies of the chain, base to tip: rods, joints and rigid bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene.interval import NONNEGATIVE, POSITIVE
from soft_sim_ros.scene.joint import Joint, read_joint
from soft_sim_ros.scene.material import Material
from soft_sim_ros.scene.pose import IDENTITY, Pose, read_pose
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.rod_model import COSSERAT, MODELS, RodModel
from soft_sim_ros.scene.section import Section, read_section
from soft_sim_ros.scene.taper import Floats

ROUNDING = 1e-9  # of the length of a rod


@dataclass(frozen=True)
class Rod:
    """An elastic rod that leaves the frame before it along that frame's x axis.

    ``strains`` are the components that can change, in the order of STRAINS: those of its model,
    or some of them. The others keep their reference values.
    """

    name: str
    strains: tuple[str, ...]
    sections: tuple[Section, ...]
    model: RodModel = COSSERAT

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
class RigidBody:
    """A mass fixed to the frame before it; the chain goes on from that same frame.

    mass in kg; inertia (3,) principal moments in kg·m² about the centre of mass, along the axes
    of the frame ``com`` (whose origin is the centre of mass).
    """

    name: str
    mass: float
    inertia: Floats
    com: Pose = IDENTITY


Body = Rod | Joint | RigidBody


def read_bodies(entries: list[Reader], materials: dict[str, Material]) -> tuple[Body, ...]:
    """Read the chain, base to tip."""
    bodies: list[Body] = []
    taken: set[str] = set()
    for reader in entries:
        kind = reader.one_of(("rod", "joint", "rigid_body"))
        name = reader.name(kind, taken=taken)
        taken.add(name)
        if kind == "rod":
            bodies.append(_read_rod(reader, name, materials))
        elif kind == "joint":
            joint = read_joint(reader, name)
            if joint.kind == "free" and bodies:
                reader.refuse("a free joint only as the first of the bodies", "kind")
            bodies.append(joint)
        else:
            bodies.append(_read_rigid_body(reader, name))
    return tuple(bodies)


def _read_rod(reader: Reader, name: str, materials: dict[str, Material]) -> Rod:
    reader.only("rod", "model", "strains", "sections")
    model = MODELS[reader.choice("model", MODELS, default="cosserat")]
    strains = reader.choices("strains", model.strains)
    sections: list[Section] = []
    for entry in reader.entries("sections", required=True):
        taken = {section.name for section in sections}
        sections.append(read_section(entry, materials, model, strains, taken))
    rod = Rod(name, strains, tuple(sections), model)
    if not np.isfinite(rod.length):
        reader.refuse("sections of a finite length together", "sections")
    return rod


def _read_rigid_body(reader: Reader, name: str) -> RigidBody:
    reader.only("rigid_body", "mass", "inertia", "com")
    mass = reader.number("mass", POSITIVE)
    inertia = reader.vector("inertia", 3, NONNEGATIVE, default=(0, 0, 0))
    largest = float(inertia.max())
    if largest > (inertia.sum() - largest) * (1 + 1e-9):
        reader.refuse("principal moments none of which exceeds the sum of the others", "inertia")
    return RigidBody(name, mass, inertia, read_pose(reader.mapping("com")))
