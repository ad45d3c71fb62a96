"""The command line of the simulator: its help, and the arguments that it refuses."""

from __future__ import annotations

import argparse

from soft_sim_ros.foreign import one_line
from soft_sim_ros.node.parameters import TABLE
from soft_sim_ros.node.start import Parser, StartError


def check_assignments(args: list[str]) -> None:
    """Refuse NAME:=VALUE of a parameter without -p: rcl would take it for a remapping."""
    names = {row.name for row in TABLE}
    for before, word in zip(["", *args], args, strict=False):
        if word.split(":=")[0] in names and ":=" in word and before not in ("-p", "--param"):
            word = one_line(word)
            raise StartError(f"{word} changes nothing; did you mean --ros-args -p {word}?")


def parser() -> Parser:
    """Give the parser of what is not for ROS."""
    rows = "\n".join(f"  {row.name:17} {row.default!r:11} {row.description}" for row in TABLE)
    return Parser(
        prog="simulate",
        usage="%(prog)s [-h] [--ros-args -p NAME:=VALUE -r __ns:=/NAME …]",
        description=f"Run the simulator node until it is stopped.\n\n"
        f"Parameters, with their defaults:\n{rows}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
