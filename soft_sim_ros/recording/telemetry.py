"""The outgoing messages of one simulation, as bytes, built only when asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.simulation.simulation import LEDGER
from soft_sim_ros.recording.cdr import (
    Float64MultiArrayBuffer,
    JointStateBuffer,
    PoseArrayBuffer,
    PoseStampedBuffer,
)
from soft_sim_ros.recording.topics import output_topics

Floats = NDArray[np.float64]


class PoseSource(Protocol):
    """What Telemetry needs of a ``Sampler``."""

    def poses(self) -> Floats:
        """Give the poses (N, 7) along the arm, base to tip."""


class Observable(Protocol):
    """What Telemetry needs of a ``Simulation``."""

    @property
    def time_ns(self) -> int:
        """Simulation time in ns."""

    @property
    def q(self) -> Floats:
        """Generalised coordinates (n,)."""

    @property
    def v(self) -> Floats:
        """Their rates (n,)."""

    @property
    def coordinate_names(self) -> Sequence[str]:
        """Names of the coordinates."""

    @property
    def actuator_names(self) -> Sequence[str]:
        """Names of the actuators."""

    def sampler(self, poses: int) -> PoseSource:
        """Give a sampler of ``poses`` poses, equally spaced in arc length."""

    def ports(self) -> tuple[Floats, Floats, Floats]:
        """Give position, velocity and effort of every actuator."""

    def ledger(self) -> Floats:
        """Give the energy ledger in J, in the order of ``LEDGER``."""


class Telemetry:
    """Bytes of every outgoing message of one simulation, at its present time.

    Each method builds one message anew from the present state; what is not asked for is not
    built. The same bytes go to the publisher and to the recording.

    Parameters
    ----------
    simulation : the simulation that is watched
    poses : number of backbone poses N, at least 2
    frame_id : frame the poses are given in
    prefix : full name of the node, such as ``/arm1/soft_arm``
    one_label : whether ``energy`` has its names in one label, as in recordings of old
    """

    def __init__(
        self,
        simulation: Observable,
        poses: int,
        frame_id: str,
        prefix: str,
        one_label: bool = False,
    ) -> None:
        if poses < 2:
            raise ValueError(f"poses = {poses}: expected at least 2, the base and the tip")
        self.topics = output_topics(prefix)
        self.offset_ns = 0  # from simulation time to stamps
        self._simulation = simulation
        self._sampler = simulation.sampler(poses)
        self._backbone = PoseArrayBuffer(frame_id, poses)
        self._tip = PoseStampedBuffer(frame_id)
        self._joints = JointStateBuffer(simulation.actuator_names)
        self._strains = JointStateBuffer(simulation.coordinate_names, effort=False)
        self._energy = Float64MultiArrayBuffer(
            len(LEDGER), ",".join(LEDGER) if one_label else LEDGER
        )
        self._posed_for: bytes | None = None
        self._poses: Floats = np.empty((poses, 7))

    @property
    def stamp_ns(self) -> int:
        """Time that the messages of the present state carry, ns."""
        return self._simulation.time_ns + self.offset_ns

    def _sample(self) -> Floats:
        """Give the poses (N, 7); the backbone and the tip of one state share one sampling."""
        configuration = self._simulation.q.tobytes()
        if configuration != self._posed_for:
            self._poses = self._sampler.poses()
            self._posed_for = configuration
        return self._poses

    def backbone(self) -> bytes:
        """Poses along the arm, a PoseArray."""
        return self._backbone.fill(self.stamp_ns, self._sample())

    def tip_pose(self) -> bytes:
        """Pose of the tip, a PoseStamped."""
        return self._tip.fill(self.stamp_ns, self._sample()[-1])

    def joint_states(self) -> bytes:
        """Conjugate position, velocity and effort of every actuator, a JointState."""
        return self._joints.fill(self.stamp_ns, *self._simulation.ports())

    def strain_state(self) -> bytes:
        """Generalised coordinates and their rates, a JointState without efforts."""
        return self._strains.fill(self.stamp_ns, self._simulation.q, self._simulation.v)

    def energy(self) -> bytes:
        """Energy ledger in J, a Float64MultiArray with a label for every number."""
        return self._energy.fill(self._simulation.ledger())
