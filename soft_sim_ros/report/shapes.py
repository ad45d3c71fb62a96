"""What a recording says of shapes: poses along every backbone at the same instants."""

from __future__ import annotations

from functools import reduce
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.recording.reader import Run
from soft_sim_ros.report.style import shown
from soft_sim_ros.scene.taper import Floats


class Shapes(NamedTuple):
    """Poses along all backbones, one after the other.

    time_ns : (T,) the instants at which every backbone was recorded
    names : of the backbones; one alone is called ``""``
    parts : where each of them is among the N poses
    poses : (T, N, 7)
    """

    time_ns: NDArray[np.int64]
    names: tuple[str, ...]
    parts: tuple[slice, ...]
    poses: Floats

    @property
    def time(self) -> Floats:
        """Simulation time (T,) in s."""
        return self.time_ns / 1e9

    @property
    def drawable(self) -> NDArray[np.bool_]:
        """Which shapes (T,) can be drawn: all of their positions are numbers, and sane ones."""
        if not self.poses.size:
            return np.zeros(len(self.time_ns), bool)
        found: NDArray[np.bool_] = np.isfinite(shown(self.poses[..., :3])).all(axis=(1, 2))
        return found

    def at(self, chosen: NDArray) -> Shapes:
        """Return the shapes at some of the instants."""
        return self._replace(time_ns=self.time_ns[chosen], poses=self.poses[chosen])


def shapes_of(run: Run) -> Shapes:
    """Return the shapes of a recording; without any, T is 0."""
    series = {name: one for name, one in run.backbones.items() if len(one)}
    if not series:
        return Shapes(np.empty(0, np.int64), (), (), np.empty((0, 0, 7)))
    times = [one.time_ns for one in series.values()]
    poses = [one.poses for one in series.values()]
    time_ns = times[0]
    if any(not np.array_equal(time_ns, other) for other in times[1:]):  # some messages were lost
        time_ns = reduce(np.intersect1d, times)
        poses = [one[np.searchsorted(own, time_ns)] for own, one in zip(times, poses, strict=True)]
    ends = np.cumsum([0, *(one.shape[1] for one in poses)]).tolist()
    parts = tuple(slice(a, b) for a, b in pairwise(ends))
    whole = poses[0] if len(poses) == 1 else np.concatenate(poses, axis=1)
    return Shapes(time_ns, tuple(series), parts, whole)
