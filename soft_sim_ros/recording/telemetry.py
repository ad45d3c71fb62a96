"""The outgoing messages of one simulation, as bytes, built only when asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.simulation.simulation import LEDGER
from soft_sim_ros.recording.cdr import (
    Float64MultiArrayBuffer,
    JointStateBuffer,
    PoseArrayBuffer,
    PoseStampedBuffer,
    WrenchStampedBuffer,
)
from soft_sim_ros.recording.cloud import CloudBuffer
from soft_sim_ros.recording.topics import BACKBONE, REACTION, TIP_POSE, output_topics
from soft_sim_ros.scene.limbs import CHAIN, Limbs

Floats = NDArray[np.float64]


class PoseSource(Protocol):
    """What Telemetry needs of ``Frames``."""

    def poses(self) -> Floats:
        """Give poses (N, 7), such as those along the arm, base to tip."""


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

    def sampler(self, poses: int, backbone: str | None = None) -> PoseSource:
        """Give a sampler of ``poses`` poses, equally spaced in arc length; of the last backbone."""

    def tips(self) -> PoseSource:
        """Give a sampler of all tips."""

    def ports(self) -> tuple[Floats, Floats, Floats]:
        """Give position, velocity and effort of every actuator."""

    def driven(self) -> tuple[Floats, Floats, Floats]:
        """Give those of driven coordinates that follow commands, if there are any."""

    def contacts(self) -> Sequence[Any]:
        """Give what touches now."""

    def reactions(self) -> Mapping[str, Any]:
        """Give what every constraint does now."""

    def ledger(self) -> Floats:
        """Give the energy ledger in J, in the order of ``LEDGER``."""


class Telemetry:
    """Bytes of every outgoing message of one simulation, at its present time.

    Each method builds one message anew from the present state; what is not asked for is not
    built. The same bytes go to the publisher and to the recording.

    Parameters
    ----------
    simulation : the simulation that is watched
    poses : number of poses N of a backbone, at least 2
    frame_id : frame the poses are given in
    prefix : full name of the node, such as ``/arm1/soft_arm``
    one_label : whether ``energy`` has its names in one label, as in recordings of old
    limbs : backbones and tips of the scene

    Attributes
    ----------
    topics : what there is
    builders : key of a topic → the method that builds its message
    """

    def __init__(
        self,
        simulation: Observable,
        poses: int,
        frame_id: str,
        prefix: str,
        one_label: bool = False,
        *,
        limbs: Limbs = CHAIN,
    ) -> None:
        if poses < 2:
            raise ValueError(f"poses = {poses}: expected at least 2, the base and the tip")
        self.topics = output_topics(prefix, limbs)
        self.offset_ns = 0  # from simulation time to stamps
        self._simulation = simulation
        names = limbs.several_backbones
        self._shapes = {
            name: _Sampled(simulation, simulation.sampler(poses, name)) for name in names
        }
        self._shape = (
            self._shapes[names[-1]] if names else _Sampled(simulation, simulation.sampler(poses))
        )
        # the end of a chain is the last of its poses, whose sampling it shares
        self._tips = _Sampled(simulation, simulation.tips()) if limbs.branched else self._shape
        self._backbone = PoseArrayBuffer(frame_id, poses)
        self._tip = PoseStampedBuffer(frame_id)
        self._driven = bool(limbs.commanded)
        self._joints = JointStateBuffer((*simulation.actuator_names, *limbs.commanded))
        self._strains = JointStateBuffer(simulation.coordinate_names, effort=False)
        self._energy = Float64MultiArrayBuffer(
            len(LEDGER), ",".join(LEDGER) if one_label else LEDGER
        )
        self._wrench, self._reactions = WrenchStampedBuffer(frame_id), _Felt(simulation)
        if limbs.touches:
            self._cloud = CloudBuffer(frame_id, limbs.bodies, limbs.shapes)
        self.builders: dict[str, Callable[[], bytes]] = {}
        tips = {f"{TIP_POSE}/{name}": i for i, name in enumerate(limbs.tips)}
        for one in self.topics:
            if one.key.startswith(f"{BACKBONE}/"):
                self.builders[one.key] = partial(self.backbone, one.key.partition("/")[2])
            elif one.key.startswith(f"{REACTION}/"):
                self.builders[one.key] = partial(self.reaction, one.key.partition("/")[2])
            elif one.key in tips:
                self.builders[one.key] = partial(self.tip_pose, tips[one.key])
            else:
                self.builders[one.key] = getattr(self, one.key)

    @property
    def stamp_ns(self) -> int:
        """Time that the messages of the present state carry, ns."""
        return self._simulation.time_ns + self.offset_ns

    def backbone(self, name: str | None = None) -> bytes:
        """Poses along a backbone, a PoseArray; by default the last one, of a chain the only one."""
        shape = self._shape if name is None else self._shapes[name]
        return self._backbone.fill(self.stamp_ns, shape.poses())

    def tip_pose(self, index: int = -1) -> bytes:
        """Pose of a tip, a PoseStamped; by default of the last one."""
        return self._tip.fill(self.stamp_ns, self._tips.poses()[index])

    def joint_states(self) -> bytes:
        """Conjugate position, velocity and effort of every port, a JointState.

        Actuators, then driven coordinates that follow commands.
        """
        ports = self._simulation.ports()
        if self._driven:
            both = zip(ports, self._simulation.driven(), strict=True)
            position, rate, effort = (np.concatenate(pair) for pair in both)
            return self._joints.fill(self.stamp_ns, position, rate, effort)
        return self._joints.fill(self.stamp_ns, *ports)

    def strain_state(self) -> bytes:
        """Generalised coordinates and their rates, a JointState without efforts."""
        return self._strains.fill(self.stamp_ns, self._simulation.q, self._simulation.v)

    def contacts(self) -> bytes:
        """Contacts, a PointCloud2 with a point for each of them."""
        return self._cloud.fill(self.stamp_ns, self._simulation.contacts())

    def reaction(self, name: str) -> bytes:
        """Reaction of a constraint on its first frame, a WrenchStamped along the world's axes."""
        found = self._reactions.now()[name]
        return self._wrench.fill(self.stamp_ns, np.concatenate([found.moment, found.force]))

    def energy(self) -> bytes:
        """Energy ledger in J, a Float64MultiArray with a label for every number."""
        return self._energy.fill(self._simulation.ledger())


class _Sampled:
    """Poses of a simulation, sampled once for every state."""

    def __init__(self, simulation: Observable, source: PoseSource) -> None:
        self._simulation, self._source = simulation, source
        self._posed_for: bytes | None = None
        self._poses: Floats = np.empty((0, 7))

    def poses(self) -> Floats:
        """Give the poses (N, 7) of the present state."""
        configuration = self._simulation.q.tobytes()
        if configuration != self._posed_for:
            self._poses = self._source.poses()
            self._posed_for = configuration
        return self._poses


class _Felt:
    """Reactions of a simulation, found once for every state."""

    def __init__(self, simulation: Observable) -> None:
        self._simulation = simulation
        self._found_for: tuple[int, bytes, bytes] | None = None
        self._found: Mapping[str, Any] = {}

    def now(self) -> Mapping[str, Any]:
        """Give those of the present state."""
        simulation = self._simulation
        state = simulation.time_ns, simulation.q.tobytes(), simulation.v.tobytes()
        if state != self._found_for:
            self._found, self._found_for = simulation.reactions(), state
        return self._found
