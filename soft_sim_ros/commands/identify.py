"""Fit numbers of a scene, such as stiffness, damping, density, to a recorded motion."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from soft_sim_ros.batch.programme import Programme, read_programme
from soft_sim_ros.commands.progress import Line
from soft_sim_ros.commands.shell import DONE, verb
from soft_sim_ros.commands.warm_up import warm_up
from soft_sim_ros.core.analysis.identification import Fit
from soft_sim_ros.errors import CommandError
from soft_sim_ros.experiments.identification import identify
from soft_sim_ros.experiments.motions import TOPICS, Experiment, Measured, Recorded, read_motion
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.scene import load_scene, parse_scene
from soft_sim_ros.scene.edit import with_numbers


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Identify what the command line asks for."""
    parser = _parser()
    options = parser.parse_args(argv)
    tables = [options.scene, options.motion, options.commands]
    if any(tables) if options.recording is not None else None in tables[:2]:
        parser.error("expected a recording, or --scene with --motion (and --commands)")
    experiment: Experiment
    if options.recording is not None:
        experiment = Recorded(read_run(options.recording), options.observe)
    else:
        scene = load_scene(options.scene)
        programme = Programme(np.empty(0), np.empty((0, len(scene.actuators))))
        if options.commands is not None:
            names = [actuator.name for actuator in scene.actuators]
            safe = [actuator.safe for actuator in scene.actuators]
            programme = read_programme(options.commands, names, safe)
        experiment = Measured(scene, programme, *read_motion(options.motion))
    parameters = dict(_parameter(text) for text in options.parameter)
    warm_up(parse_scene(experiment.text, experiment.file))
    line = Line()
    found = identify(
        experiment,
        parameters,
        confidence=options.confidence,
        progress=lambda count: line.show(f"{count} simulations"),
    )
    line.clear()
    _tell(found)
    values = dict(zip(found.names, found.values.tolist(), strict=True))
    if options.json is not None:
        options.json.write_text(json.dumps(_plain(found), indent=2) + "\n")
        print(options.json)
    if options.out is not None:
        options.out.write_text(with_numbers(experiment.text, experiment.file, values))
        print(options.out)
    return DONE


def _tell(found: Fit) -> None:
    print(
        f"{found.observations} numbers, {found.evaluations} simulations; "
        f"left: {found.rms:.4g} m root mean square"
    )
    for name, value, (low, high) in zip(found.names, found.values, found.intervals, strict=True):
        print(f"{name} = {value:.6g}   {100 * found.confidence:g} %: {low:.6g} to {high:.6g}")
    for warning in found.warnings():
        print(f"warning: {warning}")


def _plain(found: Fit) -> dict[str, object]:
    """Return a fit as JSON can hold it: what is not finite becomes null."""
    return {
        "parameters": {
            name: {"value": value, "interval": [x if np.isfinite(x) else None for x in interval]}
            for name, value, interval in zip(
                found.names, found.values.tolist(), found.intervals.tolist(), strict=True
            )
        },
        "confidence": found.confidence,
        "correlation": found.correlation.tolist(),
        "unknown": [direction.tolist() for direction in found.unknown],
        "rms_m": found.rms,
        "observations": found.observations,
        "simulations": found.evaluations,
    }


def _parameter(text: str) -> tuple[str, float | None]:
    """Return key path and first guess of ``PATH`` or ``PATH=GUESS``."""
    path, given, guess = text.partition("=")
    try:
        return path, float(guess) if given else None
    except ValueError:
        raise CommandError("--parameter", f"{text!r}: expected PATH or PATH=NUMBER") from None


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="identify", description=__doc__)
    parser.add_argument(
        "recording", type=Path, nargs="?", help="rosbag2 directory, or one MCAP file"
    )
    parser.add_argument("--scene", help="instead of a recording: the scene, with --motion")
    parser.add_argument(
        "--motion", type=Path, metavar="FILE", help="measured positions, .csv or .npz"
    )
    parser.add_argument(
        "--commands", type=Path, metavar="FILE.csv", help="efforts over time, as for rollout"
    )
    parser.add_argument(
        "--parameter",
        action="append",
        required=True,
        metavar="PATH[=GUESS]",
        help="number of the scene to be fitted, such as materials.rubber.young_modulus; repeat",
    )
    parser.add_argument(
        "--observe", choices=TOPICS, default="backbone", help="which topic of the recording to fit"
    )
    parser.add_argument(
        "--confidence", type=_share, default=0.95, metavar="P", help="of the intervals (0.95)"
    )
    parser.add_argument("--out", type=Path, metavar="FILE.yaml", help="the scene with the results")
    parser.add_argument("--json", type=Path, metavar="FILE.json", help="the results")
    return parser


def _share(text: str) -> float:
    value = float(text)
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"{text}: expected a number between 0 and 1")
    return value
