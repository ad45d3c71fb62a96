"""Write a scene as URDF, for robot_state_publisher, MoveIt and ros2_control."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from soft_sim_ros.commands.shell import DONE, verb
from soft_sim_ros.files import write_whole


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Write the URDF of the scene that the command line names."""
    parser = argparse.ArgumentParser(prog="urdf", description=__doc__)
    parser.add_argument("scene", help="scene file, or the name of one in the config folder")
    parser.add_argument("--out", type=Path, metavar="FILE.urdf", help="the file (default: print)")
    parser.add_argument(
        "--frame", default="world", metavar="NAME", help="root link: the node's frame_id (world)"
    )
    parser.add_argument(
        "--node", default="/soft_arm", metavar="NAME", help="full name of the node (/soft_arm)"
    )
    options = parser.parse_args(argv)
    from soft_sim_ros.core.accuracy.contract import settle
    from soft_sim_ros.core.compile.scene import compile_scene
    from soft_sim_ros.scene import load_scene
    from soft_sim_ros.viewing.urdf import Urdf

    compiled = compile_scene(settle(load_scene(options.scene)))
    text = Urdf(compiled, options.frame, options.node).build()
    if options.out is None:
        print(text, end="")
    else:
        write_whole(options.out, text)
        print(options.out)
    return DONE
