"""CDR bytes back to numbers: one message, or a whole topic at once.

A topic of one arm is thousands of messages that differ only in the stamp and in blocks of
numbers. ``stack`` walks through the first message, checks that all others are laid out the same
way, and takes the numbers of all of them with a few strided copies.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.errors import SoftSimError
from soft_sim_ros.recording import topics
from soft_sim_ros.recording.cloud import Cloud, points_of

CLOCK = "rosgraph_msgs/msg/Clock"
Floats = NDArray[np.float64]
_DOUBLE = {order: np.dtype(order + "f8") for order in "<>"}


class DecodeError(SoftSimError):
    """Bytes are not the message they should be."""

    def __init__(self, message_type: str, size: int, reason: str) -> None:
        super().__init__(message_type, size, reason)
        self.message_type, self.size, self.reason = message_type, size, reason

    def __str__(self) -> str:
        return f"{self.message_type} message of {self.size} bytes: {self.reason}"


class _Walk:
    """Walks through the body of one message and notes where everything lies."""

    def __init__(self, data: bytes) -> None:
        if len(data) < 4 or data[0] != 0 or data[1] > 1:
            raise ValueError(f"begins with {data[:4].hex(' ')}, which is not plain CDR")
        self.order = "<" if data[1] else ">"
        self.data = data
        self.at = 4
        self.stamp: int | None = None
        self.frame_id = ""
        self.texts: list[str] = []
        self.blocks: list[tuple[int, int]] = []  # (offset in bytes, number of doubles)
        self.fixed: list[slice] = [slice(0, 2)]  # bytes that make the layout
        self.fields: list[tuple[str, int, int]] = []  # of a cloud: name, offset, type
        self.points = slice(0)  # of a cloud: its bytes
        self.step = 0

    def _take(self, size: int, align: int) -> int:
        start = self.at + -(self.at - 4) % align
        if start + size > len(self.data):
            raise ValueError(f"ends before the {size} bytes expected at offset {start}")
        self.at = start + size
        return start

    def unsigned(self) -> int:
        start = self._take(4, 4)
        self.fixed.append(slice(start, start + 4))
        return int(struct.unpack_from(f"{self.order}I", self.data, start)[0])

    def text(self) -> str:
        size = self.unsigned()
        start = self._take(size, 1)
        self.fixed.append(slice(start, start + size))
        return self.data[start : start + size].removesuffix(b"\0").decode()

    def texts_of(self, count: int) -> None:
        self.texts = [self.text() for _ in range(count)]

    def byte(self) -> int:
        start = self._take(1, 1)
        self.fixed.append(slice(start, start + 1))
        return self.data[start]

    def time(self) -> None:
        self.stamp = self._take(8, 4)

    def header(self) -> None:
        self.time()
        self.frame_id = self.text()

    def doubles(self, count: int) -> None:
        start = self._take(8 * count, 8) if count else self.at
        self.blocks.append((start, count))


def _pose_array(walk: _Walk) -> None:
    walk.header()
    walk.doubles(7 * walk.unsigned())


def _pose_stamped(walk: _Walk) -> None:
    walk.header()
    walk.doubles(7)


def _wrench_stamped(walk: _Walk) -> None:
    walk.header()
    walk.doubles(6)


def _imu(walk: _Walk) -> None:
    walk.header()
    for count in (4, 9, 3, 9, 3, 9):
        walk.doubles(count)


def _odometry(walk: _Walk) -> None:
    walk.header()
    walk.texts_of(1)
    for count in (7, 36, 6, 36):
        walk.doubles(count)


def _joint_state(walk: _Walk) -> None:
    walk.header()
    walk.texts_of(walk.unsigned())
    for _ in range(3):
        walk.doubles(walk.unsigned())


def _float_array(walk: _Walk) -> None:
    for _ in range(walk.unsigned()):
        walk.texts.append(walk.text())
        walk.unsigned()
        walk.unsigned()
    walk.unsigned()
    walk.doubles(walk.unsigned())


def _cloud(walk: _Walk) -> None:
    walk.header()
    height, width = walk.unsigned(), walk.unsigned()
    for _ in range(walk.unsigned()):
        name, offset, kind = walk.text(), walk.unsigned(), walk.byte()
        walk.fields.append((name, offset, kind))
        walk.unsigned()
    backwards, walk.step = walk.byte(), walk.unsigned()
    walk.unsigned()
    size = walk.unsigned()
    if backwards or size != height * width * walk.step:
        raise ValueError(f"{size} bytes for {height} × {width} points of {walk.step} bytes")
    start = walk._take(size, 1)
    walk.points = slice(start, start + size)
    walk.byte()


_WALKS: dict[str, Callable[[_Walk], None]] = {
    topics.POSES: _pose_array,
    topics.POSE: _pose_stamped,
    topics.WRENCH: _wrench_stamped,
    topics.IMU: _imu,
    topics.JOINTS: _joint_state,
    topics.ODOMETRY: _odometry,
    topics.FLOATS: _float_array,
    topics.CLOUD: _cloud,
    topics.STRING: lambda walk: walk.texts_of(1),
    CLOCK: _Walk.time,
}


KNOWN = frozenset(_WALKS)  # types that can be decoded here


@dataclass(frozen=True)
class Stack:
    """Messages of one type and one layout, T of them.

    Parameters
    ----------
    stamps_ns : (T,) stamps in ns; None for types without one
    frame_id : frame of the header; empty for types without one
    texts : joint names, labels of dimensions, or the one text of a String
    blocks : the numbers, one array (T, n) per field in the order of the definition
    """

    stamps_ns: NDArray[np.int64] | None
    frame_id: str
    texts: tuple[str, ...]
    blocks: tuple[Floats, ...]


def _walk(message_type: str, data: bytes) -> _Walk:
    if message_type not in _WALKS:
        raise DecodeError(message_type, len(data), f"not one of {', '.join(sorted(_WALKS))}")
    try:
        walk = _Walk(data)
        _WALKS[message_type](walk)
    except ValueError as reason:  # also UnicodeDecodeError
        raise DecodeError(message_type, len(data), str(reason)) from reason
    if len(data) - walk.at >= 8:
        raise DecodeError(message_type, len(data), f"the message is over after {walk.at} bytes")
    return walk


def stack(message_type: str, payloads: Sequence[bytes]) -> Stack:
    """Decode many messages of one layout at once.

    Parameters
    ----------
    message_type : such as ``geometry_msgs/msg/PoseArray``
    payloads : at least one message

    Returns
    -------
    Stack
        stamps and numbers of all messages

    Raises
    ------
    DecodeError
        if a message is damaged, or is not laid out like the first
    """
    walk = _walk(message_type, payloads[0])
    size = len(payloads[0])
    total = len(payloads)
    for index, payload in enumerate(payloads):
        if len(payload) != size:
            reason = f"message {index} of {total} differs in size from the first ({size} bytes)"
            raise DecodeError(message_type, len(payload), reason)
    matrix = np.frombuffer(b"".join(payloads), np.uint8).reshape(total, size)
    for part in walk.fixed:
        same = (matrix[:, part] == matrix[0, part]).all(axis=1)
        if not same.all():
            reason = f"message {int(same.argmin())} of {total} differs in layout from the first"
            raise DecodeError(message_type, size, reason)

    def numbers(at: int, count: int, kind: str) -> NDArray:
        width = 8 if kind == "f8" else 4
        block = np.ascontiguousarray(matrix[:, at : at + width * count])
        return block.view(walk.order + kind).reshape(total, count)

    stamps = None
    if walk.stamp is not None:
        seconds, nanoseconds = numbers(walk.stamp, 2, "i4").astype(np.int64).T
        stamps = seconds * 1_000_000_000 + (nanoseconds & 0xFFFFFFFF)
    blocks = tuple(numbers(at, n, "f8").astype(float, copy=False) for at, n in walk.blocks)
    return Stack(stamps, walk.frame_id, tuple(walk.texts), blocks)


@dataclass(frozen=True)
class FloatArray:
    """``std_msgs/Float64MultiArray``: data (n,) and the labels of its dimensions."""

    labels: tuple[str, ...]
    data: Floats


@dataclass(frozen=True)
class JointState:
    """``sensor_msgs/JointState``: names (n,), and position, velocity, effort (n,) or (0,)."""

    stamp_ns: int
    frame_id: str
    name: tuple[str, ...]
    position: Floats
    velocity: Floats
    effort: Floats


@dataclass(frozen=True)
class Poses:
    """``geometry_msgs/PoseArray`` or ``PoseStamped`` (N = 1): (N, 7), ``x y z qx qy qz qw``."""

    stamp_ns: int
    frame_id: str
    poses: Floats


@dataclass(frozen=True)
class Wrench:
    """``geometry_msgs/WrenchStamped``: (6,), moment in N·m then force in N, in ``frame_id``.

    The message itself has the force first; everywhere in this package the moment comes first.
    """

    stamp_ns: int
    frame_id: str
    wrench: Floats


@dataclass(frozen=True, eq=False)
class Odometry:
    """``nav_msgs/Odometry``: pose (7,) in ``frame_id``, and the twist (6,) along its own axes.

    The message has the linear velocity first; here the angular comes first.
    """

    stamp_ns: int
    frame_id: str
    pose: Floats
    twist: Floats


@dataclass(frozen=True, eq=False)
class Imu:
    """``sensor_msgs/Imu``: orientation (4,) ``x y z w``; rad/s and m/s² (3,) in ``frame_id``."""

    stamp_ns: int
    frame_id: str
    orientation: Floats
    angular_velocity: Floats
    linear_acceleration: Floats


Decoded = FloatArray | JointState | Imu | Poses | Wrench | Odometry | Cloud | str | int


def decode(message_type: str, data: bytes) -> Decoded:
    """Decode one message; a String becomes a str, a Clock the time in ns."""
    walk = _walk(message_type, data)
    stamp = 0
    if walk.stamp is not None:
        seconds, nanoseconds = struct.unpack_from(f"{walk.order}iI", data, walk.stamp)
        stamp = seconds * 1_000_000_000 + nanoseconds
    if message_type == topics.CLOUD:
        try:
            points = points_of(walk.fields, walk.step, data[walk.points])
        except ValueError as reason:
            raise DecodeError(message_type, len(data), str(reason)) from reason
        return Cloud(stamp, walk.frame_id, points)
    kind = _DOUBLE[walk.order]
    blocks = [np.frombuffer(data, kind, n, at).astype(np.float64) for at, n in walk.blocks]
    if message_type == topics.STRING:
        return walk.texts[0]
    if message_type == CLOCK:
        return stamp
    if message_type == topics.FLOATS:
        return FloatArray(tuple(walk.texts), blocks[0])
    if message_type == topics.JOINTS:
        return JointState(stamp, walk.frame_id, tuple(walk.texts), *blocks)
    if message_type == topics.WRENCH:
        return Wrench(stamp, walk.frame_id, np.roll(blocks[0], 3))
    if message_type == topics.IMU:
        return Imu(stamp, walk.frame_id, blocks[0], blocks[2], blocks[4])
    if message_type == topics.ODOMETRY:
        return Odometry(stamp, walk.frame_id, blocks[0], np.roll(blocks[2], 3))
    return Poses(stamp, walk.frame_id, blocks[0].reshape(-1, 7))
