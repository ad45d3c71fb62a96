"""Simulate as fast as possible into a recording, without ROS."""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from soft_sim_ros import __version__
from soft_sim_ros.commands.programme import Programme, read_programme
from soft_sim_ros.commands.progress import Line
from soft_sim_ros.commands.shell import DONE, FAILED, verb
from soft_sim_ros.commands.warm_up import warm_up
from soft_sim_ros.core.inputs import Inputs
from soft_sim_ros.core.simulation import Simulation
from soft_sim_ros.errors import SolverError
from soft_sim_ros.recording.cdr import encode_floats, encode_string
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter
from soft_sim_ros.scene import Scene, load_scene

NODE = "/soft_arm"  # topics are named as those of the node, so that every reader fits both
FRAME = "world"


class Rollout:
    """One run of a scene into a recording.

    The state is recorded at the start, then every ``publish_rate``⁻¹ s (in whole steps), and at the
    end; a command is taken up at the first step boundary not before its time.

    Parameters
    ----------
    scene : what is simulated
    directory : of the recording, which must not exist yet or be empty
    programme : efforts over time; None = safe efforts throughout
    publish_rate : states per simulated second, Hz
    poses : number of backbone poses, base to tip
    """

    def __init__(
        self,
        scene: Scene,
        directory: str | Path,
        programme: Programme | None = None,
        *,
        publish_rate: float = 100.0,
        poses: int = 51,
    ) -> None:
        self.directory = Path(directory)
        self.simulation = Simulation(scene)
        self._inputs = Inputs(self.simulation, command_timeout=0.0, ramp=0.0)
        self._telemetry = Telemetry(self.simulation, poses, FRAME, NODE)
        step = self.simulation.step_ns * 1e-9
        self._publish_steps = max(1, round(1.0 / (publish_rate * step)))
        if programme is None:
            programme = Programme(np.empty(0), np.empty((0, self.simulation.n_actuators)))
        self._due = list(zip(programme.steps(step).tolist(), programme.efforts, strict=True))[::-1]
        self._seconds = 0.0
        self._ended_by = "interrupted"
        self._writer = BagWriter(
            self.directory,
            recorded_topics(NODE),
            metadata={
                "node": NODE,
                "command_timeout": "0.0",
                "command_ramp": "0.0",
                "frame_id": FRAME,
                "poses": str(poses),
                "publish_rate": repr(publish_rate),
                "real_time_factor": "0.0",
            },
            attachments={"scene.yaml": scene.source.encode()},
        )

    def run(self, duration: float, progress: Callable[[float], None] = lambda t: None) -> dict:
        """Simulate ``duration`` s and close the recording, which stays valid whatever happens.

        Returns
        -------
        dict
            the summary, which is also in ``summary.json``

        Raises
        ------
        Diverged
            if the solver gives up; everything up to there is in the recording
        """
        last = max(0, math.ceil(duration * 1e9 / self.simulation.step_ns - 1e-6))
        begin = time.perf_counter()
        try:
            self._run(last, progress)
            self._ended_by = "duration"
        except SolverError as error:
            self._ended_by = f"diverged: {error}"
            self._event(self._ended_by)  # first: the inputs that broke the step are in force now
            self._emit()
            raise
        finally:
            self._seconds = time.perf_counter() - begin
            self._writer.close()
            summary = self.summary()
            text = json.dumps(summary, indent=2, allow_nan=False)
            (self.directory / "summary.json").write_text(text + "\n")
        return summary

    def _run(self, last: int, progress: Callable[[float], None]) -> None:
        simulation = self.simulation
        self._emit()
        while simulation.step_index < last:
            index = simulation.step_index
            while self._due and self._due[-1][0] <= index:
                efforts = self._due.pop()[1]
                self._writer.write("command", simulation.time_ns, encode_floats(efforts))
                self._inputs.command(efforts)
            stop = min(last, index + self._publish_steps - index % self._publish_steps)
            if self._due:
                stop = min(stop, self._due[-1][0])
            self._inputs.advance(stop - index)
            if stop % self._publish_steps == 0 or stop == last:
                self._emit()
                self._writer.wait_for_room()
                progress(simulation.time)

    def _emit(self) -> None:
        for topic in self._telemetry.topics:
            data = getattr(self._telemetry, topic.key)()
            self._writer.write(topic.key, self.simulation.time_ns, data)

    def _event(self, text: str) -> None:
        self._writer.write("events", self.simulation.time_ns, encode_string(text))

    def summary(self) -> dict[str, Any]:
        """Numbers of the run so far; SI units unless the key says otherwise."""
        simulation, writer = self.simulation, self._writer
        residual = float(simulation.ledger()[-1])
        return {
            "package": f"soft_sim_ros {__version__}",
            "scene": simulation.scene.name,
            "scene_file": simulation.scene.file,
            "ended_by": self._ended_by,
            "simulated_s": simulation.time,
            "running_s": self._seconds,
            "real_time_factor": simulation.time / self._seconds if self._seconds else None,
            "step_s": simulation.step_ns * 1e-9,
            "publish_every_steps": self._publish_steps,
            "solver": simulation.statistics()._asdict(),
            "energy_residual_J": residual if math.isfinite(residual) else None,
            "recording": {
                "directory": str(self.directory),
                "recorded": writer.written,
                "dropped": writer.dropped,
                "error": writer.error,
            },
        }


@verb
def main(argv: Sequence[str] | None = None) -> int:
    """Run the rollout that the command line describes."""
    options = _parser().parse_args(argv)
    scene = load_scene(options.scene)
    programme = None
    if options.commands is not None:
        names = [actuator.name for actuator in scene.actuators]
        safe = [actuator.safe for actuator in scene.actuators]
        programme = read_programme(options.commands, names, safe)
    warm_up(scene)
    rollout = Rollout(
        scene, options.out, programme, publish_rate=options.publish_rate, poses=options.poses
    )
    line = Line()
    begin = time.monotonic()

    def progress(now: float) -> None:
        speed = now / max(time.monotonic() - begin, 1e-9)
        line.show(f"t = {now:.2f} of {options.duration:g} s, {speed:.3g} x real time")

    try:
        summary = rollout.run(options.duration, progress)
    finally:
        line.clear()
    kept, residual = summary["recording"], summary["energy_residual_J"]
    print(
        f"{summary['scene']}: {summary['simulated_s']:.6g} s in {summary['running_s']:.3g} s, "
        f"{summary['real_time_factor'] or 0:.3g} x real time; "
        f"energy residual {math.nan if residual is None else residual:.3g} J"
    )
    print(f"{kept['recorded']} messages recorded in {kept['directory']}")
    if kept["dropped"] or kept["error"]:
        print(f"error: {kept['dropped']} messages lost: {kept['error']}")
        return FAILED
    return DONE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="rollout", description=__doc__)
    parser.add_argument("scene", help="scene file, or the name of one in the config folder")
    parser.add_argument("--duration", type=_positive, required=True, metavar="S", help="s")
    parser.add_argument(
        "--commands",
        type=Path,
        metavar="FILE.csv",
        help="efforts over time: a header time,<actuator>,… and rows that are held until the next",
    )
    parser.add_argument(
        "--publish-rate", type=_positive, default=100.0, metavar="HZ", help="recorded states per s"
    )
    parser.add_argument(
        "--poses", type=_poses, default=51, metavar="N", help="number of backbone poses"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="the recording")
    return parser


def _positive(text: str) -> float:
    value = float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text}: expected a finite number above zero")
    return value


def _poses(text: str) -> int:
    value = int(text)
    if value < 2:
        raise argparse.ArgumentTypeError(f"{text}: expected at least 2, the base and the tip")
    return value
