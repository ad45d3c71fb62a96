"""Turn a torn recording, one that was never closed, into a clean one that other tools open."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from soft_sim_ros.commands.shell import DONE, verb
from soft_sim_ros.foreign import printable


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Recover the recording named on the command line."""
    parser = argparse.ArgumentParser(prog="recover", description=__doc__)
    parser.add_argument("recording", type=Path, help="rosbag2 directory, or one MCAP file")
    parser.add_argument(
        "--out",
        type=Path,
        help="where the clean recording goes (default: <recording>_recovered); the same directory "
        "means in place, with the original files moved aside",
    )
    options = parser.parse_args(argv)
    from soft_sim_ros.recording.recover import recover

    result = recover(options.recording, options.out)
    state = "was torn" if result.torn else "was whole"
    lost = f", {result.damaged_chunks} damaged parts left out" if result.damaged_chunks else ""
    print(f"{options.recording} {state}{lost}")
    for topic, count in sorted(result.counts.items()):
        print(f"{count:8d}  {printable(topic)}")
    print(f"{result.messages:8d}  messages up to t = {result.last_time:.9g} s")
    left = options.out is not None and result.backup is None and not result.torn
    same = left and result.directory == options.recording.resolve() and not result.damaged_chunks
    print(f"{'left as it is' if same else 'clean recording'}: {result.directory}")
    if result.backup is not None:
        print(f"original files:  {result.backup}")
    return DONE
