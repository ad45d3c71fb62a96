"""One run of a scene into a recording, as fast as possible."""

from __future__ import annotations

import json
import math
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from soft_sim_ros.batch.programme import Programme
from soft_sim_ros.core.accuracy.contract import choose
from soft_sim_ros.core.accuracy.drive import Drive
from soft_sim_ros.core.accuracy.estimate import Estimated
from soft_sim_ros.core.accuracy.space_watch import (
    BEAT,
    AccompaniedInputs,
    LookedInputs,
    SpaceInputs,
    as_json,
    has_space,
)
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.endings import undisturbed
from soft_sim_ros.errors import NotResolved, SolverError
from soft_sim_ros.files import write_whole
from soft_sim_ros.recording.cdr import encode_floats, encode_string
from soft_sim_ros.recording.sensors import SensorMessages
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter
from soft_sim_ros.scene import Scene
from soft_sim_ros.scene.limbs import limbs_of
from soft_sim_ros.version import __version__

NODE = "/soft_arm"  # topics are named as those of the node, so that every reader fits both
FRAME = "world"
LOOKS = 20  # at a run whose numerics are not written, at least


class Rollout:
    """One run of a scene into a recording.

    The state is recorded at the start, then every ``1 / publish_rate`` s (in whole steps), and at
    the end; a command is taken up at the first step boundary not before its time. Where the scene
    has a tolerance, a search for what meets it in this very run comes first.

    Parameters
    ----------
    scene : what is simulated
    directory : of the recording, which must not exist yet or be empty
    programme : efforts over time; None = safe efforts throughout
    publish_rate : states per simulated second, Hz
    poses : number of backbone poses, base to tip
    max_error : run a companion that estimates the tip's error, and refuse to go on where the
        estimate is beyond this part of the length; infinite: estimate only; None: no companion
    duration : of the run to come, in s; asked for by a tolerance only
    space : whether the tip's error in space is estimated: by a finer companion where the scene has
        numerics, by looks at instants where it has none; not with a tolerance, which covers it
    say : receives messages about the search for a tolerance

    Raises
    ------
    ToleranceMissed
        if the tolerance of the scene cannot be met

    Warns
    -----
    UserWarning
        if the period of states is no whole number of steps
    """

    def __init__(
        self,
        scene: Scene,
        directory: str | Path,
        programme: Programme | None = None,
        *,
        publish_rate: float = 100.0,
        poses: int = 51,
        max_error: float | None = None,
        duration: float | None = None,
        space: bool = True,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.directory = Path(directory)
        step_ns = round(scene.numerics.step * 1e9)
        step = step_ns * 1e-9
        self._publish_steps = max(1, round(1.0 / (publish_rate * step)))
        actuators = len(scene.actuators)
        if programme is None:
            programme = Programme(np.empty(0), np.empty((0, actuators)))
        self._rows = programme.steps(step), programme.efforts
        self._contract: dict[str, float] | None = None
        tolerance = scene.numerics.tolerance
        if tolerance is not None and duration is not None:
            choice = choose(scene, self._drive(steps_of(duration, step_ns)), say)
            scene = choice.scene
            self._contract = choice.accuracy()
        self.simulation = Simulation(scene)
        self._inputs = self._inputs_of(space and tolerance is None, duration)
        limbs = limbs_of(scene)
        self._telemetry = Telemetry(self.simulation, poses, FRAME, NODE, limbs=limbs)
        self._sensors = SensorMessages(self.simulation, scene.sensors, NODE)
        real_rate = 1.0 / (self._publish_steps * step)
        if abs(real_rate - publish_rate) > 1e-6 * publish_rate:
            warnings.warn(
                f"states are recorded {real_rate:.6g} times per s, not {publish_rate:.6g}: every "
                f"{self._publish_steps} steps of {step:g} s",
                stacklevel=2,
            )
        self._pair = None if max_error is None else Estimated(self.simulation, max_error)
        self._seconds = 0.0
        self._ended_by = "interrupted"
        self.no_summary: str | None = None  # why there is none
        self._open = True
        facts = {
            "node": NODE,
            "command_timeout": "0.0",
            "command_ramp": "0.0",
            "frame_id": FRAME,
            "poses": str(poses),
            "publish_rate": repr(publish_rate),
            "real_time_factor": "0.0",
        }
        source = self.simulation.scene.source.encode()
        topics = (*recorded_topics(NODE, limbs), *self._sensors.topics)
        attachments = {"scene.yaml": source}
        try:
            with undisturbed():
                self._writer = BagWriter(
                    self.directory, topics, metadata=facts, attachments=attachments
                )
        except KeyboardInterrupt as ending:
            self.close(ending)
            raise

    def run(self, duration: float, progress: Callable[[float], None] = lambda t: None) -> dict:
        """Simulate ``duration`` s and close the recording, which stays valid whatever happens.

        Returns
        -------
        dict
            the summary, which is also in ``summary.json``

        Raises
        ------
        SolverError
            if the solver gives up; everything up to there is in the recording
        """
        last = steps_of(duration, self.simulation.step_ns)
        begin = time.perf_counter()
        try:
            self._run(last, progress)
            if isinstance(self._inputs, SpaceInputs):
                self._inputs.look()
            self._ended_by = "duration"
        except SolverError as error:
            self._ended_by = f"diverged: {error}"
            self._event(
                self._ended_by
            )  # before withdrawal, while the inputs of the failed step are in force
            self._emit()
            raise
        except KeyboardInterrupt as ending:
            self._ended_by = str(ending) or self._ended_by  # the name of the signal
            raise
        finally:
            self._seconds = time.perf_counter() - begin
            self.close()
        return self.summary()

    def close(self, ending: BaseException | None = None) -> None:
        """Close the recording and write the summary beside it, if the disk takes it; once.

        Parameters
        ----------
        ending : what has ended the run before it began
        """
        with undisturbed():
            if not self._open:
                return
            self._open = False
            if ending is not None:
                self._ended_by = str(ending) or self._ended_by
            self._writer.close()
            text = json.dumps(self.summary(), indent=2, allow_nan=False)
            try:
                write_whole(self.directory / "summary.json", text + "\n")
            except OSError as error:
                self.no_summary = f"{self.directory / 'summary.json'}: {error.strerror}"

    def _inputs_of(self, space: bool, duration: float | None) -> Inputs:
        simulation = self.simulation
        if not space or not has_space(simulation):
            return Inputs(simulation, command_timeout=0.0, ramp=0.0)
        if simulation.scene.numerics.written:
            return AccompaniedInputs(simulation, command_timeout=0.0, ramp=0.0)
        beat = BEAT if duration is None else min(BEAT, duration / LOOKS)
        return LookedInputs(simulation, command_timeout=0.0, ramp=0.0, beat=beat)

    def _drive(self, last: int) -> Drive:
        """Return the commands of a run of ``last`` steps."""
        steps, efforts = self._rows
        return Drive(steps, efforts, last, self._publish_steps)

    def _run(self, last: int, progress: Callable[[float], None]) -> None:
        simulation, drive = self.simulation, self._drive(last)
        self._emit()
        self._emit_readings()
        for commands, stop in drive.stretches():
            for efforts in commands:
                self._writer.write("command", simulation.time_ns, encode_floats(efforts))
                self._inputs.command(efforts)
            steps = stop - simulation.step_index
            self._advance(steps)
            if self._pair is not None:
                self._pair.follow(steps)
            if drive.looks(stop):
                self._emit()
                self._writer.wait_for_room()
                progress(simulation.time)

    def _advance(self, steps: int) -> None:
        """Advance, and record readings of sensors when they get out."""
        while steps > 0:
            some = min(steps, self.simulation.steps_to_reading())
            self._inputs.advance(some)
            self._emit_readings()
            steps -= some

    def _emit_readings(self) -> None:
        for key, data in self._sensors.new():
            self._writer.write(key, self.simulation.time_ns, data)

    def _emit(self) -> None:
        for key, build in self._telemetry.builders.items():
            self._writer.write(key, self.simulation.time_ns, build())

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
            **limbs_of(simulation.scene).facts(),
            "ended_by": self._ended_by,
            "simulated_s": simulation.time,
            "running_s": self._seconds,
            "real_time_factor": simulation.time / self._seconds if self._seconds else None,
            "step_s": simulation.step_ns * 1e-9,
            "publish_every_steps": self._publish_steps,
            "solver": simulation.statistics()._asdict(),
            "energy_residual_J": residual if math.isfinite(residual) else None,
            "estimate": None if self._pair is None else self._pair.summary(),
            "accuracy": self._contract,
            "space": self._space(),
            "recording": {
                "directory": str(self.directory),
                "recorded": writer.written,
                "dropped": writer.dropped,
                "error": writer.error,
                "complete": writer.complete,
            },
        }

    def _space(self) -> dict[str, float | None] | None:
        inputs = self._inputs
        return as_json(inputs.space()) if isinstance(inputs, SpaceInputs) else None

    def doubt(self) -> NotResolved | None:
        """Return a warning if the basis was too coarse for the run."""
        inputs = self._inputs
        if not isinstance(inputs, SpaceInputs) or not inputs.coarse:
            return None
        return NotResolved(self.simulation.scene.name, inputs.space_rel, inputs.space_limit)


def steps_of(duration: float, step_ns: int) -> int:
    """Return how many steps cover a duration in s."""
    return max(0, math.ceil(duration * 1e9 / step_ns - 1e-6))
