"""Measured motions with their inputs, and predictions of other scenes under the same inputs."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import replace
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.batch.programme import Programme, ProgrammeError
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import RecordingError, SceneError, SolverError
from soft_sim_ros.experiments.resimulation import Rerun, recorded_scene
from soft_sim_ros.files import MOST_TABLE, read_npz, read_text
from soft_sim_ros.recording.reader import Run
from soft_sim_ros.scene import Scene, parse_scene

Floats = NDArray[np.float64]
TOPICS = ("backbone", "tip_pose")


class Experiment(Protocol):
    """Something that moved.

    Attributes
    ----------
    text, file : the scene it is thought to be, and where that is from
    measured : (T, N, 3) positions in m, world; NaN where nothing was measured
    """

    text: str
    file: str
    measured: Floats

    def predict(self, text: str, instants: int) -> Floats:
        """Return what a scene would have done at the first instants (instants, N, 3)."""


def _observer(simulation: Simulation, count: int) -> Callable[[], Floats]:
    """Return a function that gives positions (count, 3): of the last tip, or backbone."""
    source = simulation.tips() if count == 1 else simulation.sampler(count)
    return lambda: source.poses()[-count:, :3].copy()


def _trial(text: str, file: str) -> Scene:
    """Return a scene whose numbers were made up; one that is not valid cannot be simulated.

    Nobody reads its sensors.
    """
    try:
        return replace(parse_scene(text, file), sensors=())
    except SceneError as reason:
        raise SolverError(0.0, str(reason)) from reason


class Recorded:
    """A recording, of this package or of a real arm behind the same topics.

    Parameters
    ----------
    run : the recording
    topic : ``backbone`` or ``tip_pose``
    """

    def __init__(self, run: Run, topic: str = "backbone") -> None:
        self._run = run
        scene = recorded_scene(run)
        self.text, self.file = scene.source, scene.file
        series = run.backbone if topic == "backbone" else run.tip_pose
        if len(series) == 0:
            raise RecordingError(run.path, f"holds no {topic}")
        last = list(run.backbones)[-1] if topic == "backbone" else ""
        self._key = f"{topic}/{last}" if last else topic
        self.measured = series.positions.reshape(len(series), -1, 3)

    def predict(self, text: str, instants: int) -> Floats:
        """Return positions (instants, N, 3) of a scene under the recorded inputs."""
        rerun = Rerun(self._run, _trial(text, self.file))
        observe = _observer(rerun.simulation, self.measured.shape[1])
        states = (m for m in rerun.states() if rerun.topics[m.topic] == self._key)
        return np.stack([observe() for _ in islice(states, instants)])


class Measured:
    """A motion and the efforts that caused it, from tables.

    Parameters
    ----------
    scene : what it is thought to be
    programme : efforts over time, held from their time on
    time : (T,) s, rising
    positions : (T, N, 3) m, world: of the tip (N = 1), or equally spaced from base to tip
    """

    def __init__(self, scene: Scene, programme: Programme, time: Floats, positions: Floats) -> None:
        self.text, self.file, self._programme = scene.source, scene.file, programme
        self.time, self.measured = time, positions

    def predict(self, text: str, instants: int) -> Floats:
        """Return positions (instants, N, 3) of a scene, on straight lines between steps."""
        simulation = Simulation(_trial(text, self.file))
        inputs = Inputs(simulation, command_timeout=0.0, ramp=0.0)
        observe = _observer(simulation, self.measured.shape[1])
        step = simulation.step_ns * 1e-9
        due = list(zip(self._programme.steps(step).tolist(), self._programme.efforts, strict=True))
        whole = self.time[:instants] / step
        before = np.floor(whole + 1e-9).astype(int)
        share = np.clip(whole - before, 0.0, 1.0)
        seen: dict[int, Floats] = {}
        for index in sorted({*before.tolist(), *(before + 1).tolist()}):
            while due and due[0][0] <= index:
                at, efforts = due.pop(0)
                inputs.advance(at - simulation.step_index)
                inputs.command(efforts)
            inputs.advance(index - simulation.step_index)
            seen[index] = observe()
        return np.stack([
            (1.0 - part) * seen[index] + part * seen[index + 1]
            for index, part in zip(before.tolist(), share.tolist(), strict=True)
        ])  # fmt: skip


def read_motion(path: Path) -> tuple[Floats, Floats]:
    """Read a motion: time (T,) in s and positions (T, N, 3) in m.

    An ``.npz`` or a table as ``report`` exports them. A table has a header ``time,x,y,z`` for the
    tip or ``time,x0,y0,z0,x1,…`` for points equally spaced from base to tip; other columns do not
    count, and an empty cell is something not measured.

    Parameters
    ----------
    path : of the file

    Raises
    ------
    ProgrammeError
        if the table cannot be used
    """
    if path.suffix == ".npz":
        return _arrays(path)
    rows = csv.reader(StringIO(read_text(path, MOST_TABLE), newline=""), skipinitialspace=True)
    try:
        header = next(rows, [])
        one = {"x", "y", "z"} <= set(header)
        count = 1 if one else sum(name[:1] == "x" and name[1:].isdigit() for name in header)
        names = ["x", "y", "z"] if one else [f"{a}{i}" for i in range(count) for a in "xyz"]
        if header[:1] != ["time"] or not count or not set(names) <= set(header):
            expected = "time,x,y,z (the tip) or time,x0,y0,z0,x1,… (from base to tip)"
            raise ProgrammeError(str(path), 1, f"header {','.join(header)!r}", expected)
        where = {name: i for i, name in reversed(list(enumerate(header)))}
        columns = [where[name] for name in ("time", *names)]
        table: list[list[float]] = []
        for row in rows:
            if row:
                table.append(_numbers(str(path), rows.line_num, row, columns))
                if len(table) > 1 and not table[-1][0] > table[-2][0]:
                    found = f"time = {table[-1][0]:g} s"
                    expected = f"a time above {table[-2][0]:g} s"
                    raise ProgrammeError(str(path), rows.line_num, found, expected)
    except csv.Error as error:
        raise ProgrammeError(str(path), rows.line_num, str(error), "a CSV file") from error
    values = np.array(table).reshape(len(table), 1 + 3 * count)
    return values[:, 0], values[:, 1:].reshape(-1, count, 3)


def _arrays(path: Path) -> tuple[Floats, Floats]:
    """Return the motion of an ``.npz`` file."""
    content = read_npz(path)
    key = next((k for k in TOPICS if content.get(f"{k}_poses", np.empty(0)).size), None)
    expected = " or ".join(f"{k}_poses (T, N, 7) with {k}_time_ns (T,)" for k in TOPICS)
    if key is None:
        raise ProgrammeError(str(path), 0, f"arrays {', '.join(content)}", expected)
    time, poses = content.get(f"{key}_time_ns", np.empty(0)), content[f"{key}_poses"]
    numbers = time.dtype.kind in "iuf" and poses.dtype.kind in "iuf"
    if not numbers or time.ndim != 1 or poses.shape[:1] != time.shape or poses.shape[-1] != 7:
        found = f"{key}_poses {poses.shape} with {key}_time_ns {time.shape}"
        raise ProgrammeError(str(path), 0, found, expected)
    seconds = time / 1e9
    if not (np.isfinite(seconds).all() and (seconds >= 0.0).all() and (np.diff(seconds) > 0).all()):
        raise ProgrammeError(str(path), 0, f"{key}_time_ns", "times from 0 on that rise")
    return seconds, poses.reshape(len(time), -1, 7)[..., :3].astype(float)


def _numbers(file: str, line: int, row: list[str], columns: list[int]) -> list[float]:
    if len(row) <= max(columns):
        raise ProgrammeError(file, line, f"{len(row)} values", f"at least {max(columns) + 1}")
    numbers = []
    for i, column in enumerate(columns):
        text = row[column]
        try:
            number = float(text) if text.strip() or i == 0 else math.nan
        except ValueError:
            number = math.inf
        if math.isinf(number) or (i == 0 and not number >= 0.0):
            raise ProgrammeError(file, line, f"{text!r}", "a finite number, a time from 0 on")
        numbers.append(number)
    return numbers
