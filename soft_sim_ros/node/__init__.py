"""The only room where rclpy lives: the simulator node and the player of recordings."""

from __future__ import annotations

import gc


def main(args: list[str] | None = None) -> int:
    """Run the simulator node until it is stopped; the result is the exit code."""
    gc.disable()  # until the arm runs: what a start makes stays, there is nothing to collect
    try:
        from soft_sim_ros.node.simulate import main as simulate

        return simulate(args)
    finally:
        gc.enable()
