"""What calls the callbacks of the node."""

from __future__ import annotations

from rclpy.executors import SingleThreadedExecutor


def make_executor():
    """Make the cheap executor where rclpy has it."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()
