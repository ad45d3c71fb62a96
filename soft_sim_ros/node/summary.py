"""The numbers of a run, as ``summary.json`` beside its recording."""

from __future__ import annotations

import json
import math
from pathlib import Path

from soft_sim_ros.core.accuracy.space_watch import LookedInputs, SpaceInputs, as_json
from soft_sim_ros.core.accuracy.watch import WatchedInputs
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.files import write_whole
from soft_sim_ros.node.commands import Gate
from soft_sim_ros.node.parameters import Settings
from soft_sim_ros.node.physics import Physics
from soft_sim_ros.node.publishers import Publishers
from soft_sim_ros.scene.limbs import limbs_of
from soft_sim_ros.version import __version__

FILE_NAME = "summary.json"


def summarise(
    settings: Settings, physics: Physics, publishers: Publishers, gate: Gate, ended_by: str
) -> dict:
    """Counters and timings of a run that has ended; SI units unless the key says otherwise."""
    simulation, log, pacer = physics.simulation, physics.log, physics.pacer
    running = physics.running_ns * 1e-9
    return {
        "package": f"soft_sim_ros {__version__}",
        "scene": simulation.scene.name,
        "scene_file": simulation.scene.file,
        **limbs_of(simulation.scene).facts(),
        "ended_by": ended_by,
        "last_error": physics.last_error,
        "simulated_s": simulation.time,
        "running_s": running,
        "real_time_factor": physics.ran_ns * 1e-9 / running if running > 0.0 else None,
        "real_time_factor_asked_for": pacer.factor,
        "overruns": pacer.overruns,
        "given_up_s": pacer.lost_ns * 1e-9,
        "step_s": simulation.step_ns * 1e-9,
        "publish_every_steps": physics.grid.publish,
        "control_every_steps": physics.grid.control,
        "step_cost": physics.costs.summary(),
        "solver": {key: _plain(v) for key, v in simulation.statistics()._asdict().items()},
        "energy_residual_J": _plain(physics.residual),
        "accuracy": accuracy(physics.inputs),
        "space": space(physics.inputs),
        "messages_sent": dict(publishers.sent),
        "commands": {
            "accepted": gate.accepted,
            "refused": gate.refused,
            "clamped": gate.clamped,
        },
        "recording": None
        if log is None
        else {
            "directory": settings.record,
            "recorded": log.written,
            "dropped": log.dropped,
            "error": log.error,
            "complete": log.complete,
        },
        "parameters": vars(settings),
    }


def accuracy(inputs: Inputs) -> dict[str, float | None] | None:
    """Tolerances and estimates of the tip's errors; null where the estimate ended."""
    if not isinstance(inputs, WatchedInputs):
        return None
    return {key: _plain(value) for key, value in inputs.accuracy().items()}


def space(inputs: Inputs) -> dict[str, float | None] | None:
    """Estimate of the tip's error in space and its limit, over the length; null without any."""
    if isinstance(inputs, LookedInputs):
        inputs.catch_up()
    return as_json(inputs.space()) if isinstance(inputs, SpaceInputs) else None


def write_summary(directory: str, summary: dict) -> Path:
    """Write ``summary.json`` and say where it is."""
    path = Path(directory) / FILE_NAME
    write_whole(path, json.dumps(summary, indent=2, allow_nan=False) + "\n")
    return path


def _plain(value) -> int | float | None:
    """Give a number that JSON can hold; one that is not finite becomes null."""
    number = value.item() if hasattr(value, "item") else value
    return None if isinstance(number, float) and not math.isfinite(number) else number
