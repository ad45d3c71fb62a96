"""Contacts as ``sensor_msgs/PointCloud2``: one point for each, with all that is known of it.

Viewers draw the points where the arm touches; every number of a contact is a named field. Bodies
and shapes are numbers: bodies in the order of the scene, then the shapes of its environment.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.recording.cdr import Buffer, Layout

Floats = NDArray[np.float64]
UINT8, UINT16, FLOAT32 = 2, 4, 7  # sensor_msgs/PointField
NOBODY = 65535
_AXES = ("x", "y", "z")
NUMBERS = (
    *_AXES,
    *(f"normal_{axis}" for axis in _AXES),
    "gap",
    "normal_force",
    *(f"friction_{axis}" for axis in _AXES),
    *(f"slip_{axis}" for axis in _AXES),
    "s",
)
_KINDS = {"f4": FLOAT32, "u2": UINT16, "u1": UINT8}
_AFTER = 4 * len(NUMBERS)
# name, type, offset in bytes
FIELDS: tuple[tuple[str, str, int], ...] = (
    *((name, "f4", 4 * i) for i, name in enumerate(NUMBERS)),
    ("body", "u2", _AFTER),
    ("other", "u2", _AFTER + 2),
    ("sticks", "u1", _AFTER + 4),
)


def _point(offsets: Sequence[int], step: int) -> np.dtype[Any]:
    return np.dtype(
        {
            "names": [name for name, _, _ in FIELDS],
            "formats": [f"<{kind}" for _, kind, _ in FIELDS],
            "offsets": list(offsets),
            "itemsize": step,
        }
    )


POINT = _point([offset for _, _, offset in FIELDS], _AFTER + 8)


class Touch(Protocol):
    """What is read of a ``Contact``."""

    body: str
    shape: str
    s: float
    point: Floats
    normal: Floats
    gap: float
    normal_force: float
    friction: Floats
    sticks: bool
    slip: Floats


class CloudBuffer(Buffer):
    """``sensor_msgs/PointCloud2`` of contacts.

    Parameters
    ----------
    frame_id : frame of points and vectors
    bodies, shapes : names, in the order of their numbers
    """

    def __init__(self, frame_id: str, bodies: Sequence[str], shapes: Sequence[str]) -> None:
        self._bodies = {name: i for i, name in enumerate(bodies)}
        self._others = self._bodies | {name: len(bodies) + i for i, name in enumerate(shapes)}
        layout = Layout().header(frame_id).unsigned(1)
        self._width = layout.slot("<u4")
        layout.unsigned(len(FIELDS))
        for name, kind, offset in FIELDS:
            layout.text(name).unsigned(offset).byte(_KINDS[kind]).unsigned(1)
        layout.byte(0).unsigned(POINT.itemsize)  # little endian
        self._row = layout.slot("<u4")
        self._count = layout.slot("<u4")
        self._message, self._body = layout.store()

    def fill(self, time_ns: int, contacts: Iterable[Touch]) -> bytes:
        """Give the bytes for the contacts of a time in ns."""
        points = np.zeros(len(found := tuple(contacts)), POINT)
        for point, contact in zip(points, found, strict=True):
            vectors = (contact.normal, contact.friction, contact.slip)
            for name, vector in zip(("normal", "friction", "slip"), vectors, strict=True):
                for axis, value in zip(_AXES, vector, strict=True):
                    point[f"{name}_{axis}"] = value
            point["x"], point["y"], point["z"] = contact.point
            point["gap"], point["normal_force"] = contact.gap, contact.normal_force
            point["s"], point["sticks"] = contact.s, contact.sticks
            point["body"] = self._bodies.get(contact.body, NOBODY)
            point["other"] = self._others.get(contact.shape, NOBODY)
        head = self._body
        head[:8].view("<u4")[:] = divmod(time_ns, 1_000_000_000)
        head[self._width : self._width + 4].view("<u4")[0] = len(points)
        for at in (self._row, self._count):
            head[at : at + 4].view("<u4")[0] = len(points) * POINT.itemsize
        return self._message.tobytes() + points.tobytes() + b"\1"  # dense


@dataclass(frozen=True, eq=False)
class Cloud:
    """``sensor_msgs/PointCloud2``: points (N,), a structured array with its fields."""

    stamp_ns: int
    frame_id: str
    points: NDArray[Any]


def points_of(fields: Sequence[tuple[str, int, int]], step: int, data: bytes) -> NDArray[Any]:
    """Return points (N,) with the fields that contacts have, from those of a message.

    Parameters
    ----------
    fields : (name, offset, type) of each
    step : bytes of a point

    Raises
    ------
    ValueError
        if these are not the fields of contacts
    """
    known = {name: (offset, kind) for name, offset, kind in fields}
    for name, kind, _ in FIELDS:
        if name not in known or known[name][1] != _KINDS[kind]:
            raise ValueError(f"a cloud without a field {name!r} of type {kind}: no contacts")
    own = _point([known[name][0] for name, _, _ in FIELDS], step)
    return np.frombuffer(data, own).astype(POINT)
