"""Run the simulator node until it is stopped."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from soft_sim_ros.commands.shell import require_ros, verb


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Run the node with ``--ros-args`` as given."""
    argv = list(sys.argv[1:] if argv is None else argv)
    require_ros("simulate")
    from soft_sim_ros.node import main as simulate

    return simulate(argv)
