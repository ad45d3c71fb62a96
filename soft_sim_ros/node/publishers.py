"""Publishers of ready-made bytes, which cost nothing without subscribers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.qos import DurabilityPolicy
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


# told of a topic, by key, whose listeners have changed
Matched = Callable[[str, Any], None]


def events(matched: Matched, key: str) -> PublisherEventCallbacks:
    """Have a publisher tell when listeners come and go."""
    return PublisherEventCallbacks(matched=partial(matched, key))


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
        self._joined: dict[str, int] = {}
        self._publishers = {
            topic.key: node.create_publisher(
                message_class(topic.type),
                topic.name,
                qos_profile(topic.qos),
                event_callbacks=events(self.matched, topic.key),
                qos_overriding_options=OVERRIDABLE,
            )
            for topic in topics
        }
        self.topics = tuple(offered(self._publishers[topic.key], topic) for topic in topics)
        self.sent: Counter[str] = Counter({topic.key: 0 for topic in topics})
        self._clock = None
        if clock:
            self._clock = node.create_publisher(
                Clock,
                "/clock",
                qos_profile(Qos()),
                event_callbacks=events(self.matched, "clock"),
                qos_overriding_options=OVERRIDABLE,
            )
            self._clock_bytes = ClockBuffer()
            kept = self._clock.qos_profile.durability
            self._clock_latched = kept == DurabilityPolicy.TRANSIENT_LOCAL
            self.sent["clock"] = 0
        self._latched = {
            topic.key for topic in self.topics if topic.qos.durability == "transient_local"
        }
        self.after_tick: list[Callable[[int], None]] = []

    def topic_name(self, key: str) -> str:
        """Full name of a topic, remappings included."""
        return str(self._publishers[key].topic_name)

    def wanted(self, key: str) -> bool:
        """Whether anybody listens, or may come later and wants the last messages then."""
        return key in self._latched or self._publishers[key].get_subscription_count() > 0

    def joined(self) -> dict[str, int]:
        """Count who has ever begun to listen, by key: of topics, ``clock``, VIEWS (outlet.py)."""
        return dict(self._joined)

    def matched(self, key: str, status) -> None:
        """Take note of listeners that come; those who go are in the count as well."""
        self._joined[key] = status.total_count

    def send(self, key: str, data: bytes) -> None:
        """Publish the bytes of one message."""
        self._publishers[key].publish(data)
        self.sent[key] += 1

    def tick(self, time_ns: int) -> None:
        """Send what follows the state of that time."""
        for also in self.after_tick:
            also(time_ns)

    def clock(self, time_ns: int) -> None:
        """Publish the time on the clock, after the state of that time was sent."""
        if self._clock is not None and (
            self._clock_latched or self._clock.get_subscription_count()
        ):
            self._clock.publish(self._clock_bytes.fill(time_ns))
            self.sent["clock"] += 1
