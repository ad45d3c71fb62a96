"""Topics and messages of sensors, and what was recorded of them.

A reading that no standard message is made for goes out as a JointState: it has a stamp, and a name
for every number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Protocol

import numpy as np

from soft_sim_ros.core.simulation.reading import Reading
from soft_sim_ros.recording.cdr import JointStateBuffer, WrenchStampedBuffer
from soft_sim_ros.recording.cdr_imu import ImuBuffer
from soft_sim_ros.recording.topics import IMU, JOINTS, SENSORS, WRENCH, Topic
from soft_sim_ros.scene import Sensor
from soft_sim_ros.scene import sensor as kinds

TYPES = {kinds.IMU: IMU, kinds.WRENCH: WRENCH}  # of the kinds with a message of their own


class Watched(Protocol):
    """What SensorMessages needs of a ``Simulation``."""

    @property
    def time_ns(self) -> int:
        """Simulation time in ns."""

    def sensors(self) -> dict[str, Reading]:
        """Give the newest reading of every sensor."""


def sensor_key(name: str) -> str:
    """Give the key of a sensor's topic."""
    return f"{SENSORS}/{name}"


def sensor_topics(prefix: str, sensors: Sequence[Sensor]) -> tuple[Topic, ...]:
    """Give the topics of the sensors of the node called ``prefix``: ``~/sensors/NAME``."""
    return tuple(
        Topic(sensor_key(one.name), f"{prefix}/{SENSORS}/{one.name}", TYPES.get(one.kind, JOINTS))
        for one in sensors
    )


def sensor_frame(prefix: str, name: str) -> str:
    """Give the frame of a sensor: the name of its topic, without the first slash."""
    return f"{prefix.lstrip('/')}/{SENSORS}/{name}"


class SensorMessages:
    """Bytes of the messages of all sensors of a simulation.

    Parameters
    ----------
    simulation : what is watched
    sensors : those of its scene
    prefix : full name of the node, such as ``/arm1/soft_arm``
    offset_ns : gives what lies between simulation time and stamps

    Attributes
    ----------
    topics : what there is
    builders : key of a topic → builds the message of the newest reading
    """

    def __init__(
        self,
        simulation: Watched,
        sensors: Sequence[Sensor],
        prefix: str,
        offset_ns: Callable[[], int] = lambda: 0,
    ) -> None:
        self.topics = sensor_topics(prefix, sensors)
        self._simulation, self._offset_ns = simulation, offset_ns
        self._buffers = {one.name: _buffer(one, sensor_frame(prefix, one.name)) for one in sensors}
        self.builders: dict[str, Callable[[], bytes]] = {
            sensor_key(one.name): partial(self.message, one.name) for one in sensors
        }
        self._given: dict[str, object] = {}

    def message(self, name: str) -> bytes:
        """Give the message of the newest reading of a sensor, stamped when it was measured."""
        return self._message(self._simulation.sensors()[name])

    def new(self) -> Iterator[tuple[str, bytes]]:
        """Yield key and message of readings that got out just now, each once."""
        now = self._simulation.time_ns
        for name, reading in self._simulation.sensors().items():
            if reading.delivered_ns == now and reading.values is not self._given.get(name):
                self._given[name] = reading.values
                yield sensor_key(name), self._message(reading)

    def newest(self) -> Iterator[tuple[str, bytes]]:
        """Yield key and message of the newest reading of every sensor that has one."""
        for name, reading in self._simulation.sensors().items():
            if reading.time_ns is not None:
                yield sensor_key(name), self._message(reading)

    def _message(self, reading: Reading) -> bytes:
        stamp = max(0, (reading.time_ns or 0) + self._offset_ns())
        return self._buffers[reading.name](stamp, reading.values)


def _buffer(sensor: Sensor, frame_id: str) -> Callable[[int, np.ndarray], bytes]:
    """Return what makes the message of a sensor of a stamp and numbers."""
    if sensor.kind == kinds.IMU:
        return ImuBuffer(frame_id, np.delete(sensor.noise, 3)).fill
    if sensor.kind == kinds.WRENCH:
        return WrenchStampedBuffer(frame_id).fill
    if sensor.kind == kinds.TENDON:
        tendon = JointStateBuffer([sensor.of], frame_id="")
        return lambda stamp, values: tendon.fill(stamp, *values[:, None])
    if sensor.kind == kinds.ENCODER:
        names = [label.partition("/")[2] for label in sensor.labels]
        count = len(names) // 2
        angles = JointStateBuffer(names[:count], effort=False)
        return lambda stamp, values: angles.fill(stamp, values[:count], values[count:])
    gauges = JointStateBuffer(sensor.labels, velocity=False, effort=False)
    return gauges.fill
