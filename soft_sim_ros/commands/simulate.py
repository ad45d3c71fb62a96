"""Run the simulator node until it is stopped."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from soft_sim_ros.commands.shell import require_ros, verb


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Run the node with ``--ros-args`` as given."""
    argv = list(sys.argv[1:] if argv is None else argv)
    require_ros("simulate")
    from rclpy.utilities import remove_ros_args

    from soft_sim_ros.node.parameters import TABLE
    from soft_sim_ros.node.simulate import main as simulate

    rows = "\n".join(f"  {row.name:17} {row.default!r:11} {row.description}" for row in TABLE)
    parser = argparse.ArgumentParser(
        prog="simulate",
        usage="%(prog)s [-h] [--ros-args -p NAME:=VALUE …]",
        description=f"{__doc__}\n\nParameters, with their defaults:\n{rows}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.parse_args(remove_ros_args(["simulate", *argv])[1:])
    return simulate(argv)
