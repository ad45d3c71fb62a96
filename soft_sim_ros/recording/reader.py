"""A recording as numpy arrays."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording import topics
from soft_sim_ros.recording.axis import LOG, axis_of
from soft_sim_ros.recording.claims import words
from soft_sim_ros.recording.decode import Decoded, DecodeError, Stack, Wrench, decode, stack
from soft_sim_ros.recording.felt import contacts_of, names_in
from soft_sim_ros.recording.known import find_known
from soft_sim_ros.recording.mcap_file import RECORD_NAME
from soft_sim_ros.recording.scan import Scan, scan
from soft_sim_ros.recording.sensor_series import SensorSeries, find_sensors, series_of
from soft_sim_ros.recording.series import (
    ContactSeries,
    EnergySeries,
    JointSeries,
    PoseSeries,
    WrenchSeries,
)
from soft_sim_ros.recording.topics import Qos


class TornRecordingWarning(UserWarning):
    """A recording lacks its end; what was readable was read."""


class LoggedMessage(NamedTuple):
    """One message as it was written; time in ns, data as CDR."""

    time_ns: int
    topic: str
    type: str
    qos: Qos
    data: bytes


class Input(NamedTuple):
    """One command, wrench or event, at the time in ns at which the physics took it up."""

    time_ns: int
    key: str
    topic: str
    message: Decoded


class Run:
    """A recording, read into memory; arrays are decoded when first asked for.

    Topics that were not recorded are empty series. Times are simulation times: those of the log, or
    where another program has recorded by the clock on the wall, those of the stamps in the messages
    (``axis.py``).

    Parameters
    ----------
    content : what was read of the files
    node : full name of the node, if the recording holds more than one arm

    Attributes
    ----------
    time_axis : description of where the times come from
    """

    def __init__(self, content: Scan, node: str | None = None) -> None:
        self.path: Path = content.path
        self.torn: bool = content.torn
        self.damaged_chunks: int = content.damaged
        self.attachments: dict[str, bytes] = content.attachments
        self.metadata: dict[str, str] = content.metadata.get(RECORD_NAME, {})
        self.channels = content.channels
        self._sensors = find_sensors(self.channels, node)
        self._known = find_known(self.path, self.channels, node, frozenset(self._sensors.values()))
        ours = RECORD_NAME in content.metadata  # written by this package: by simulation time
        axis = LOG if ours else axis_of(content, self._known)
        self.time_axis: str = axis.words
        messages = axis.moved(content.messages) if len(axis.log) else content.messages
        self._messages = sorted(messages, key=lambda message: message[0])

    def __repr__(self) -> str:
        torn = ", torn" if self.torn else ""
        return (
            f"Run({str(self.path)!r}: {self.start:.9g} s to {self.end:.9g} s, "
            f"{len(self._messages)} messages{torn}, by {self.time_axis})"
        )

    # -- as arrays ----------------------------------------------------------------------------

    @cached_property
    def backbone(self) -> PoseSeries:
        """Poses along the arm: ``.poses`` (T, N, 7); of several backbones, the last one."""
        return self._last(topics.BACKBONE, self.backbones, 3)

    @cached_property
    def backbones(self) -> dict[str, PoseSeries]:
        """Poses along each backbone by its name; one alone is called ``""``."""
        return self._limbs(topics.BACKBONE, 3)

    @cached_property
    def tip_pose(self) -> PoseSeries:
        """Pose of the tip: ``.poses`` (T, 7); of several tips, the last one."""
        return self._last(topics.TIP_POSE, self.tip_poses, 2)

    @cached_property
    def tip_poses(self) -> dict[str, PoseSeries]:
        """Pose of each tip by the name of the body that ends there; one alone is called ``""``."""
        return self._limbs(topics.TIP_POSE, 2)

    @cached_property
    def joint_states(self) -> JointSeries:
        """Position, velocity and effort of every actuator."""
        return self._joints("joint_states")

    @cached_property
    def strain_state(self) -> JointSeries:
        """Generalised coordinates (position) and their rates (velocity)."""
        return self._joints("strain_state")

    @cached_property
    def sensors(self) -> dict[str, SensorSeries]:
        """Readings of each sensor by its name."""
        found = self._sensors.items()
        return {name: series_of(self.channels[i].type, *self._stacked(i)) for name, i in found}

    @cached_property
    def energy(self) -> EnergySeries:
        """Energy ledger in J; ``energy["kinetic"]`` is one of its columns."""
        time_ns, content = self._series("energy")
        if content is None:
            return EnergySeries(time_ns, (), np.empty((0, 0)))
        names = tuple(content.texts)
        if len(names) == 1:  # recordings of old have them all in one label
            names = tuple(names[0].split(","))
        values = content.blocks[0]
        if len(names) != values.shape[1]:
            names = tuple(f"energy_{index}" for index in range(values.shape[1]))
        return EnergySeries(time_ns, names, values)

    @cached_property
    def reactions(self) -> dict[str, WrenchSeries]:
        """What each constraint does to its first frame, by name, along the axes of the world."""
        found = {}
        for key in self._known:
            kind, _, name = key.partition("/")
            if kind == topics.REACTION:
                time_ns, content = self._series(key)
                frame = content.frame_id if content else ""
                # the message has the force first
                wrench = np.roll(content.blocks[0], 3, axis=1) if content else np.empty((0, 6))
                found[name] = WrenchSeries(time_ns, frame, wrench)
        return found

    @cached_property
    def contacts(self) -> ContactSeries:
        """What touched; ``contacts.resultant(body, other)`` sums it up."""
        index = self._known.get(topics.CONTACTS, -1)
        chosen = [(time_ns, data) for time_ns, at, data in self._messages if at == index]
        clouds = []
        for time_ns, data in chosen:
            try:
                clouds.append((time_ns, decode(topics.CLOUD, data)))
            except DecodeError as reason:
                topic = self.channels[index].topic
                why = f"cannot be decoded on {topic}: {reason}"
                raise RecordingError(self.path, why) from reason
        return contacts_of(clouds, *names_in(self.scene_text if chosen else None))

    # -- what came from outside ---------------------------------------------------------------

    @cached_property
    def inputs(self) -> list[Input]:
        """Everything that changed the motion, in the order in which it did."""
        kinds = {*topics.COMMANDS, *topics.EVENTS}
        known = self._known.items()
        names = {index: key for key, index in known if key.partition("/")[0] in kinds}
        found = []
        for time_ns, index, data in self._messages:
            if index in names:
                channel = self.channels[index]
                message = self._decoded(channel.type, data)
                found.append(Input(time_ns, names[index], channel.topic, message))
        return found

    @property
    def commands(self) -> list[Input]:
        """Effort commands, by array or by name."""
        return [entry for entry in self.inputs if entry.key in ("command", "joint_command")]

    @property
    def wrenches(self) -> list[tuple[int, Wrench]]:
        """External wrenches: (time in ns, wrench)."""
        return [
            (entry.time_ns, entry.message)
            for entry in self.inputs
            if isinstance(entry.message, Wrench)
        ]

    @property
    def events(self) -> list[tuple[int, str]]:
        """Events such as ``reset``: (time in ns, text)."""
        return [
            (entry.time_ns, entry.message)
            for entry in self.inputs
            if isinstance(entry.message, str)
        ]

    # -- as it was written --------------------------------------------------------------------

    def messages(self) -> Iterator[LoggedMessage]:
        """Yield every message in the order of its time; equal times keep the order of writing."""
        qos = [channel.qos for channel in self.channels]
        for time_ns, index, data in self._messages:
            channel = self.channels[index]
            yield LoggedMessage(time_ns, channel.topic, channel.type, qos[index], data)

    @property
    def counts(self) -> dict[str, int]:
        """Number of messages by topic."""
        counts = dict.fromkeys((channel.topic for channel in self.channels), 0)
        for _, index, _ in self._messages:
            counts[self.channels[index].topic] += 1
        return counts

    @property
    def start(self) -> float:
        """Time of the first message, s."""
        return self._messages[0][0] / 1e9 if self._messages else 0.0

    @property
    def end(self) -> float:
        """Time of the last message, s."""
        return self._messages[-1][0] / 1e9 if self._messages else 0.0

    @property
    def duration(self) -> float:
        """Time between the first and the last message, s."""
        return self.end - self.start

    @property
    def scene_text(self) -> str | None:
        """Scene the run was made from, as it was written; None if it is not inside.

        Raises
        ------
        RecordingError
            if it is not UTF-8
        """
        data = self.attachments.get("scene.yaml")
        return None if data is None else words(self.path, "scene.yaml", data)

    # -- inside -------------------------------------------------------------------------------

    def _series(self, key: str) -> tuple[NDArray[np.int64], Stack | None]:
        return self._stacked(self._known.get(key, -1))

    def _stacked(self, index: int) -> tuple[NDArray[np.int64], Stack | None]:
        """Return times and content of all messages of a channel."""
        chosen = [(time_ns, data) for time_ns, at, data in self._messages if at == index]
        if not chosen:
            return np.empty(0, np.int64), None
        times, payloads = zip(*chosen, strict=True)
        try:
            return np.array(times, np.int64), stack(self.channels[index].type, payloads)
        except DecodeError as reason:
            topic = self.channels[index].topic
            raise RecordingError(self.path, f"cannot be decoded on {topic}: {reason}") from reason

    def _limbs(self, key: str, ndim: int) -> dict[str, PoseSeries]:
        names = [k.partition("/")[2] for k in self._known if k.startswith(f"{key}/")]
        if not names and key in self._known:
            names = [""]
        return {name: self._poses(f"{key}/{name}" if name else key, ndim) for name in names}

    def _last(self, key: str, limbs: dict[str, PoseSeries], ndim: int) -> PoseSeries:
        if limbs and ("" in limbs or key not in self._known):
            return list(limbs.values())[-1]
        return self._poses(key, ndim)

    def _poses(self, key: str, ndim: int) -> PoseSeries:
        """Return poses with so many dimensions: (T, N, 7) or (T, 7)."""
        time_ns, content = self._series(key)
        if content is None:
            return PoseSeries(time_ns, "", np.empty((0, 0, 7)[-ndim:]))
        shape = (len(time_ns), -1, 7) if ndim == 3 else (len(time_ns), 7)
        return PoseSeries(time_ns, content.frame_id, content.blocks[0].reshape(shape))

    def _joints(self, key: str) -> JointSeries:
        time_ns, content = self._series(key)
        if content is None:
            nothing = np.empty((0, 0))
            return JointSeries(time_ns, (), nothing, nothing, nothing)
        return JointSeries(time_ns, content.texts, *content.blocks)

    def _decoded(self, message_type: str, data: bytes) -> Decoded:
        try:
            return decode(message_type, data)
        except DecodeError as reason:
            raise RecordingError(self.path, f"cannot be decoded: {reason}") from reason


def read_run(path: str | Path, node: str | None = None) -> Run:
    """Read a recording.

    A recording that was never closed is read as far as it goes, with a warning.

    Parameters
    ----------
    path : rosbag2 directory, or one MCAP file
    node : full name of the node, such as ``/arm1/soft_arm``; needed only if the recording holds
        more than one arm

    Returns
    -------
    Run
        the recording, in memory

    Raises
    ------
    RecordingError
        if there is no recording, or it holds nothing of this package
    """
    content = scan(path)
    run = Run(content, node)
    if run.torn or run.damaged_chunks:
        what = "was never closed" if run.torn else "is damaged"
        if run.damaged_chunks:
            what += f" and {run.damaged_chunks} of its parts cannot be read"
        warnings.warn(
            f"{path}: {what}; read {len(content.messages)} messages, the last at {run.end:.9g} s",
            TornRecordingWarning,
            stacklevel=2,
        )
    return run
