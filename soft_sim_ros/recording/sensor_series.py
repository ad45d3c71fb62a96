"""Readings of sensors over time, as read from a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.recording.decode import Stack
from soft_sim_ros.recording.metadata import Channel
from soft_sim_ros.recording.series import Floats, Series
from soft_sim_ros.recording.topics import IMU, JOINTS, OUTPUTS, SENSORS, WRENCH, resolve
from soft_sim_ros.scene import sensor as kinds
from soft_sim_ros.scene.sensor import QUANTITIES
from soft_sim_ros.scene.words import NAME

KINDS = (IMU, WRENCH, JOINTS)


@dataclass(frozen=True)
class SensorSeries(Series):
    """Readings of one sensor; ``series["acceleration"]`` is what belongs to a quantity.

    ``time_ns`` is when they got out of the sensor.

    Parameters
    ----------
    measured_ns : (T,) stamps: time in ns at which each was measured
    frame_id : of the sensor; empty for those that are in none
    labels : (W,) names of the numbers, ``quantity`` or ``quantity/component``
    values : (T, W) the numbers, torque before force
    """

    measured_ns: NDArray[np.int64]
    frame_id: str
    labels: tuple[str, ...]
    values: Floats

    @property
    def measured(self) -> Floats:
        """Time (T,) in s at which each was measured."""
        return self.measured_ns / 1e9

    def __getitem__(self, quantity: str) -> Floats:
        """Give a quantity (T,), a component of it (T,), or all components (T, k)."""
        if quantity in self.labels:
            return self.values[:, self.labels.index(quantity)]
        columns = [i for i, x in enumerate(self.labels) if x.startswith(f"{quantity}/")]
        if not columns:
            known = ", ".join(dict.fromkeys(x.split("/")[0] for x in self.labels))
            raise KeyError(f"{quantity!r} is not in the readings; they have {known}")
        return self.values[:, columns]


def find_sensors(channels: Sequence[Channel], node: str | None) -> dict[str, int]:
    """Map names of sensors to the channels that carry their readings: ``NODE/sensors/NAME``.

    node : full name of the node; None: any that publishes what else an arm does
    """
    topics = {channel.topic for channel in channels}
    found = {}
    for index, channel in enumerate(channels):
        above, _, name = channel.topic.rpartition("/")
        owner, _, last = above.rpartition("/")
        if last != SENSORS or channel.type not in KINDS or not NAME.fullmatch(name):
            continue
        if owner == node or (node is None and owner and _is_arm(owner, topics)):
            found[name] = index
    return found


def _is_arm(node: str, topics: set[str]) -> bool:
    """Return whether a node has topics below it that an arm has."""
    own = [resolve(name, node) for name, *_ in OUTPUTS.values() if name.startswith("~/")]
    own.append(resolve("~/events", node))
    return any(
        topic in topics or any(one.startswith(f"{topic}/") for one in topics) for topic in own
    )


def series_of(message_type: str, time_ns: NDArray[np.int64], content: Stack | None) -> SensorSeries:
    """Return the readings of one sensor; without any, there is not even a label."""
    if content is None:
        return SensorSeries(time_ns, time_ns, "", (), np.empty((0, 0)))
    blocks, labels = list(content.blocks), tuple(content.texts)
    if message_type == IMU:
        blocks, labels = [blocks[0], blocks[2], blocks[4]], _labels(kinds.IMU)
    elif message_type == WRENCH:
        blocks, labels = [np.roll(blocks[0], 3, axis=1)], _labels(kinds.WRENCH)
    elif blocks[2].shape[1] and len(labels) == 1:
        labels = _labels(kinds.TENDON)
    elif blocks[1].shape[1]:
        labels = tuple(f"{what}/{name}" for what in QUANTITIES[kinds.ENCODER] for name in labels)
    stamps = time_ns if content.stamps_ns is None else content.stamps_ns
    values = np.concatenate(blocks, axis=1)
    return SensorSeries(time_ns, stamps, content.frame_id, labels, values)


def _labels(kind: str) -> tuple[str, ...]:
    """Return the names of the numbers of a kind that has always the same."""
    return tuple(
        f"{quantity}/{one}" if one else quantity
        for quantity, (components, _) in QUANTITIES[kind].items()
        for one in components or ("",)
    )
