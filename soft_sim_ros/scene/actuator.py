"""Actuators: named, work-conjugate ports. Effort × port velocity is the power into the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene.body import ROUNDING, Body, Rod
from soft_sim_ros.scene.interval import ANY, FINITE, NONNEGATIVE, Interval
from soft_sim_ros.scene.joint import Joint
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats
from soft_sim_ros.scene.tendon import HelicalPath, StraightPath, read_path

ANGULAR = ("torsion", "bend_y", "bend_z")
LIMITS = ("limits", "safe")


@dataclass(frozen=True)
class MomentActuator:
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
    def unit(self) -> str:
        """Unit of the effort."""
        return "N·m" if self.strain in ANGULAR else "N"


@dataclass(frozen=True)
class JointActuator:
    """A torque about, or a force along, an axis of a joint.

    Its port position is the joint's coordinate of that axis: an angle in rad, a path in m.
    """

    name: str
    limits: tuple[float, float]
    safe: float
    joint: str
    axis: int = 0
    unit: str = "N·m"


@dataclass(frozen=True)
class TendonActuator:
    """A tendon, fixed at arc length ``end`` of a rod and pulled where it enters, at ``start``.

    Positive effort is tension. Its port velocity is the rate at which the tendon inside the rod
    gets shorter, in m/s. Arc lengths in m along the rod.
    """

    name: str
    limits: tuple[float, float]
    safe: float
    rod: str
    start: float
    end: float
    path: StraightPath | HelicalPath

    @property
    def unit(self) -> str:
        """Unit of the effort."""
        return "N"

    def offset(self, s: Floats) -> Floats:
        """Return where the tendon runs, d (…, 3) in m in the section frame, d_x = 0."""
        return self.path.offset(self._fraction(s))

    def slope(self, s: Floats) -> Floats:
        """Return d' = dd/ds (…, 3)."""
        return self.path.slope(self._fraction(s)) / (self.end - self.start)

    def _fraction(self, s: Floats) -> Floats:
        return (np.asarray(s, dtype=float) - self.start) / (self.end - self.start)


Actuator = MomentActuator | JointActuator | TendonActuator


def read_actuators(entries: list[Reader], bodies: tuple[Body, ...]) -> tuple[Actuator, ...]:
    """Read ``actuators``; their order is the order of the efforts in a command."""
    rods = {body.name: body for body in bodies if isinstance(body, Rod)}
    joints = {body.name: body for body in bodies if isinstance(body, Joint)}
    actuators: list[Actuator] = []
    for reader in entries:
        kind = reader.one_of(("moment", "joint_torque", "joint_force", "tendon"))
        name = reader.name(kind, taken={actuator.name for actuator in actuators})
        if kind == "moment":
            actuators.append(_read_moment(reader, name, rods))
        elif kind in ("joint_torque", "joint_force"):
            actuators.append(_read_joint_actuator(reader, kind, name, joints))
        else:
            actuators.append(_read_tendon(reader, name, rods))
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
    driven = [joint.name for joint in joints.values() if joint.kind in kinds]
    joint = joints[reader.reference("joint", driven, f"{' or '.join(kinds)} joint")]
    axis = 0
    if joint.kind == "universal":
        axis = ("first", "second").index(reader.choice("axis", ("first", "second")))
    else:
        reader.no_effect("axis", f"a {joint.kind} joint has one axis")
    unit = "N·m" if turns else "N"
    return JointActuator(name, *_read_limits(reader), joint.name, axis, unit)


def _read_tendon(reader: Reader, name: str, rods: dict[str, Rod]) -> TendonActuator:
    reader.only("tendon", "rod", "start", "end", "offset", "helix", *LIMITS)
    rod = rods[reader.reference("rod", rods, "rod")]
    start, end = read_span(reader, rod)
    path = read_path(reader, end - start)
    limits, safe = _read_limits(reader, tension=True)
    return TendonActuator(name, limits, safe, rod.name, start, end, path)


def read_arc_length(reader: Reader, key: str, rod: Rod, default: float) -> float:
    """Read an arc length along a rod in m."""
    inside = Interval(0.0, rod.length * (1.0 + ROUNDING), True, True)
    return rod.snap(reader.number(key, inside, default))


def read_span(reader: Reader, rod: Rod) -> tuple[float, float]:
    """Read ``start`` and ``end`` along a rod in m; by default the whole rod."""
    start = read_arc_length(reader, "start", rod, default=0.0)
    end = read_arc_length(reader, "end", rod, default=rod.length)
    if not start < end:
        wrong = "start" if reader.has("start") else "end"
        reader.refuse(f"start < end, they are {start:g} and {end:g}", wrong)
    return start, end


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
