"""One run of a batch: what it is, whether it is done already, and how it ended."""

from __future__ import annotations

import hashlib
import json
import math
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from soft_sim_ros.batch.programme import Programme, read_programme
from soft_sim_ros.batch.rollout import Rollout
from soft_sim_ros.errors import RecordingError, SceneError, SoftSimError
from soft_sim_ros.files import MOST_TABLE, read_text, write_whole
from soft_sim_ros.scene import Scene, parse_scene
from soft_sim_ros.scene.put import edited
from soft_sim_ros.version import __version__

COMPLETED = "completed"
RESULT = "result.json"
EFFORT = "efforts."


@dataclass(frozen=True)
class Run:
    """One run of a batch.

    Parameters
    ----------
    file, text : scene file and what is in it
    duration : s simulated
    parameters : key path in the scene → YAML value; ``efforts.NAME`` holds an effort throughout
    commands : CSV file of efforts over time
    publish_rate, poses, max_error : as in Rollout
    space : whether the tip's error in space is estimated, as in Rollout
    seed : what the drawn values of this run were drawn with
    """

    file: str
    text: str
    duration: float
    parameters: dict[str, str] = field(default_factory=dict)
    commands: str | None = None
    publish_rate: float = 100.0
    poses: int = 51
    max_error: float | None = None
    seed: int | None = None
    space: bool = True

    def scene(self) -> Scene:
        """Return the scene with the parameters in it.

        Raises
        ------
        SceneError
            which names the parameters instead of a line, since these shift the lines
        """
        values = {k: v for k, v in self.parameters.items() if not k.startswith(EFFORT)}
        if not values:
            return parse_scene(self.text, self.file)
        told = f"{self.file} with " + ", ".join(f"{k} = {v}" for k, v in values.items())
        try:
            return parse_scene(edited(self.text, self.file, values), self.file)
        except SceneError as error:
            raise SceneError(told, error.key_path, error.value, error.expected) from None

    def programme(self, scene: Scene) -> Programme | None:
        """Return the efforts over time."""
        names = [actuator.name for actuator in scene.actuators]
        safe = [actuator.safe for actuator in scene.actuators]
        if self.commands is not None:
            return read_programme(self.commands, names, safe)
        held = {k.removeprefix(EFFORT): v for k, v in self.parameters.items() if k[:8] == EFFORT}
        if not held:
            return None
        efforts = np.array([safe], dtype=float)
        for name, value in held.items():
            number = _number(value)
            if name not in names or not math.isfinite(number):
                expected = f"an effort of one of the actuators {', '.join(names) or '(none)'}"
                raise SceneError(self.file, EFFORT + name, value, expected)
            efforts[0, names.index(name)] = number
        return Programme(np.zeros(1), efforts)

    @property
    def digest(self) -> str:
        """Digest of everything that decides what comes out."""
        commands = None if self.commands is None else read_text(self.commands, MOST_TABLE)
        what = [
            __version__, self.text, self.duration, sorted(self.parameters.items()), commands,
            self.publish_rate, self.poses, self.max_error,
        ]  # fmt: skip
        what += [] if self.space else ["no estimate in space"]
        return hashlib.sha256(json.dumps(what).encode()).hexdigest()

    @property
    def name(self) -> str:
        """Name of the run and of its directory."""
        return f"{Path(self.file).stem}-{self.digest[:12]}"

    def done(self, out: Path) -> dict[str, Any] | None:
        """Return the result of this very run if it has ended, with success or with a typed error.

        What may come out otherwise next time (a full disk, a process that died, Ctrl-C) has not.
        """
        try:
            result = json.loads((out / self.name / RESULT).read_text())
        except (OSError, ValueError):
            return None
        known = isinstance(result, dict) and result.get("digest") == self.digest
        return result if known and result.get("final") else None

    def described(self) -> dict[str, Any]:
        """Return the part of a result that is known beforehand."""
        return {
            "run": self.name, "scene": self.file, "parameters": self.parameters,
            "seed": self.seed, "digest": self.digest,
        }  # fmt: skip


def execute(run: Run, out: str) -> dict[str, Any]:
    """Run into ``out``/name and return the result, which is also in result.json there.

    Every error ends as an outcome: the name of its class, and its words as the reason. Only
    KeyboardInterrupt goes through.
    """
    directory = Path(out) / run.name
    _set_aside(directory)
    begin = time.perf_counter()
    result = run.described() | {
        "outcome": COMPLETED, "reason": None, "final": True, "simulated_s": None, "tip_m": None,
        "error_rel": None, "space_error_rel": None, "gained_rel": None,
        "energy_residual_J": None, "wall_s": None,
    }  # fmt: skip
    rollout = None
    try:
        scene = run.scene()
        rollout = Rollout(
            scene, directory, run.programme(scene), publish_rate=run.publish_rate,
            poses=run.poses, max_error=run.max_error, duration=run.duration, space=run.space,
        )  # fmt: skip
        rollout.run(run.duration)
    except Exception as error:
        result["outcome"], result["reason"] = type(error).__name__, str(error)
        # the rest are a machine's troubles, or a bug of ours that may be mended by then
        result["final"] = isinstance(error, SoftSimError) and not isinstance(error, RecordingError)
    if rollout is not None:
        result |= _numbers(rollout)
        lost = rollout.summary()["recording"]
        if lost["dropped"] or lost["error"]:
            result |= {"outcome": RecordingError.__name__, "final": False}
            result["reason"] = f"{lost['dropped']} messages lost: {lost['error']}"
    result["wall_s"] = time.perf_counter() - begin
    directory.mkdir(parents=True, exist_ok=True)
    write_whole(directory / RESULT, json.dumps(result, indent=1) + "\n")
    return result


def _numbers(rollout: Rollout) -> dict[str, Any]:
    summary = rollout.summary()
    estimate = summary["estimate"] or summary["accuracy"] or {}
    tip = rollout.simulation.tips().poses()[-1, :3]
    return {
        "simulated_s": summary["simulated_s"],
        "tip_m": tip.tolist(),
        "error_rel": estimate.get("error_rel"),
        "space_error_rel": (summary["space"] or {}).get("error_rel"),
        "gained_rel": estimate.get("gained_rel"),
        "energy_residual_J": summary["energy_residual_J"],
    }


def _set_aside(directory: Path) -> None:
    """Move what a killed run left out of the way: it can still be recovered."""
    if not directory.exists():
        return
    number = 1
    while (aside := directory.with_name(f"{directory.name}.torn-{number}")).exists():
        number += 1
    directory.rename(aside)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
