"""The other end of the wire: ``python -m benchmarks.node.peer ROLE``, until a line on its input.

ROLE is ``listen`` (hears poses and joint states) or ``drive`` (sends commands at 100 Hz).
``ready`` is printed when the peer stands, and one line of JSON at the end.
"""

from __future__ import annotations

import json
import math
import sys
import threading
import time

import rclpy
from geometry_msgs.msg import PoseArray
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

ARM = "/soft_arm"
RATE = 100.0  # Hz of commands
AMPLITUDES = (0.8, 0.8, 0.4, 0.4, 0.2, 0.2)  # N·m, of the default arm


class Listener:
    """Counts what it hears, undecoded, and notes when the first pose came."""

    def __init__(self, node: Node) -> None:
        self.result: dict[str, float | None] = {"poses": 0, "joint_states": 0, "first_pose": None}
        for kind, topic, key in (
            (PoseArray, f"{ARM}/backbone", "poses"),
            (JointState, "/joint_states", "joint_states"),
        ):
            node.create_subscription(kind, topic, lambda _, key=key: self._hear(key), 100, raw=True)

    def _hear(self, key: str) -> None:
        self.result[key] = (self.result[key] or 0) + 1
        if key == "poses" and self.result["first_pose"] is None:
            self.result["first_pose"] = time.monotonic()
            print("pose", flush=True)


class Driver:
    """Sends all six torques, each a sine, at an even pace from a thread of its own."""

    def __init__(self, node: Node, stop: threading.Event) -> None:
        self.result: dict[str, float | None] = {"commands": 0}
        self._publisher = node.create_publisher(Float64MultiArray, f"{ARM}/command", 1)
        self._stop = stop
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        begin, k = time.monotonic(), 0
        while not self._stop.is_set():
            t = k / RATE
            data = [a * math.sin(2.0 * math.pi * 0.5 * t + i) for i, a in enumerate(AMPLITUDES)]
            if self._publisher.get_subscription_count():
                self._publisher.publish(Float64MultiArray(data=data))
                self.result["commands"] = (self.result["commands"] or 0) + 1
            k += 1
            time.sleep(max(0.0, begin + k / RATE - time.monotonic()))


def main() -> None:
    """Play the role until a line, or the end, comes from standard input."""
    role = sys.argv[1]
    rclpy.init(args=[])
    node = Node(f"bench_{role}")
    stop = threading.Event()
    player = Listener(node) if role == "listen" else Driver(node, stop)

    def wait() -> None:
        sys.stdin.readline()
        stop.set()

    threading.Thread(target=wait, daemon=True).start()
    executor = EventsExecutor()
    executor.add_node(node)
    print("ready", flush=True)
    while not stop.is_set():
        executor.spin_once(timeout_sec=0.05)
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()
    print(json.dumps(player.result), flush=True)


if __name__ == "__main__":
    main()
