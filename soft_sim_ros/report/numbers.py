"""The numbers of a run that are worth a table."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.reader import Run

SUMMARY = "summary.json"
Rows = list[tuple[str, str]]


def read_summary(directory: Path) -> dict[str, Any]:
    """Read the ``summary.json`` beside a recording; without one, nothing is known."""
    path = directory / SUMMARY
    if not path.exists():
        return {}
    try:
        content = json.loads(path.read_text("utf-8"))
    except ValueError as reason:
        raise RecordingError(path, f"is not JSON: {reason}") from reason
    return content if isinstance(content, dict) else {}


def tip_path(run: Run) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Give time (T,) in s and position (T, 3) in m of the tip, from whichever topic has it."""
    if len(run.tip_pose):
        return run.tip_pose.time, run.tip_pose.positions
    backbone = run.backbone
    if len(backbone) == 0:
        return backbone.time, np.empty((0, 3))
    return backbone.time, backbone.positions[:, -1]


def motion_rows(run: Run) -> Rows:
    """Say how long, how far and how fast."""
    rows = [
        ("Simulated time", f"{run.start:.6g} s to {run.end:.6g} s"),
        ("Messages", f"{sum(run.counts.values()):,}"),
    ]
    time, position = tip_path(run)
    if len(time) > 1:
        steps = np.linalg.norm(np.diff(position, axis=0), axis=1)
        extent = np.ptp(position, axis=0)
        rows += [
            ("Path of the tip", f"{steps.sum():.4g} m"),
            ("Room taken by the tip", " × ".join(f"{e:.3g}" for e in extent) + " m"),
            ("Fastest tip speed", f"{(steps / np.diff(time)).max():.4g} m/s"),
            ("Tip at the end", "(" + ", ".join(f"{p:.5g}" for p in position[-1]) + ") m"),
        ]
    for title, series in (("Actuators", run.joint_states), ("Coordinates", run.strain_state)):
        if series.name:
            rows.append((title, str(len(series.name))))
    if run.backbone.poses.shape[1]:
        rows.append(("Backbone poses", str(run.backbone.poses.shape[1])))
    if run.joint_states.effort.size:
        effort = np.abs(run.joint_states.effort)
        strongest = int(effort.max(axis=0).argmax())
        name = run.joint_states.name[strongest]
        rows.append(("Largest effort", f"{effort.max():.4g} ({name})"))
    commands = len(run.commands)
    rows.append(
        ("Commands, wrenches, events", f"{commands}, {len(run.wrenches)}, {len(run.events)}")
    )
    return rows


def accuracy_rows(run: Run, summary: Mapping[str, Any]) -> Rows:
    """Say how well the energies add up, and what the solver had to do for it."""
    rows: Rows = []
    ledger = run.energy
    if "residual" in ledger.names and len(ledger):
        residual = np.abs(ledger["residual"])
        others = [np.abs(ledger[name]).max() for name in ledger.names if name != "residual"]
        scale = max(others, default=0.0)
        rows.append(("Energy residual at the end", f"{ledger['residual'][-1]:.3g} J"))
        rows.append(("Largest energy residual", f"{residual.max():.3g} J"))
        if scale > 0:
            rows.append(("… of the largest entry", f"{residual.max() / scale:.2g}"))
    contract = summary.get("accuracy")
    if contract:
        estimate = contract["error_rel"]
        told = "none: its companion gave up" if estimate is None else f"{estimate:.2g} of length"
        rows.append(("Estimated error of the tip", told))
        rows.append(("Tolerance", f"{contract['tolerance']:g} of length"))
    space = summary.get("space")
    if space and space["error_rel"] is not None:
        rows.append(("Estimated error in space", f"{space['error_rel']:.2g} of length"))
        if space["error_rel"] > space["limit"]:
            rows.append(("Warning", f"basis or nodes too coarse: beyond {space['limit']:g}"))
    for key, value in (summary.get("solver") or {}).items():
        rows.append((f"Solver {key}", _plain(value)))
    return rows


def speed_rows(summary: Mapping[str, Any]) -> Rows:
    """Say how fast it went, and what got lost."""
    cost = summary.get("step_cost") or {}
    recording = summary.get("recording") or {}
    rows = [
        ("Real-time factor", summary.get("real_time_factor")),
        ("Step, median", cost.get("p50_us")),
        ("Step, 99 %", cost.get("p99_us")),
        ("Step, worst", cost.get("worst_us")),
        ("Missed deadlines", summary.get("overruns")),
        ("Messages dropped", recording.get("dropped")),
        ("Ended by", summary.get("ended_by")),
        ("Last error", summary.get("last_error")),
    ]
    return [
        (name, f"{_plain(value)} µs" if name.startswith("Step") else _plain(value))
        for name, value in rows
        if value is not None
    ]


def machine_rows(run: Run) -> Rows:
    """Say what it ran on, from the facts kept inside the recording."""
    return [(key, str(value)) for key, value in _facts(run).items() if value and key != "recorded"]


def date(run: Run) -> str | None:
    """Say when the recording was begun, by the clock of its machine."""
    return _facts(run).get("recorded")


def _facts(run: Run) -> dict[str, str]:
    facts: dict[str, str] = json.loads(run.attachments.get("machine.json", b"{}"))
    return facts


def _plain(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
