"""Publishers of ready-made bytes, which cost nothing while nobody listens."""

from __future__ import annotations

from collections import Counter
from importlib import import_module

from rosgraph_msgs.msg import Clock

from soft_sim_ros.node.quality import OVERRIDABLE, qos_profile
from soft_sim_ros.recording.cdr import ClockBuffer
from soft_sim_ros.recording.topics import Qos, Topic


def message_class(type_name: str):
    """Class of a message type such as ``geometry_msgs/msg/PoseArray``."""
    package, _, name = type_name.split("/")
    return getattr(import_module(f"{package}.msg"), name)


def offered(publisher, topic: Topic) -> Topic:
    """``topic`` with the quality of service that the publisher got after overrides."""
    got = publisher.qos_profile
    qos = Qos(
        depth=got.depth,
        reliability=got.reliability.name.lower(),
        durability=got.durability.name.lower(),
        history=got.history.name.lower(),
    )
    return Topic(topic.key, topic.name, topic.type, qos)


class Publishers:
    """Publishers of all outgoing topics of a node, by key, and of the clock.

    Parameters
    ----------
    node : rclpy.node.Node
        Owner of the publishers.
    topics : tuple of Topic
        What is published.
    clock : bool
        Whether this node owns time.
    """

    def __init__(self, node, topics: tuple[Topic, ...], clock: bool):
        self._publishers = {
            topic.key: node.create_publisher(
                message_class(topic.type),
                topic.name,
                qos_profile(topic.qos),
                qos_overriding_options=OVERRIDABLE,
            )
            for topic in topics
        }
        self.topics = tuple(offered(self._publishers[topic.key], topic) for topic in topics)
        self.sent: Counter[str] = Counter({topic.key: 0 for topic in topics})
        self._clock = None
        if clock:
            self._clock = node.create_publisher(
                Clock, "/clock", qos_profile(Qos()), qos_overriding_options=OVERRIDABLE
            )
            self._clock_bytes = ClockBuffer()
            self.sent["clock"] = 0
        self.after_tick: list = []

    def topic_name(self, key: str) -> str:
        """Full name of a topic, remappings included."""
        return str(self._publishers[key].topic_name)

    def wanted(self, key: str) -> bool:
        """Whether anybody listens."""
        return self._publishers[key].get_subscription_count() > 0

    def send(self, key: str, data: bytes) -> None:
        """Publish the bytes of one message."""
        self._publishers[key].publish(data)
        self.sent[key] += 1

    def tick(self, time_ns: int) -> None:
        """Move everybody's clock, after the state of that time has been sent."""
        for also in self.after_tick:
            also(time_ns)
        if self._clock is not None and self._clock.get_subscription_count():
            self._clock.publish(self._clock_bytes.fill(time_ns))
            self.sent["clock"] += 1
