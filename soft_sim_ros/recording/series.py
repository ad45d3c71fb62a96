"""Arrays over time, as read from a recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Series:
    """Something recorded at T instants.

    Parameters
    ----------
    time_ns : (T,) simulation time in ns
    """

    time_ns: NDArray[np.int64]

    @property
    def time(self) -> Floats:
        """Simulation time (T,) in s."""
        return self.time_ns / 1e9

    def __len__(self) -> int:
        return len(self.time_ns)


@dataclass(frozen=True)
class PoseSeries(Series):
    """Poses over time.

    Parameters
    ----------
    frame_id : frame they are given in
    poses : (T, N, 7) for a backbone, (T, 7) for one pose: ``x y z`` in m, ``qx qy qz qw``
    """

    frame_id: str
    poses: Floats

    @property
    def positions(self) -> Floats:
        """Positions (T, …, 3) in m."""
        return self.poses[..., :3]

    @property
    def quaternions(self) -> Floats:
        """Orientations (T, …, 4), ``x y z w``."""
        return self.poses[..., 3:]


@dataclass(frozen=True)
class JointSeries(Series):
    """Named scalars over time, with rates and efforts.

    Parameters
    ----------
    name : (n,) names
    position, velocity, effort : (T, n); (T, 0) where they are not part of the messages
    """

    name: tuple[str, ...]
    position: Floats
    velocity: Floats
    effort: Floats


@dataclass(frozen=True)
class EnergySeries(Series):
    """Energy ledger over time.

    Parameters
    ----------
    names : (n,) names of the entries
    values : (T, n) in J
    """

    names: tuple[str, ...]
    values: Floats

    def __getitem__(self, name: str) -> Floats:
        """Give one entry (T,) in J."""
        if name not in self.names:
            raise KeyError(f"{name!r} is not in the ledger; it has {', '.join(self.names)}")
        return self.values[:, self.names.index(name)]
