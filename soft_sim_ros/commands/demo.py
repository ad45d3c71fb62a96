"""Simulate an arm in a ROS node, drive it over its topics, record, replay, and simulate again."""

from __future__ import annotations

import argparse
import json
import os
import signal
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from soft_sim_ros.commands.child import child
from soft_sim_ros.commands.progress import Line
from soft_sim_ros.commands.shell import DONE, FAILED, require_ros, verb
from soft_sim_ros.commands.warm_up import warm_up
from soft_sim_ros.experiments.resimulation import Comparison, recorded_scene, rerun
from soft_sim_ros.files import write_whole
from soft_sim_ros.recording.reader import Run, read_run
from soft_sim_ros.recording.topics import POSES
from soft_sim_ros.report import picture, write_report
from soft_sim_ros.scene import load_scene

PACKAGE = "soft_sim_ros"
REPLAY_RATE = 4.0
REPLAY_DELAY = 4.0  # s for the two to find each other: on a busy machine one is not enough


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Do all of it; the result lies in ``runs/<stamp>``, to which ``runs/latest`` points."""
    require_ros("demo")
    parser = argparse.ArgumentParser(prog="demo", description=__doc__)
    parser.add_argument("scene", nargs="?", default="soft_arm", help="scene file or name")
    parser.add_argument("--duration", type=float, default=10.0, metavar="S", help="simulated s")
    parser.add_argument(
        "--rate", type=float, default=1.0, metavar="R", help="real-time factor; 0 = no limit"
    )
    parser.add_argument("--runs", type=Path, default=Path("runs"), metavar="DIR")
    options = parser.parse_args(argv)
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        # The other processes are ended in order by it; they must not inherit a deaf ear.
        signal.signal(signal.SIGINT, signal.default_int_handler)
    scene = load_scene(options.scene)
    directory = new_directory(options.runs)
    print(f"demo of scene {scene.name!r}: {options.duration:g} s, into {directory}", flush=True)
    warm_up(scene)
    driven = simulate(scene.file, directory, options.duration, options.rate)
    point_latest(options.runs, directory)
    run = read_run(directory)
    replayed = replay(run)
    comparison = simulate_again(run)
    numbers = summarise(run, driven, replayed, comparison)
    write_whole(directory / "summary.json", json.dumps(numbers, indent=2) + "\n")
    print("drawing", flush=True)
    files = [
        ("recording", directory),
        ("summary", directory / "summary.json"),
        ("picture", picture(run, directory / "motion.png")),
        ("page", write_report(directory)),
        ("newest", options.runs / "latest"),
    ]
    for line in tell(numbers):
        print(line)
    for what, path in files:
        print(f"{what + ':':17}{path}")
    lost = numbers["recording"]["dropped"] or numbers["recording"]["error"]
    return DONE if comparison.identical and not lost else FAILED


def new_directory(runs: Path) -> Path:
    """Make a directory named after the present time; a second demo in the same second waits."""
    runs.mkdir(parents=True, exist_ok=True)
    while True:
        directory = runs / time.strftime("%Y%m%d-%H%M%S")
        try:
            directory.mkdir()
        except FileExistsError:
            time.sleep(0.2)
        else:
            return directory


def point_latest(runs: Path, directory: Path) -> None:
    """Let ``runs/latest`` point to the directory; at no moment does it point nowhere."""
    link = runs / f".latest.{os.getpid()}"
    link.symlink_to(directory.name)
    link.replace(runs / "latest")


def simulate(scene_file: str, directory: Path, duration: float, rate: float) -> dict[str, Any]:
    """Run the node in one process and drive it from another; gives what the driver counted."""
    parameters = {
        "scene": _text(scene_file),
        "record": _text(str(directory)),
        "real_time_factor": repr(rate),
        "start_paused": "true",
    }
    assignments = [w for item in parameters.items() for w in ("-p", "{}:={}".format(*item))]
    line = Line()
    with child("the simulator", PACKAGE, "simulate", "--ros-args", *assignments) as node:
        for text in node.wait_for("ready:"):
            line.show(_log(text))
        line.clear()
        print(f"simulator:       {_log(text)}", flush=True)
        module = f"{PACKAGE}.commands.drive"
        with child("the driver", module, scene_file, repr(duration)) as driver:
            for text in driver.lines():
                line.show(text)
            line.clear()
            driver.finish()
        driven: dict[str, Any] = json.loads(driver.said[-1])
        node.interrupt()
        node.finish()
        print(f"simulator:       {_log(node.said[-1])}", flush=True)
    return driven


def replay(run: Run) -> dict[str, Any]:
    """Replay in one process and listen in another; gives what was heard."""
    topic = next(channel.topic for channel in run.channels if channel.type == POSES)
    last = int(run.backbone.time_ns[-1])
    line = Line()
    line.show("replaying")
    with child("the listener", f"{PACKAGE}.commands.listen", topic, str(last)) as listener:
        for text in listener.wait_for("listening"):
            line.show(text)
        options = ("--rate", repr(REPLAY_RATE), "--delay", repr(REPLAY_DELAY), "--wait-for", topic)
        with child("the replay", PACKAGE, "replay", str(run.path), *options) as player:
            for text in _both(player.lines(), line):
                said = _log(text)
            player.finish()
            listener.finish()
    line.clear()
    print(f"replay:          {said}", flush=True)
    return {"rate": REPLAY_RATE, "topic": topic, **json.loads(listener.said[-1])}


def _both(lines: Iterator[str], line: Line) -> Iterator[str]:
    for text in lines:
        line.show(f"replaying: {_log(text)}")
        yield text


def simulate_again(run: Run) -> Comparison:
    """Simulate the recorded commands without ROS and compare."""
    warm_up(recorded_scene(run))
    line = Line()
    comparison = rerun(
        run, progress=lambda t: line.show(f"simulating again: t = {t:.1f} of {run.end:.1f} s")
    )
    line.clear()
    return comparison


def summarise(
    run: Run, driven: dict[str, Any], replayed: dict[str, Any], comparison: Comparison
) -> dict[str, Any]:
    """Give the node's own summary with what the demo found out besides."""
    numbers: dict[str, Any] = json.loads((run.path / "summary.json").read_text())
    tip = run.tip_pose.positions
    work = run.energy["actuator_work"]
    stored = run.energy["kinetic"] + run.energy["elastic"]
    return {
        **numbers,
        "tip_path_m": float(np.linalg.norm(np.diff(tip, axis=0), axis=1).sum()),
        "tip_room_m": np.ptp(tip, axis=0).tolist(),
        "energy_scale_J": float(max(np.abs(work).max(), stored.max())),
        "driver": driven,
        "recorded_by_topic": run.counts,
        "replay": replayed,
        "rerun": {
            "messages": comparison.messages,
            "different": comparison.different,
            "largest_difference": comparison.difference,
        },
    }


def tell(n: dict[str, Any]) -> Iterator[str]:
    """Give the summary as lines."""
    cost, kept, driven, heard = n["step_cost"], n["recording"], n["driver"], n["replay"]
    yield (
        f"real-time factor {n['real_time_factor']:.3f} (asked for "
        f"{n['real_time_factor_asked_for']:g}), {n['simulated_s']:.3f} s simulated"
    )
    yield (
        f"step             {n['step_s'] * 1e3:g} ms; cost p50 {cost['p50_us']:.0f} µs, "
        f"p99 {cost['p99_us']:.0f} µs, worst {cost['worst_us']:.0f} µs "
        f"(means over a control period); {n['overruns']} deadlines missed"
    )
    yield (
        f"commands         {driven['commands_sent'] + driven['wrenches_sent']} sent, "
        f"{n['commands']['accepted']} taken up, {n['commands']['refused']} refused"
    )
    yield (
        f"messages         {sum(n['messages_sent'].values())} sent where somebody listens, "
        f"{kept['recorded']} recorded, "
        f"{kept['dropped']} dropped"
    )
    yield (
        f"tip path         {n['tip_path_m']:.3f} m, within "
        + " × ".join(f"{edge:.3f}" for edge in n["tip_room_m"])
        + " m"
    )
    yield (
        f"energy residual  {n['energy_residual_J']:.2e} J, "
        f"where {n['energy_scale_J']:.2e} J went in or out"
    )
    recorded = n["recorded_by_topic"].get(heard["topic"], 0)
    yield f"replay           {heard['heard']} of {recorded} shapes heard at {heard['rate']:g} x"
    again = n["rerun"]
    verdict = (
        "identical, 0 bits different"
        if again["different"] == 0
        else f"{again['different']} differ, by up to {again['largest_difference']:.3g}"
    )
    yield f"simulated again  {again['messages']} messages: {verdict}"


def _text(value: str) -> str:
    """Quote a string for the YAML that values of ROS parameters are."""
    return "'" + value.replace("'", "''") + "'"


def _log(line: str) -> str:
    """Take level, time and name off a line of a ROS log."""
    return line.split("]: ", 1)[-1]
