"""Sensors: what is measured, where, how often, and how badly.

A sensor reads the motion and never changes it.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from soft_sim_ros.scene.actuator import Actuator, TendonActuator
from soft_sim_ros.scene.body import Body, FlexibleLink, Rod
from soft_sim_ros.scene.interval import FINITE, NONNEGATIVE, POSITIVE, Interval
from soft_sim_ros.scene.joint import AXES, Joint
from soft_sim_ros.scene.pose import IDENTITY, Pose, read_pose
from soft_sim_ros.scene.read_route import read_arc_length
from soft_sim_ros.scene.reader import Reader, frozen
from soft_sim_ros.scene.taper import Floats

if TYPE_CHECKING:
    from fractions import Fraction

STRAIN, CURVATURE, IMU = "strain", "curvature", "imu"
WRENCH, TENDON, ENCODER = "wrench", "tendon", "encoder"
# kind → quantities, each with the components that it has and its unit
QUANTITIES: dict[str, dict[str, tuple[tuple[str, ...], str]]] = {
    STRAIN: {"strain": ((), "1")},
    CURVATURE: {"curvature": (("torsion", "bend_y", "bend_z"), "rad/m")},
    IMU: {
        "orientation": (("x", "y", "z", "w"), "rad"),
        "angular_velocity": (("x", "y", "z"), "rad/s"),
        "acceleration": (("x", "y", "z"), "m/s²"),
    },
    WRENCH: {"torque": (("x", "y", "z"), "N·m"), "force": (("x", "y", "z"), "N")},
    TENDON: {"length": ((), "m"), "rate": ((), "m/s"), "tension": ((), "N")},
    ENCODER: {"position": ((), "rad or m"), "velocity": ((), "rad/s or m/s")},
}
SENSOR_KINDS = tuple(QUANTITIES)
COMMON = ("rate", "noise", "bias", "seed", "latency")
RATE = 100.0  # Hz
MOST_SEED = 2**53  # larger whole numbers are not all exact
MOST_LATENCY = 3600.0  # s: readings that are on their way are kept
MOST_UNDERWAY = 100_000


@dataclass(frozen=True, eq=False)
class Sensor:
    """One sensor.

    name : among sensors
    kind : one of SENSOR_KINDS
    of : the rod, body, joint or actuator that it is on
    s : (P,) arc lengths in m along a rod or link; (0,) elsewhere
    place : pose of an IMU in the frame there; of a strain gauge ``position`` is where it sits in
        the cross-section (x = 0)
    direction : (3,) unit vector along which a strain gauge measures, in the axes of the section
    labels : names of all numbers of a reading, in their order: ``quantity`` or
        ``quantity/component``
    noise, bias : by number (W,) in the unit of the quantity; those of an orientation, in rad about
        the axes of the sensor, are the first three of its four
    rate : readings per second, Hz
    seed : of the noise
    latency : s after which a reading is there
    """

    name: str
    kind: str
    of: str
    s: tuple[float, ...]
    place: Pose
    direction: Floats
    labels: tuple[str, ...]
    noise: Floats
    bias: Floats
    rate: float
    seed: int
    latency: float

    @property
    def exact_rate(self) -> Fraction:
        """The rate as it is written, in Hz."""
        from fractions import Fraction  # scenes without sensors need not load it

        return Fraction(repr(self.rate))

    @property
    def framed(self) -> bool:
        """Whether its readings are given along the axes of a frame of its own."""
        return self.kind in (IMU, WRENCH)

    @property
    def stream(self) -> int:
        """A number of 64 bits for the name: sensors of one seed have noise of their own."""
        return int.from_bytes(hashlib.sha256(self.name.encode()).digest()[:8], "little")

    def columns(self, quantity: str) -> list[int]:
        """Return which numbers of a reading belong to a quantity, or are it."""
        return [
            i
            for i, label in enumerate(self.labels)
            if label == quantity or label.startswith(f"{quantity}/")
        ]


def read_sensors(
    entries: list[Reader], bodies: tuple[Body, ...], actuators: tuple[Actuator, ...]
) -> tuple[Sensor, ...]:
    """Read ``sensors``."""
    found: list[Sensor] = []
    by_name = {body.name: body for body in bodies}
    for reader in entries:
        kind = reader.one_of(SENSOR_KINDS)
        name = reader.name(kind, taken={one.name for one in found})
        found.append(_READ[kind](reader, name, by_name, actuators))
    return tuple(found)


def _read_strain(
    reader: Reader, name: str, bodies: dict[str, Body], _: tuple[Actuator, ...]
) -> Sensor:
    reader.only(STRAIN, "rod", "s", "offset", "direction", *COMMON)
    rod = _rod(reader, bodies)
    s = (read_arc_length(reader, "s", rod, default=0.5 * rod.length),)
    y, z = reader.vector("offset", 2, default=(0.0, 0.0)).tolist()
    place = Pose(frozen((0.0, y, z)), IDENTITY.quaternion)
    direction = reader.vector("direction", 3, default=(1.0, 0.0, 0.0))
    norm = float(np.linalg.norm(direction))
    if not 1e-100 < norm < 1e100:
        reader.refuse(f"a direction, not a vector of length {norm:g}", "direction")
    return _made(reader, name, STRAIN, rod.name, s, place, direction / norm)


def _read_curvature(
    reader: Reader, name: str, bodies: dict[str, Body], _: tuple[Actuator, ...]
) -> Sensor:
    reader.only(CURVATURE, "rod", "s", *COMMON)
    rod = _rod(reader, bodies)
    if not reader.is_list("s"):
        s = (read_arc_length(reader, "s", rod, default=0.5 * rod.length),)
        return _made(reader, name, CURVATURE, rod.name, s)
    inside = Interval(0.0, rod.length, True, True)
    places = reader.numbers("s", inside)
    if not len(places):
        reader.refuse("at least one arc length in m", "s")
    return _made(reader, name, CURVATURE, rod.name, tuple(map(rod.snap, places.tolist())))


def _read_imu(
    reader: Reader, name: str, bodies: dict[str, Body], _: tuple[Actuator, ...]
) -> Sensor:
    reader.only(IMU, "body", "s", "offset", *COMMON)
    body = bodies[reader.reference("body", bodies, "body")]
    rod = body.rod if isinstance(body, FlexibleLink) else body
    s: tuple[float, ...] = ()
    if isinstance(rod, Rod):
        s = (read_arc_length(reader, "s", rod, default=rod.length),)
    else:
        reader.no_effect("s", f"{body.name} is not a rod")
    return _made(reader, name, IMU, body.name, s, read_pose(reader.mapping("offset")))


def _read_wrench(
    reader: Reader, name: str, bodies: dict[str, Body], _: tuple[Actuator, ...]
) -> Sensor:
    reader.only(WRENCH, "body", *COMMON)
    fitting = [one.name for one in bodies.values() if isinstance(one, Joint | Rod)]
    return _made(reader, name, WRENCH, reader.reference("body", fitting, "joint or rod"))


def _read_tendon(
    reader: Reader, name: str, _: dict[str, Body], actuators: tuple[Actuator, ...]
) -> Sensor:
    reader.only(TENDON, "actuator", *COMMON)
    fitting = [one.name for one in actuators if isinstance(one, TendonActuator)]
    return _made(reader, name, TENDON, reader.reference("actuator", fitting, "tendon"))


def _read_encoder(
    reader: Reader, name: str, bodies: dict[str, Body], _: tuple[Actuator, ...]
) -> Sensor:
    reader.only(ENCODER, "joint", *COMMON)
    joints = {b.name: b for b in bodies.values() if isinstance(b, Joint) and b.kind in AXES}
    what = "revolute, prismatic or universal joint"
    joint = joints[reader.reference("joint", joints, what)]
    return _made(reader, name, ENCODER, joint.name, parts=joint.coordinates)


_READ = {
    STRAIN: _read_strain,
    CURVATURE: _read_curvature,
    IMU: _read_imu,
    WRENCH: _read_wrench,
    TENDON: _read_tendon,
    ENCODER: _read_encoder,
}


def _rod(reader: Reader, bodies: dict[str, Body]) -> Rod:
    rods = {name: body for name, body in bodies.items() if isinstance(body, Rod)}
    return rods[reader.reference("rod", rods, "rod")]


def _made(
    reader: Reader,
    name: str,
    kind: str,
    of: str,
    s: tuple[float, ...] = (),
    place: Pose = IDENTITY,
    direction: Floats = IDENTITY.position,
    parts: tuple[str, ...] = (),
) -> Sensor:
    """Return a sensor with what all of them have; ``parts`` are coordinates of an encoder."""
    labels = _labels(kind, len(s), parts)
    rate = reader.number("rate", POSITIVE, default=RATE)
    latency = reader.number("latency", Interval(0.0, MOST_LATENCY, True, True), default=0.0)
    if rate * latency > MOST_UNDERWAY:
        reader.refuse(
            f"at most {MOST_UNDERWAY / rate:g} s at {rate:g} Hz: readings that are on their way "
            "are kept",
            "latency",
        )
    direction = direction.copy()
    direction.setflags(write=False)
    return Sensor(
        name=name,
        kind=kind,
        of=of,
        s=s,
        place=place,
        direction=direction,
        labels=labels,
        noise=_amounts(reader, "noise", kind, labels, NONNEGATIVE),
        bias=_amounts(reader, "bias", kind, labels, FINITE),
        rate=rate,
        seed=reader.whole("seed", Interval(0, MOST_SEED, True, True), default=0),
        latency=latency,
    )


def _labels(kind: str, places: int, parts: tuple[str, ...]) -> tuple[str, ...]:
    if kind == CURVATURE and places > 1:
        components = QUANTITIES[kind]["curvature"][0]
        return tuple(f"curvature/{i}/{one}" for i in range(places) for one in components)
    return tuple(
        f"{quantity}/{one}" if one else quantity
        for quantity, (components, _) in QUANTITIES[kind].items()
        for one in (parts or components or ("",))
    )


def _amounts(
    reader: Reader, key: str, kind: str, labels: tuple[str, ...], within: Interval
) -> Floats:
    """Read ``noise`` or ``bias``: a number where there is one quantity, else a mapping by it."""
    out = np.zeros(len(labels))
    quantities = list(QUANTITIES[kind])
    if reader.has(key) and reader.is_mapping(key):
        own = reader.mapping(key).only(*quantities)
        for quantity in own.keys():
            columns = [i for i, label in enumerate(labels) if label.split("/")[0] == quantity]
            if quantity == "orientation":
                columns = columns[:3]  # about three axes
            if own.is_list(quantity):
                out[columns] = own.vector(quantity, len(columns), within)
            else:
                out[columns] = own.number(quantity, within)
    elif reader.has(key):
        if len(quantities) > 1:
            expected = f"a mapping: {', '.join(quantities)}, each in a unit of its own"
            reader.refuse(expected, key)
        out[:] = (
            reader.vector(key, len(labels), within)
            if reader.is_list(key)
            else reader.number(key, within)
        )
    out.setflags(write=False)
    return out
