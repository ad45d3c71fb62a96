"""Actuators: named, work-conjugate ports. Effort × port velocity is the power into the arm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from soft_sim_ros.scene.attachment import Forest
from soft_sim_ros.scene.body import Rod
from soft_sim_ros.scene.interval import ANY, FINITE, NONNEGATIVE, POSITIVE
from soft_sim_ros.scene.joint import Joint
from soft_sim_ros.scene.read_route import read_lane, read_route
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.tendon import PATHS, Routed

ANGULAR = ("torsion", "bend_y", "bend_z")
LIMITS = ("limits", "safe")
ROUTE = ("start", "end", *PATHS)
TENDON = ("axial_stiffness", "axial_damping", "friction", "slip_speed")
SLIP_SPEED = 1e-3


class Units(NamedTuple):
    """What the numbers of a port are in; effort times velocity is always a power in W."""

    command: str
    effort: str
    position: str
    velocity: str


TURNING = Units("N·m", "N·m", "rad", "rad/s")
PULLING = Units("N", "N", "m", "m/s")
BY_LENGTH = Units("m", "N", "m", "m/s")
PRESSING = Units("Pa", "Pa", "m³", "m³/s")


class Port:
    """What all actuators have."""

    @property
    def units(self) -> Units:
        """Units of the command, and of the port that it drives."""
        raise NotImplementedError

    @property
    def unit(self) -> str:
        """Unit of the command."""
        return self.units.command


@dataclass(frozen=True)
class MomentActuator(Port):
    """An internal wrench component, constant along a section, that drives one of its strains.

    Its port velocity is the integral of the strain rate along the section: rad/s for a moment
    in N·m, m/s for a force in N.
    """

    name: str
    limits: tuple[float, float]
    safe: float
    rod: str
    section: str
    strain: str

    @property
    def units(self) -> Units:
        """A moment turns a section's end, a force draws it out."""
        return TURNING if self.strain in ANGULAR else PULLING


@dataclass(frozen=True)
class JointActuator(Port):
    """A torque about, or a force along, an axis of a joint.

    Its port position is the joint's coordinate of that axis: an angle in rad, a path in m.
    """

    name: str
    limits: tuple[float, float]
    safe: float
    joint: str
    axis: int = 0
    turns: bool = True

    @property
    def units(self) -> Units:
        """A torque turns, a force shifts."""
        return TURNING if self.turns else PULLING


@dataclass(frozen=True)
class TendonActuator(Routed, Port):
    """A tendon, fixed where its path ends and pulled where it enters, at the start of the path.

    Its port velocity is the rate at which the tendon inside the rod gets shorter, in m/s, its
    effort the tension at the entry in N. A command is that tension (``control`` tension), or by
    how much in m the tendon is pulled in beyond its length in the reference shape (length): it
    then pulls as a spring of the tendon's own axial stiffness in N (tension per strain) and
    damping in N·s, if it is taut. ``friction``: Coulomb's coefficient in the channel, rounded off
    below ``slip_speed`` in m/s.
    """

    control: str = "tension"
    axial_stiffness: float = 0.0
    axial_damping: float = 0.0
    friction: float = 0.0
    slip_speed: float = SLIP_SPEED

    @property
    def units(self) -> Units:
        """It is told a tension or a length, and pulls with a tension either way."""
        return BY_LENGTH if self.control == "length" else PULLING


@dataclass(frozen=True)
class ChamberActuator(Routed, Port):
    """A pressure chamber of constant cross-sectional ``area`` in m², along a stretch of a rod.

    Effort is pressure above ambient in Pa; the port velocity is the rate of change of its volume,
    area times the length of its path, in m³/s.
    """

    area: float

    @property
    def units(self) -> Units:
        """A pressure makes a volume."""
        return PRESSING


Actuator = MomentActuator | JointActuator | TendonActuator | ChamberActuator


def read_actuators(entries: list[Reader], forest: Forest) -> tuple[Actuator, ...]:
    """Read ``actuators``; their order is the order of the efforts in a command."""
    bodies = forest.bodies
    rods = {body.name: body for body in bodies if isinstance(body, Rod)}
    joints = {body.name: body for body in bodies if isinstance(body, Joint)}
    actuators: list[Actuator] = []
    for reader in entries:
        kind = reader.one_of(("moment", "joint_torque", "joint_force", "tendon", "chamber"))
        name = reader.name(kind, taken={actuator.name for actuator in actuators})
        if kind == "moment":
            actuators.append(_read_moment(reader, name, rods))
        elif kind in ("joint_torque", "joint_force"):
            actuators.append(_read_joint_actuator(reader, kind, name, joints))
        elif kind == "tendon":
            actuators.append(_read_tendon(reader, name, forest))
        else:
            actuators.append(_read_chamber(reader, name, forest))
    return tuple(actuators)


def _read_moment(reader: Reader, name: str, rods: dict[str, Rod]) -> MomentActuator:
    reader.only("moment", "rod", "section", "strain", *LIMITS)
    rod = rods[reader.reference("rod", rods, "rod")]
    section = reader.reference("section", [s.name for s in rod.sections], "section of the rod")
    strain = reader.choice("strain", [s for s in rod.strains if s not in rod.model.limp])
    return MomentActuator(name, *_read_limits(reader), rod.name, section, strain)


def _read_joint_actuator(
    reader: Reader, key: str, name: str, joints: dict[str, Joint]
) -> JointActuator:
    reader.only(key, "joint", "axis", *LIMITS)
    turns = key == "joint_torque"
    kinds = ("revolute", "universal") if turns else ("prismatic",)
    fitting = [joint.name for joint in joints.values() if joint.kind in kinds]
    joint = joints[reader.reference("joint", fitting, f"{' or '.join(kinds)} joint")]
    if joint.driven:
        reader.refuse("a joint that is not driven: no effort changes what that is told", "joint")
    axis = 0
    if joint.kind == "universal":
        axis = ("first", "second").index(reader.choice("axis", ("first", "second")))
    else:
        reader.no_effect("axis", f"a {joint.kind} joint has one axis")
    return JointActuator(name, *_read_limits(reader), joint.name, axis, turns)


def _read_tendon(reader: Reader, name: str, forest: Forest) -> TendonActuator:
    reader.only("tendon", "rod", "rods", *ROUTE, "control", *TENDON, *LIMITS)
    stretches = read_route(reader, read_lane(reader, forest))
    control = reader.choice("control", ("tension", "length"), default="tension")
    if control == "length":
        stiffness = reader.number("axial_stiffness", POSITIVE)
        damping = reader.number("axial_damping", NONNEGATIVE, default=0.0)
        limits, safe = _read_limits(reader)
    else:
        for key in ("axial_stiffness", "axial_damping"):
            reader.no_effect(key, "it is for a tendon with control: length")
        stiffness = damping = 0.0
        limits, safe = _read_limits(reader, tension=True)
    friction = reader.number("friction", NONNEGATIVE, default=0.0)
    if friction == 0.0:
        reader.no_effect("slip_speed", "it is for a tendon with friction")
    slip_speed = reader.number("slip_speed", POSITIVE, default=SLIP_SPEED)
    return TendonActuator(
        name, limits, safe, stretches,
        control, stiffness, damping, friction, slip_speed,
    )  # fmt: skip


def _read_chamber(reader: Reader, name: str, forest: Forest) -> ChamberActuator:
    reader.only("chamber", "rod", "rods", "section", *ROUTE, "area", *LIMITS)
    stretches = read_route(reader, read_lane(reader, forest))
    area = reader.number("area", POSITIVE)
    limits, safe = _read_limits(reader)
    return ChamberActuator(name, limits, safe, stretches, area)


def _read_limits(reader: Reader, tension: bool = False) -> tuple[tuple[float, float], float]:
    low, high = reader.vector("limits", 2, ANY, default=(0.0 if tension else -np.inf, np.inf))
    if not low <= high or low == np.inf or high == -np.inf:
        reader.refuse("[low, high] with low <= high", "limits")
    if tension and low < 0.0:
        reader.refuse("limits >= 0, a tendon cannot push", "limits")
    safe = reader.number("safe", NONNEGATIVE if tension else FINITE, default=0.0)
    if not low <= safe <= high:
        reader.refuse(f"a number within the limits [{low:g}, {high:g}]", "safe", value=safe)
    return (float(low), float(high)), float(safe)
