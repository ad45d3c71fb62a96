"""``visualization_msgs/MarkerArray`` as bytes that are laid out once and then written over."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from soft_sim_ros.recording.cdr import Buffer, Layout

_SECOND = 1_000_000_000  # ns


class Slate:
    """The parts of one marker that may change: views of the bytes of the message."""

    def __init__(self, body: NDArray[np.uint8], at: dict[str, int], points: int) -> None:
        def view(name: str, kind: str, count: int) -> NDArray[Any]:
            size = np.dtype(kind).itemsize * count
            return body[at[name] : at[name] + size].view(kind)

        self.action = view("action", "<i4", 1)
        self.pose = view("pose", "<f8", 7)
        self.colour = view("colour", "<f4", 4)
        self.points = view("points", "<f8", 3 * points).reshape(points, 3)


class MarkerArrayBuffer(Buffer):
    """A ``MarkerArray`` of markers whose kinds, names, sizes and numbers of points are fixed.

    Parameters
    ----------
    frame_id : frame of poses and points; what carries no points is placed by its pose alone
    markers : for each the namespace, id, type, scale (3,), colour (4,) and number of points
    """

    def __init__(
        self,
        frame_id: str,
        markers: Sequence[tuple[str, int, int, ArrayLike, ArrayLike, int]],
    ) -> None:
        layout = Layout().unsigned(len(markers))
        stamps, places, given = [], [], []
        for namespace, identity, kind, scale, colour, points in markers:
            at = {"stamp": layout.slot("<u4", 2)}
            layout.text(frame_id).text(namespace).unsigned(identity).unsigned(kind)
            at["action"] = layout.slot("<i4")
            at["pose"] = layout.slot("<f8", 7)
            at["scale"] = layout.slot("<f8", 3)
            at["colour"] = layout.slot("<f4", 4)
            layout.slot("<u4", 2)  # lifetime: for ever
            at["locked"] = layout.slot("<u1")
            layout.unsigned(points)
            at["points"] = layout.slot("<f8", 3 * points)
            layout.unsigned(0)  # colours of points
            # texture: resource; image with stamp, frame, format, bytes; coordinates
            layout.text("")
            layout.slot("<u4", 2)
            layout.text("").text("").unsigned(0).unsigned(0)
            # text; mesh: resource, file with name and bytes, materials
            layout.text("").text("").text("").unsigned(0)
            layout.slot("<u1")
            stamps.append(at["stamp"] // 4)
            places.append((at, points))
            given.append((scale, colour))
        self._message, body = layout.store()
        whole = body[: len(body) // 4 * 4].view("<u4")
        self._whole, self._stamps = whole, np.array(stamps, dtype=np.int64)
        self.slates = [Slate(body, at, points) for at, points in places]
        for slate, (at, _), (scale, colour) in zip(self.slates, places, given, strict=True):
            body[at["scale"] : at["scale"] + 24].view("<f8")[:] = scale
            body[at["locked"]] = 1  # placed anew whenever the frame moves against the viewer's
            slate.colour[:] = colour
            slate.pose[6] = 1.0

    def bytes(self, time_ns: int) -> bytes:
        """Give the bytes of what the slates hold, with this time."""
        seconds, rest = divmod(time_ns, _SECOND)
        self._whole[self._stamps], self._whole[self._stamps + 1] = seconds, rest
        return self._message.tobytes()
