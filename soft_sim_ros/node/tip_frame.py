"""Frames of the arm on /tf, where tf2_msgs is installed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geometry_msgs.msg import TransformStamped

from soft_sim_ros.foreign import shown
from soft_sim_ros.node.parameters import ParameterError
from soft_sim_ros.node.publishers import Matched, events
from soft_sim_ros.recording.telemetry import PoseSource
from soft_sim_ros.recording.topics import SENSORS
from soft_sim_ros.scene import Joint, RigidBody, Scene
from soft_sim_ros.scene.limbs import limbs_of

if TYPE_CHECKING:
    from soft_sim_ros.core.settled import Simulation

BASE, TIP, ALL = "base", "tip", "all"


class ArmFrames:
    """Sends transforms from the frame of the poses to ``<node name>/tip`` and further frames.

    Sensors whose readings are given in a frame have one, such as ``<node name>/sensors/imu``.
    Of several tips, each has a frame besides, such as ``<node name>/tip/left``. The namespace is
    part of a child frame's name: ``left/soft_arm/tip`` for ``/left/soft_arm``.

    Parameters
    ----------
    node : rclpy.node.Node
        Owner of the publisher.
    scene : Scene
        Its joints and rigid bodies have frames.
    frame_id : str
        Parent frame.
    chosen : str
        Names of joints and rigid bodies, with commas between them; ``all`` for all of them.
    backbone : int
        How many frames along the rods, base to tip, ``backbone_0`` and so on; 0 for none. Of
        several backbones, each has as many: ``backbone/left_0``.
    matched : callable
        Told when listeners come and go.
    """

    def __init__(
        self, node, scene: Scene, frame_id: str, chosen: str, backbone: int, matched: Matched
    ):
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError as error:
            fault = "publish_tf = True: expected False, because tf2_msgs is not installed"
            raise ParameterError([fault]) from error
        limbs = limbs_of(scene)
        self._names = [BASE, TIP, *chosen_frames(scene, chosen)]
        self._tips, self._backbones = limbs.several_tips, limbs.several_backbones
        self._backbone, self._message = backbone, TFMessage
        self._publisher = node.create_publisher(
            TFMessage, "/tf", 100, event_callbacks=events(matched, "tf")
        )
        prefix = node.get_fully_qualified_name().lstrip("/")
        names = self._names + [f"{TIP}/{name}" for name in self._tips]
        along = [f"backbone/{name}" for name in self._backbones] or ["backbone"]
        names += [f"{name}_{i}" for name in along for i in range(backbone)]
        names += [f"{SENSORS}/{one.name}" for one in scene.sensors if one.framed]
        self._transforms = [TransformStamped() for _ in names]
        for name, transform in zip(names, self._transforms, strict=True):
            transform.header.frame_id = frame_id
            transform.child_frame_id = f"{prefix}/{name}"
        self._simulation: Simulation | None = None

    def show(self, simulation: Simulation) -> None:
        """Look at a simulation from now on."""
        from soft_sim_ros.viewing.frames import Frames
        from soft_sim_ros.viewing.sensor_frames import SensorFrames

        spots = [(name, 0.0) for name in self._names]
        self._sources: list[PoseSource] = [Frames(simulation.compiled, simulation.q, spots)]
        if self._tips:
            self._sources.append(simulation.tips())
        for name in self._backbones or (None,) if self._backbone else ():
            self._sources.append(simulation.sampler(self._backbone, name))
        if any(one.framed for one in simulation.scene.sensors):
            self._sources.append(SensorFrames(simulation))
        self._simulation = simulation

    def send(self, time_ns: int) -> None:
        """Publish the present transforms if anybody listens."""
        if self._simulation is None or not self._publisher.get_subscription_count():
            return
        poses = [pose for source in self._sources for pose in source.poses().tolist()]
        sec, nanosec = divmod(time_ns, 1_000_000_000)
        for transform, (x, y, z, qx, qy, qz, qw) in zip(self._transforms, poses, strict=True):
            stamp = transform.header.stamp
            stamp.sec, stamp.nanosec = sec, nanosec
            move, turn = transform.transform.translation, transform.transform.rotation
            move.x, move.y, move.z = x, y, z
            turn.x, turn.y, turn.z, turn.w = qx, qy, qz, qw
        self._publisher.publish(self._message(transforms=self._transforms))


def chosen_frames(scene: Scene, chosen: str) -> list[str]:
    """Return the names that the parameter ``tf_frames`` asks for; refuse unknown ones."""
    known = [body.name for body in scene.bodies if isinstance(body, Joint | RigidBody)]
    asked = [name.strip() for name in chosen.split(",") if name.strip()]
    if asked == [ALL]:
        return known
    unknown = [name for name in asked if name not in known]
    if unknown:
        have = ", ".join(known) or "this scene has none"
        raise ParameterError(
            [
                f"tf_frames = {shown(chosen)}: expected names of joints and rigid bodies "
                f"({have}), or 'all', not {shown(unknown[0])}"
            ]
        )
    return list(dict.fromkeys(asked))
