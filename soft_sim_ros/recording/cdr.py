"""Messages as CDR bytes, with the constant parts laid out once.

ROS 2 sends messages as little-endian CDR: a four-byte header, then the fields in order, each on a
multiple of its own size counted from after that header. For a given arm the names, frames and
lengths of a message never change, so a buffer lays them out once and ``fill`` rewrites only the
stamp and the blocks of numbers. Padding is always zero: equal messages are equal bytes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

_HEADER = b"\x00\x01\x00\x00"  # plain CDR, little endian
_SECOND = 1_000_000_000  # ns
_DOUBLE = np.dtype("<f8")
_UNSIGNED = np.dtype("<u4")


class Layout:
    """Lays out one message and remembers where its stamp and its float blocks lie."""

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._stamp = self._stamp_size = 0  # types without a stamp have an empty one
        self._blocks: list[tuple[int, int]] = []

    def _align(self, size: int) -> None:
        self._bytes += bytes(-len(self._bytes) % size)

    def unsigned(self, value: int) -> Layout:
        self._align(4)
        self._bytes += int(value).to_bytes(4, "little")
        return self

    def byte(self, value: int) -> Layout:
        self._bytes.append(value)
        return self

    def text(self, value: str) -> Layout:
        data = value.encode() + b"\0"
        self.unsigned(len(data))
        self._bytes += data
        return self

    def stamp(self) -> Layout:
        self._align(4)
        self._stamp, self._stamp_size = len(self._bytes), 8
        self._bytes += bytes(8)
        return self

    def doubles(self, count: int) -> Layout:
        """Put a fixed block of ``count`` numbers."""
        if count:
            self._align(8)
        self._blocks.append((len(self._bytes), count))
        self._bytes += bytes(8 * count)
        return self

    def slot(self, kind: str, count: int = 1) -> int:
        """Put ``count`` numbers of a numpy type such as ``<f4``; return where the first lies."""
        size = np.dtype(kind).itemsize
        if count:
            self._align(size)
        at = len(self._bytes)
        self._bytes += bytes(size * count)
        return at

    def sequence(self, count: int, width: int = 1) -> Layout:
        """Put a sequence of ``count`` elements of ``width`` numbers each."""
        return self.unsigned(count).doubles(count * width)

    def header(self, frame_id: str) -> Layout:
        return self.stamp().text(frame_id)

    def store(self) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Give the message as bytes, and those after its header, on their alignment."""
        # four bytes of room in front put the first field, and so every number, on its alignment
        store = np.zeros(8 + len(self._bytes), np.uint8)
        message, body = store[4:], store[8:]
        message[:4] = np.frombuffer(_HEADER, np.uint8)
        body[:] = np.frombuffer(bytes(self._bytes), np.uint8)
        return message, body

    def build(self) -> tuple[NDArray[np.uint8], NDArray[Any], list[NDArray[np.float64]]]:
        """Give the message as bytes, and views of its stamp, (2,) or (0,), and float blocks."""
        message, body = self.store()
        stamp = body[self._stamp : self._stamp + self._stamp_size].view(_UNSIGNED)
        blocks = [body[at : at + 8 * count].view(_DOUBLE) for at, count in self._blocks]
        return message, stamp, blocks


def set_stamp(stamp: NDArray[Any], time_ns: int) -> None:
    """Write a time in ns, not below zero, into the stamp of a message."""
    stamp[0], stamp[1] = divmod(time_ns, _SECOND)


class Buffer:
    """A message laid out once. Its parts are views of its bytes, so a copy is laid out anew."""

    def __new__(cls, *arguments: Any, **named: Any) -> Any:
        """Note how it is laid out."""
        new = super().__new__(cls)
        new._laid_out = arguments, named
        return new

    _laid_out: tuple[tuple[Any, ...], dict[str, Any]]

    def __reduce__(self) -> tuple[Any, ...]:
        return _laid_out_anew, (type(self), *self._laid_out)


def _laid_out_anew(kind: type, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
    return kind(*arguments, **named)


class PoseArrayBuffer(Buffer):
    """``geometry_msgs/PoseArray`` with a fixed frame and number of poses.

    Parameters
    ----------
    frame_id : frame the poses are given in
    count : number of poses N
    """

    def __init__(self, frame_id: str, count: int) -> None:
        self._count = count
        layout = Layout().header(frame_id).sequence(count, 7)
        self._message, self._stamp, (self._poses,) = layout.build()

    def fill(self, time_ns: int, poses: NDArray[np.float64]) -> bytes:
        """Give the bytes for poses (N, 7), each ``x y z qx qy qz qw`` in m."""
        set_stamp(self._stamp, time_ns)
        self._poses.reshape(self._count, 7)[:] = poses
        return self._message.tobytes()


class JointStateBuffer(Buffer):
    """``sensor_msgs/JointState`` with fixed names; any of the three sequences may be left empty.

    Parameters
    ----------
    names : (n,) names
    position, velocity, effort : whether that sequence is present
    frame_id : usually empty
    """

    def __init__(
        self,
        names: Sequence[str],
        *,
        position: bool = True,
        velocity: bool = True,
        effort: bool = True,
        frame_id: str = "",
    ) -> None:
        layout = Layout().header(frame_id).unsigned(len(names))
        for name in names:
            layout.text(name)
        for present in (position, velocity, effort):
            layout.sequence(len(names) if present else 0)
        self._message, self._stamp, blocks = layout.build()
        self._position, self._velocity, self._effort = blocks

    def fill(
        self,
        time_ns: int,
        position: ArrayLike = (),
        velocity: ArrayLike = (),
        effort: ArrayLike = (),
    ) -> bytes:
        """Give the bytes for the (n,) numbers; ``()`` for a sequence that is not present."""
        set_stamp(self._stamp, time_ns)
        self._position[:] = position
        self._velocity[:] = velocity
        self._effort[:] = effort
        return self._message.tobytes()


class Float64MultiArrayBuffer(Buffer):
    """``std_msgs/Float64MultiArray`` of one dimension, or with a label for every number.

    Parameters
    ----------
    count : number of values
    label : label of the only dimension, or one for each of the values, in dimensions of one value
        each; without any the layout is empty, as most publishers send it
    """

    def __init__(self, count: int, label: str | Sequence[str] = ()) -> None:
        layout = Layout()
        if label and isinstance(label, str):
            layout.unsigned(1).text(label).unsigned(count).unsigned(count)
        else:
            layout.unsigned(len(label))
            for one in label:
                layout.text(one).unsigned(1).unsigned(1)
        layout.unsigned(0).sequence(count)
        self._message, _, (self._data,) = layout.build()

    def fill(self, data: ArrayLike) -> bytes:
        """Give the bytes for data (count,)."""
        self._data[:] = data
        return self._message.tobytes()


class PoseStampedBuffer(Buffer):
    """``geometry_msgs/PoseStamped`` in a fixed frame."""

    def __init__(self, frame_id: str) -> None:
        self._message, self._stamp, (self._pose,) = Layout().header(frame_id).doubles(7).build()

    def fill(self, time_ns: int, pose: ArrayLike) -> bytes:
        """Give the bytes for a pose (7,), ``x y z qx qy qz qw`` in m."""
        set_stamp(self._stamp, time_ns)
        self._pose[:] = pose
        return self._message.tobytes()


class WrenchStampedBuffer(Buffer):
    """``geometry_msgs/WrenchStamped`` in a fixed frame."""

    def __init__(self, frame_id: str) -> None:
        self._message, self._stamp, (self._wrench,) = Layout().header(frame_id).doubles(6).build()

    def fill(self, time_ns: int, wrench: ArrayLike) -> bytes:
        """Give the bytes for a wrench (6,), moment in N·m then force in N.

        That is the order of all of this package; the message itself has the force first.
        """
        set_stamp(self._stamp, time_ns)
        wrench = np.asarray(wrench, float)
        self._wrench[:3] = wrench[3:]
        self._wrench[3:] = wrench[:3]
        return self._message.tobytes()


class ClockBuffer(Buffer):
    """``rosgraph_msgs/Clock``."""

    def __init__(self) -> None:
        self._message, self._stamp, _ = Layout().stamp().build()

    def fill(self, time_ns: int) -> bytes:
        """Give the bytes for a time in ns."""
        set_stamp(self._stamp, time_ns)
        return self._message.tobytes()


def encode_string(text: str) -> bytes:
    """Give the bytes of a ``std_msgs/String``."""
    return Layout().text(text).build()[0].tobytes()


def encode_floats(data: ArrayLike, label: str = "") -> bytes:
    """Give the bytes of one ``std_msgs/Float64MultiArray``; in a loop, keep a buffer instead."""
    data = np.asarray(data, float).ravel()
    return Float64MultiArrayBuffer(len(data), label).fill(data)
