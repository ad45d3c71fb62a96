"""Poses of frames of an arm and how fast they move."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.viewing.frames import Frames, Spot

if TYPE_CHECKING:
    from collections.abc import Sequence

    from soft_sim_ros.core.simulation.simulation import Simulation

_STEP = 1e-4  # by which the fastest coordinate is moved to find velocities


class MovingFrames:
    """Poses and twists of spots of a simulated arm.

    Parameters
    ----------
    simulation : the arm
    spots : P of them, as for `Frames`
    """

    def __init__(self, simulation: Simulation, spots: Sequence[Spot]) -> None:
        self._simulation = simulation
        self._q = np.zeros(simulation.n_coordinates)
        self._frames = Frames(simulation.compiled, self._q, spots)

    def look(self) -> tuple[Floats, Floats]:
        """Return poses and twists now, in the world.

        Twists are the central difference of the poses along the present rates, over so short a
        time that the error is of the order of 1e-8.

        Returns
        -------
        poses : (P, 7) x y z qx qy qz qw, m
        twists : (P, 6) velocity of the origin in m/s, then angular velocity in rad/s
        """
        q, v = np.array(self._simulation.q), np.array(self._simulation.v)
        fastest = np.abs(v).max(initial=0.0)
        poses = self._at(q)
        if fastest == 0.0:
            return poses, np.zeros((len(poses), 6))
        h = _STEP / fastest
        before, after = self._at(q - h * v), self._at(q + h * v)
        twists = np.empty((len(poses), 6))
        twists[:, :3] = (after[:, :3] - before[:, :3]) / (2.0 * h)
        turn = Rotation.from_quat(after[:, 3:]) * Rotation.from_quat(before[:, 3:]).inv()
        twists[:, 3:] = turn.as_rotvec() / (2.0 * h)
        return poses, twists

    def _at(self, q: Floats) -> Floats:
        self._q[:] = q
        return self._frames.poses().copy()
