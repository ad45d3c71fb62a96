"""Simulate as fast as possible into recordings, without ROS: one scene, or many."""

from __future__ import annotations

import argparse
import math
import time
import warnings
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from soft_sim_ros.batch.batch import run_batch
from soft_sim_ros.batch.rollout import Rollout
from soft_sim_ros.batch.run import COMPLETED, Run
from soft_sim_ros.batch.sweep import read_sweep, runs_of
from soft_sim_ros.commands.felt import felt_lines
from soft_sim_ros.commands.progress import Line, bar
from soft_sim_ros.commands.shell import DONE, FAILED, verb
from soft_sim_ros.commands.warm_up import warm_up
from soft_sim_ros.core.analysis.modes import long_step
from soft_sim_ros.errors import SoftSimError
from soft_sim_ros.recording.claims import MOST_POSES


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Make the run, or the batch of runs, that the command line describes."""
    parser = _parser()
    options = parser.parse_args(argv)
    many = options.sweep or len(options.scene) > 1 or options.dask or options.jobs
    if not options.scene and not options.sweep:
        parser.error("a scene is missing, or --sweep FILE")
    given = {
        key: getattr(options, key)
        for key in ("commands", "publish_rate", "poses", "max_error")
        if getattr(options, key) is not None
    }
    if options.estimate:
        given.setdefault("max_error", math.inf)
    if options.no_space:
        given["space"] = False
    if options.sweep:
        runs = read_sweep(options.sweep, options.scene, options.duration)
        runs = [replace(run, **given) for run in runs]
    elif options.duration is None:
        parser.error("the following arguments are required: --duration")
    else:
        runs = runs_of(options.scene, duration=options.duration, **given)
    return _batch(runs, options) if many else _one(runs[0], options.out)


def _one(run: Run, out: Path) -> int:
    scene = run.scene()
    programme = run.programme(scene)
    warm_up(scene)
    line = Line()
    rollout = Rollout(
        scene,
        out,
        programme,
        publish_rate=run.publish_rate,
        poses=run.poses,
        max_error=run.max_error,
        duration=run.duration,
        space=run.space,
        say=line.show,
    )
    line.clear()
    begin = time.monotonic()

    def progress(now: float) -> None:
        speed = now / max(time.monotonic() - begin, 1e-9)
        line.show(f"t = {now:.2f} of {run.duration:g} s, {speed:.3g} x real time")

    try:
        simulation = rollout.simulation
        doubt = long_step(simulation.dynamics, simulation.q, simulation.scene.numerics)
        if doubt:
            warnings.warn(doubt, stacklevel=2)
        summary = rollout.run(run.duration, progress)
    except BaseException as ending:
        rollout.close(ending)
        line.clear()
        _losses(rollout)
        raise
    line.clear()
    kept, residual = summary["recording"], summary["energy_residual_J"]
    print(
        f"{summary['scene']}: {summary['simulated_s']:.6g} s in {summary['running_s']:.3g} s, "
        f"{summary['real_time_factor'] or 0:.3g} x real time; "
        f"energy residual {math.nan if residual is None else residual:.3g} J"
    )
    if summary["estimate"]:
        error = summary["estimate"]["error_rel"]
        print(f"estimate of the tip's error in time: {error:.2g} of the length")
    if summary["accuracy"]:
        known = summary["accuracy"]
        print(
            "estimate of the tip's error: {error_rel:.2g} of the length, "
            "tolerance {tolerance:g}".format_map(known)
        )
        if "error_rad" in known:
            print(
                "estimate of the tip's turn: {error_rad:.2g} rad, "
                "tolerance {orientation_tolerance:g}".format_map(known)
            )
    if summary["space"] and summary["space"]["error_rel"] is not None:
        error = summary["space"]["error_rel"]
        print(f"estimate of the tip's error in space: {error:.2g} of the length")
    arm = rollout.simulation
    if arm.scene.constraints or arm.scene.touches:
        reactions = arm.reactions() if arm.scene.constraints else {}
        print("\n".join(felt_lines(arm.scene, reactions, arm.contacts())))
    if unresolved := rollout.doubt():
        warnings.warn(unresolved, stacklevel=2)
    print(f"{kept['recorded']} messages recorded in {kept['directory']}")
    return FAILED if _losses(rollout) else DONE


def _losses(rollout: Rollout) -> bool:
    """Say what of a run did not reach the disk, and tell whether there is any such thing."""
    kept = rollout.summary()["recording"]
    lost = bool(kept["dropped"] or kept["error"])
    with suppress(OSError):  # the terminal may be gone
        if lost:
            print(f"error: {kept['dropped']} messages lost: {kept['error']}")
        if not kept["complete"] and kept["recorded"]:
            print("the recording lacks its end: `recover` makes a clean one of what is there")
        if rollout.no_summary:
            print(f"error: no summary: {rollout.no_summary}")
    return lost or rollout.no_summary is not None


def _batch(runs: list[Run], options: argparse.Namespace) -> int:
    with suppress(SoftSimError):  # the run itself will report it
        warm_up(runs[0].scene())  # compiled here once, not by every process
    line = Line()
    begin = time.monotonic()
    count: Counter[str] = Counter()
    before: list[int] = []

    def progress(done: int, total: int, result: dict[str, Any] | None) -> None:
        before.append(done)
        if result is not None:
            count["failed"] += result["outcome"] != COMPLETED
        fresh, spent = done - before[0], time.monotonic() - begin
        left = f", about {spent / fresh * (total - done):.0f} s left" if fresh else ""
        line.show(f"{bar(done, total)} {done} of {total} runs, {count['failed']} failed{left}")

    try:
        results = run_batch(
            runs, options.out, jobs=options.jobs, dask=options.dask, progress=progress
        )
    finally:
        line.clear()
    outcomes = Counter(result["outcome"] for result in results)
    told = ", ".join(f"{number} {outcome}" for outcome, number in outcomes.most_common())
    print(f"{len(results)} runs: {told}; {before[0]} of them made before")
    print(f"table: {options.out / 'results.csv'} and .json")
    failed = [result for result in results if result["outcome"] != COMPLETED]
    for result in failed[:5]:
        print(f"{result['run']}: {result['outcome']}: {result['reason']}")
    if len(failed) > 5:
        print(f"… and {len(failed) - 5} more, see the column 'reason'")
    return FAILED if failed else DONE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="rollout", description=__doc__)
    parser.add_argument(
        "scene", nargs="*", help="scene file, or the name of one in the config folder"
    )
    parser.add_argument("--duration", type=_positive, metavar="S", help="s; a sweep may say it")
    parser.add_argument(
        "--commands",
        metavar="FILE.csv",
        help="efforts over time: a header time,<actuator>,… and rows that are held until the next",
    )
    parser.add_argument(
        "--publish-rate", type=_positive, metavar="HZ", help="recorded states per s (100)"
    )
    parser.add_argument("--poses", type=_poses, metavar="N", help="number of backbone poses (51)")
    parser.add_argument(
        "--estimate", action="store_true", help="estimate the tip's error in time: 5 times the work"
    )
    parser.add_argument(
        "--no-space",
        action="store_true",
        help="no estimate of the tip's error in space: a half to a third of the work",
    )
    parser.add_argument(
        "--max-error",
        type=_positive,
        metavar="REL",
        help="estimate, and end where the estimate is beyond this part of the length",
    )
    parser.add_argument("--sweep", type=Path, metavar="FILE.yaml", help="parameters to vary")
    parser.add_argument("--jobs", type=_jobs, metavar="N", help="processes (one per core)")
    parser.add_argument(
        "--dask", metavar="ADDRESS", help="scheduler of many machines; 'local' starts one here"
    )
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="DIR",
        help="the recording; for many, the folder of recordings and tables, resumed if it exists",
    )
    return parser


def _positive(text: str) -> float:
    value = float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text}: expected a finite number above zero")
    return value


def _poses(text: str) -> int:
    value = int(text)
    if not 2 <= value <= MOST_POSES:
        expected = f"expected 2 (the base and the tip) to {MOST_POSES}"
        raise argparse.ArgumentTypeError(f"{text}: {expected}")
    return value


def _jobs(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text}: expected at least 1")
    return value
