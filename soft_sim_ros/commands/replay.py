"""Publish a recording again, with its types, qualities of service, timing and clock."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from soft_sim_ros.commands.shell import require_ros, verb


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Replay the recording named on the command line; ``--ros-args`` are ROS's."""
    argv = list(sys.argv[1:] if argv is None else argv)
    require_ros("replay")
    from soft_sim_ros.node.replay import main as replay

    return replay(argv)
