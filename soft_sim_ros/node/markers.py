"""The arm as markers, for RViz and Foxglove."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from soft_sim_ros.node.publishers import Matched, events, message_class
from soft_sim_ros.node.quality import OVERRIDABLE, qos_profile
from soft_sim_ros.recording.cdr_markers import MarkerArrayBuffer
from soft_sim_ros.recording.topics import FIXED_MARKERS, MARKERS, topic

if TYPE_CHECKING:
    from soft_sim_ros.core.settled import Simulation
    from soft_sim_ros.viewing.scenery import Scenery
    from soft_sim_ros.viewing.shapes import Shape

_SECOND = 1_000_000_000  # ns


class Markers:
    """Publishes the arm as markers while there are subscribers.

    Parameters
    ----------
    node : rclpy.node.Node
        Owner of the publishers.
    frame_id : str
        Frame of all poses and points.
    rate : float
        Messages per real second, at most; Hz.
    at_once : callable
        Whether every state counts, as while paused: then it is sent whatever the rate.
    matched : callable
        Told when listeners come and go.
    """

    def __init__(
        self, node, frame_id: str, rate: float, at_once: Callable[[], bool], matched: Matched
    ):
        self._frame_id, self._at_once = frame_id, at_once
        self._period_ns, self._due_ns = round(_SECOND / rate), 0
        prefix = node.get_fully_qualified_name()
        self._moving, self._fixed = (
            node.create_publisher(
                message_class(one.type),
                one.name,
                qos_profile(one.qos),
                event_callbacks=events(matched, key),
                qos_overriding_options=OVERRIDABLE,
            )
            for key, one in (
                ("markers", topic(MARKERS, prefix)),
                ("fixed", topic(FIXED_MARKERS, prefix)),
            )
        )
        self._simulation: Simulation | None = None
        self._scenery: Scenery | None = None
        self._message: MarkerArrayBuffer | None = None
        self.sent = 0

    def show(self, simulation: Simulation) -> None:
        """Look at a simulation from now on, and send what of it never moves."""
        from soft_sim_ros.viewing.scenery import plates
        from soft_sim_ros.viewing.surroundings import surroundings

        self._simulation = simulation
        found = plates(simulation) + surroundings(simulation.scene, simulation.length)
        if found:
            message = MarkerArrayBuffer(self._frame_id, [_marker(shape) for shape, _ in found])
            for slate, (_, pose) in zip(message.slates, found, strict=True):
                slate.pose[:] = pose
            self._fixed.publish(message.bytes(0))  # at any time: fixed things have no stamp

    def send(self, time_ns: int) -> None:
        """Publish the present state, if it is due and anybody listens."""
        now = time.monotonic_ns()
        if now < self._due_ns and not self._at_once():
            return
        if self._simulation is None or not self._moving.get_subscription_count():
            return
        self._due_ns = max(self._due_ns + self._period_ns, now)
        if self._scenery is None or self._message is None:  # built for the first who looks
            from soft_sim_ros.viewing.scenery import Scenery

            self._scenery = Scenery(self._simulation)
            shapes = [_marker(part.shape) for part in self._scenery.parts]
            self._message = MarkerArrayBuffer(self._frame_id, shapes)
        self._scenery.draw(self._message.slates)
        self._moving.publish(self._message.bytes(time_ns))
        self.sent += 1


def _marker(shape: Shape):
    return shape.group, shape.number, shape.kind, shape.scale, shape.colour, shape.points
