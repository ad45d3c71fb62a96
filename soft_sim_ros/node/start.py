"""What every program with a node does first."""

from __future__ import annotations

import argparse

import rclpy
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from soft_sim_ros.errors import SoftSimError


class StartError(SoftSimError):
    """ROS cannot make sense of its arguments, or cannot start."""


def start(parser: argparse.ArgumentParser, args: list[str]) -> argparse.Namespace:
    """Parse the arguments that are not for ROS, and initialise rclpy with the others.

    Signal handlers are left to the caller.
    """
    try:
        options = parser.parse_args(remove_ros_args([parser.prog, *args])[1:])
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except (RuntimeError, ValueError) as error:  # what rcl says has these for bases, and a path
        raise StartError(f"cannot start: {error}") from error
    return options
