"""Another process of the demo: hears a replay as any ROS node would, and counts what it hears.

``python -m soft_sim_ros.commands.listen TOPIC LAST``: until a PoseArray stamped ``LAST`` ns or more
has come; what was heard is printed as one line of JSON.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence

import rclpy
from geometry_msgs.msg import PoseArray

PATIENCE = 15.0  # s of real time without a message
START = 120.0  # s until the first one: the replay may be slow to start on a busy machine


def main(argv: Sequence[str] | None = None) -> int:
    """Listen to the topic on the command line."""
    topic, last = sys.argv[1:] if argv is None else argv
    rclpy.init(args=[])
    node = rclpy.create_node("listener")
    heard = ordered = 0
    stamp = -1
    deadline = time.monotonic() + START

    def on_shape(message: PoseArray) -> None:
        nonlocal heard, ordered, stamp, deadline
        now = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        heard, ordered = heard + 1, ordered + (now >= stamp)
        stamp, deadline = now, time.monotonic() + PATIENCE

    try:
        node.create_subscription(PoseArray, topic, on_shape, 1000)
        print("listening", flush=True)
        while stamp < int(last) and time.monotonic() < deadline:
            rclpy.spin_once(node, timeout_sec=0.1)
    except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        return 130
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    print(json.dumps({"heard": heard, "in_order": ordered == heard}), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
