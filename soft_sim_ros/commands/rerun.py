"""Simulate the recorded commands of the recorded scene again, and compare bit for bit."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from soft_sim_ros.commands.progress import Line
from soft_sim_ros.commands.shell import DONE, FAILED, verb
from soft_sim_ros.commands.warm_up import warm_up
from soft_sim_ros.experiments.resimulation import Comparison, recorded_scene, rerun
from soft_sim_ros.foreign import printable
from soft_sim_ros.recording.reader import read_run


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Compare the recording named on the command line with its re-simulation."""
    parser = argparse.ArgumentParser(prog="rerun", description=__doc__)
    parser.add_argument("recording", type=Path, help="rosbag2 directory, or one MCAP file")
    parser.add_argument(
        "--tolerance",
        type=float,
        default=1e-6,
        metavar="X",
        help="largest difference allowed where version or machine differ (default 1e-6, in the "
        "units of the topics); on the same machine and version not a bit may differ",
    )
    options = parser.parse_args(argv)
    run = read_run(options.recording)
    warm_up(recorded_scene(run))
    line = Line()
    comparison = rerun(run, progress=lambda t: line.show(f"t = {t:.2f} of {run.end:.2f} s"))
    line.clear()
    return tell(comparison, options.tolerance)


def tell(comparison: Comparison, tolerance: float) -> int:
    """Print what was found and give the exit code."""
    for name, recorded, here in comparison.facts:
        print(printable(f"differs: {name}: recorded with {recorded}, here {here}"))
    for topic, value in sorted(comparison.largest.items()):
        print(f"{value:12.3g}  largest difference on {printable(topic)}")
    if comparison.identical:
        print(f"identical: {comparison.messages} messages, 0 bits different")
        return DONE
    if comparison.messages == 0:
        print("nothing to compare: the recording holds no states")
        return FAILED
    assert comparison.first is not None
    time, topic = comparison.first
    print(
        f"{comparison.different} of {comparison.messages} messages differ, by up to "
        f"{comparison.difference:.3g}; the first at t = {time:.9g} s on {printable(topic)}"
    )
    if comparison.facts and comparison.difference <= tolerance:
        print(f"within the tolerance {tolerance:g} for another version or machine")
        return DONE
    return FAILED
