"""Write a self-contained page about a recording, and export its arrays."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from soft_sim_ros.commands.shell import DONE, verb


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Report on the recording named on the command line."""
    parser = argparse.ArgumentParser(prog="report", description=__doc__)
    parser.add_argument("recording", type=Path, help="rosbag2 directory, or one MCAP file")
    parser.add_argument(
        "--out", type=Path, metavar="FILE.html", help="the page (default: report.html beside it)"
    )
    parser.add_argument(
        "--picture", type=Path, metavar="FILE.png", help="the motion as a picture, too"
    )
    parser.add_argument("--csv", type=Path, metavar="DIR", help="tables, one file per topic")
    parser.add_argument("--npz", type=Path, metavar="FILE.npz", help="numpy arrays, one file")
    options = parser.parse_args(argv)
    from soft_sim_ros.recording.reader import read_run
    from soft_sim_ros.report import export_csv, export_npz, picture, write_report

    print(write_report(options.recording, options.out))
    if options.picture or options.csv or options.npz:
        run = read_run(options.recording)
        if options.picture:
            print(picture(run, options.picture))
        if options.csv:
            for path in export_csv(run, options.csv):
                print(path)
        if options.npz:
            print(export_npz(run, options.npz))
    return DONE
