"""The tip as a frame on /tf, where tf2_msgs is installed."""

from __future__ import annotations

from collections.abc import Callable

from geometry_msgs.msg import TransformStamped
from rclpy.event_handler import PublisherEventCallbacks

from soft_sim_ros.node.parameters import ParameterError
from soft_sim_ros.recording.decode import Poses, decode
from soft_sim_ros.recording.topics import POSE


class TipFrame:
    """Sends the transform from the frame of the poses to ``<node name>/tip``.

    The namespace is part of the child frame's name: ``left/soft_arm/tip`` for ``/left/soft_arm``.

    Parameters
    ----------
    node : rclpy.node.Node
        Owner of the publisher.
    frame_id : str
        Parent frame.
    tip_pose : callable
        Gives the pose of the tip as the bytes of a PoseStamped.
    matched : callable
        Told when listeners come and go.
    """

    def __init__(self, node, frame_id: str, tip_pose: Callable[[], bytes], matched):
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError as error:
            fault = "publish_tf = True: expected False, because tf2_msgs is not installed"
            raise ParameterError([fault]) from error
        self._tip_pose, self._message = tip_pose, TFMessage
        self._publisher = node.create_publisher(
            TFMessage, "/tf", 100, event_callbacks=PublisherEventCallbacks(matched=matched)
        )
        self._transform = TransformStamped()
        self._transform.header.frame_id = frame_id
        self._transform.child_frame_id = f"{node.get_fully_qualified_name().lstrip('/')}/tip"

    def send(self, time_ns: int) -> None:
        """Publish the present transform if anybody listens."""
        if not self._publisher.get_subscription_count():
            return
        pose = decode(POSE, self._tip_pose())
        assert isinstance(pose, Poses)
        x, y, z, qx, qy, qz, qw = (float(number) for number in pose.poses[0])
        transform = self._transform
        stamp = transform.header.stamp
        stamp.sec, stamp.nanosec = divmod(time_ns, 1_000_000_000)
        move, turn = transform.transform.translation, transform.transform.rotation
        move.x, move.y, move.z = x, y, z
        turn.x, turn.y, turn.z, turn.w = qx, qy, qz, qw
        self._publisher.publish(self._message(transforms=[transform]))
