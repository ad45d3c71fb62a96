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


@dataclass(frozen=True)
class WrenchSeries(Series):
    """Wrenches over time, such as the reaction of a constraint on its first frame.

    Parameters
    ----------
    frame_id : frame along whose axes they are given
    wrench : (T, 6) moment in N·m, of a reaction about the origin of the first frame; force in N
    """

    frame_id: str
    wrench: Floats

    @property
    def moment(self) -> Floats:
        """Moments (T, 3) in N·m."""
        return self.wrench[:, :3]

    @property
    def force(self) -> Floats:
        """Forces (T, 3) in N."""
        return self.wrench[:, 3:]


@dataclass(frozen=True)
class ContactSeries(Series):
    """Contacts over time, C in all.

    Parameters
    ----------
    frame_id : frame that points and vectors are given in
    at : (C,) index of the instant of each
    body : (C,) name of the body
    other : (C,) name of what it touches
    s : (C,) m along the body
    point, normal : (C, 3) m; from what is touched to the body
    gap : (C,) m, below zero by the depth
    normal_force : (C,) N on the body, along the normal
    friction, slip : (C, 3) N on the body; m/s of the body along the surface
    sticks : (C,) whether friction holds it
    """

    frame_id: str
    at: NDArray[np.int64]
    body: NDArray[np.str_]
    other: NDArray[np.str_]
    s: Floats
    point: Floats
    normal: Floats
    gap: Floats
    normal_force: Floats
    friction: Floats
    slip: Floats
    sticks: NDArray[np.bool_]

    @property
    def force(self) -> Floats:
        """Forces (C, 3) in N on the bodies."""
        return self.normal_force[:, None] * self.normal + self.friction

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Names (body, other) of what touches at any time, in the order in which it does first."""
        return tuple(dict.fromkeys(zip(self.body.tolist(), self.other.tolist(), strict=True)))

    def resultant(self, body: str, other: str) -> Floats:
        """Return the wrench (T, 6) on a body from what it touches; zero while it does not.

        Moment in N·m about the origin of the frame, force in N. Of two bodies that touch one
        another, each is the other's opposite.
        """
        out = np.zeros((len(self), 6))
        for sign, one, two in ((1.0, body, other), (-1.0, other, body)):
            own = (self.body == one) & (self.other == two)
            force = sign * self.force[own]
            each = np.concatenate([np.cross(self.point[own], force), force], axis=1)
            np.add.at(out, self.at[own], each)
            if body == other:
                break
        return out
