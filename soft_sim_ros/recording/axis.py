"""The time axis of a recording: log times or stamps.

This package logs every message at its simulation time. ``ros2 bag record`` logs it when it arrives,
by the clock on the wall or, with ``--use-sim-time``, by ``/clock``: an arm that runs at a tenth of
real time then seems to move ten times slower. Where log times and the stamps of the arm's own
messages differ, the stamps are right.
"""

from __future__ import annotations

import struct
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from soft_sim_ros.recording.scan import Scan

STAMPED = ("backbone", "joint_states", "strain_state", "tip_pose", "contacts", "reaction")
PAIRED = "energy"  # published with them, but without a stamp of its own
_SECOND = 1_000_000_000  # ns
Message = tuple[int, int, bytes]


@dataclass(frozen=True)
class Axis:
    """A map from log times to the times of the recording.

    Parameters
    ----------
    words : description of where the times come from
    stamped : channels whose messages carry the time
    paired : channels whose messages belong to the nearest stamped one
    log, stamp : (T,) log time and stamp of all stamped messages, ns; both never fall
    """

    words: str
    stamped: frozenset[int] = frozenset()
    paired: frozenset[int] = frozenset()
    log: tuple[int, ...] = ()
    stamp: tuple[int, ...] = ()

    def moved(self, messages: Sequence[Message]) -> list[Message]:
        """Return messages with their times on this axis.

        What came in from outside and carries no stamp of the arm lies between two states that do:
        its time is interpolated.
        """
        return [(self._time(*message), *message[1:]) for message in messages]

    def _time(self, log: int, channel: int, data: bytes) -> int:
        if channel in self.stamped:
            return stamp_of(data) or 0
        after = bisect_right(self.log, log)
        low, high = max(after - 1, 0), min(after, len(self.log) - 1)
        begin, end = self.log[low], self.log[high]
        if channel in self.paired or end <= begin:
            return self.stamp[low if log - begin <= end - log else high]
        share = self.stamp[high] - self.stamp[low]
        return self.stamp[low] + share * (log - begin) // (end - begin)


LOG = Axis("simulation time of the log")


def axis_of(content: Scan, known: dict[str, int]) -> Axis:
    """Choose the axis of a recording that another program has made.

    Parameters
    ----------
    content : the recording
    known : key of a topic → index of its channel
    """
    stamped = frozenset(index for key, index in known.items() if key.partition("/")[0] in STAMPED)
    pairs = [
        (time_ns, stamp_of(data)) for time_ns, index, data in content.messages if index in stamped
    ]
    if not pairs or any(stamp is None for _, stamp in pairs):
        return Axis("log time, no stamps") if not pairs else Axis("log time, some stamps are none")
    table = np.array(pairs, np.int64)
    log, stamps = table[np.argsort(table[:, 0], kind="stable")].T
    if np.array_equal(log, stamps):
        return LOG
    if len(pairs) > 1 and stamps.max() == stamps.min() and log.max() > log.min():
        return Axis("log time, the stamps stand still")
    paired = frozenset({known[PAIRED]} if PAIRED in known else ())
    rising = np.maximum.accumulate(stamps)
    return Axis("header stamps", stamped, paired, tuple(log.tolist()), tuple(rising.tolist()))


def stamp_of(data: bytes) -> int | None:
    """Return the stamp in ns of a message that begins with a header, None if it has none."""
    if len(data) < 12 or data[0] != 0 or data[1] > 1:
        return None
    seconds, rest = struct.unpack_from("<iI" if data[1] else ">iI", data, 4)
    return seconds * _SECOND + rest if seconds >= 0 and rest < _SECOND else None
