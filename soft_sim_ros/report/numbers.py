"""The numbers of a run for the table of its report."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.foreign import printable
from soft_sim_ros.recording import claims
from soft_sim_ros.recording.reader import Run
from soft_sim_ros.report.units import grouped, port_units

SUMMARY = "summary.json"
_MOST_ROWS = 100
_LONGEST = 200  # characters of a text in a table
MOST_TIPS = 16  # no more are told of, or drawn
Rows = list[tuple[str, str]]
Path3 = tuple[NDArray[np.float64], NDArray[np.float64]]


def read_summary(directory: Path) -> dict[str, Any]:
    """Read the ``summary.json`` beside a recording; without one, nothing is known."""
    return claims.summary(directory / SUMMARY)


def tip_paths(run: Run) -> dict[str, Path3]:
    """Give time (T,) in s and positions (T, 3) in m of every tip, from whichever topic has them.

    One alone is called ``""``.
    """
    found = {name: (one.time, one.positions) for name, one in run.tip_poses.items() if len(one)}
    return found or {
        name: (one.time, one.positions[:, -1]) for name, one in run.backbones.items() if len(one)
    }


def fastest(time: NDArray[np.float64], position: NDArray[np.float64]) -> float:
    """Give the largest speed between two instants that differ, m/s; NaN without any."""
    moved = np.diff(time) > 0.0
    with np.errstate(invalid="ignore", over="ignore"):
        steps = np.linalg.norm(np.diff(position, axis=0), axis=1)
    return float((steps[moved] / np.diff(time)[moved]).max(initial=0.0)) if moved.any() else np.nan


def not_finite(run: Run) -> int:
    """Count the recorded states in which some number is not finite."""
    poses = [one.poses for one in (*run.backbones.values(), *run.tip_poses.values())]
    series = (*poses, run.joint_states.position, run.joint_states.velocity,
              run.joint_states.effort, run.strain_state.position, run.strain_state.velocity,
              run.energy.values)  # fmt: skip
    parts = [values.reshape(len(values), -1) for values in series if values.size]
    return max((int((~np.isfinite(part)).any(axis=1).sum()) for part in parts), default=0)


def motion_rows(run: Run) -> Rows:
    """Say how long, how far and how fast."""
    rows = [
        ("Simulated time", f"{run.start:.6g} s to {run.end:.6g} s"),
        ("Times are", run.time_axis),
        ("Messages", f"{sum(run.counts.values()):,}"),
    ]
    for name, path in list(tip_paths(run).items())[:MOST_TIPS]:
        rows += _tip_rows(f" {name}" if name else "", *path)
    for title, series in (("Actuators", run.joint_states), ("Coordinates", run.strain_state)):
        if series.name:
            rows.append((title, str(len(series.name))))
    if run.backbone.poses.shape[1]:
        names = [short(name) for name in run.backbones if name]
        each = f" of each: {', '.join(names[:MOST_TIPS])}" if names else ""
        rows.append(("Backbone poses", f"{run.backbone.poses.shape[1]}{each}"))
    if run.joint_states.effort.size:
        rows.append(("Largest effort", ", ".join(_largest_efforts(run))))
    commands = len(run.commands)
    rows.append(
        ("Commands, wrenches, events", f"{commands}, {len(run.wrenches)}, {len(run.events)}")
    )
    return rows


def _tip_rows(name: str, time: NDArray[np.float64], position: NDArray[np.float64]) -> Rows:
    if len(time) < 2:
        return []
    with np.errstate(invalid="ignore", over="ignore"):
        steps = np.linalg.norm(np.diff(position, axis=0), axis=1)
        extent = np.ptp(position, axis=0)
    return [
        (f"Path of the tip{name}", f"{steps.sum():.4g} m"),
        (f"Room taken by the tip{name}", " × ".join(f"{e:.3g}" for e in extent) + " m"),
        (f"Fastest tip speed{name and ','}{name}", f"{fastest(time, position):.4g} m/s"),
        (f"Tip{name} at the end", "(" + ", ".join(f"{p:.5g}" for p in position[-1]) + ") m"),
    ]


def _largest_efforts(run: Run) -> list[str]:
    """Say the largest effort of every unit: pressures and torques are not compared."""
    joints = run.joint_states
    largest = np.abs(joints.effort).max(axis=0)
    told = []
    for (unit, _), members in grouped(joints.name, port_units(run)).items():
        first = max(members, key=lambda index: largest[index])
        told.append(f"{largest[first]:.4g} {unit}".rstrip() + f" ({short(joints.name[first])})")
    return told


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
        if contract.get("error_rad") is not None:
            rows.append(("Estimated error of its orientation", f"{contract['error_rad']:.2g} rad"))
            rows.append(("Tolerance", f"{contract['orientation_tolerance']:g} rad"))
    space = summary.get("space")
    if space and space.get("error_rel") is not None:
        rows.append(("Estimated error in space", f"{space['error_rel']:.2g} of length"))
        if space["error_rel"] > space["limit"]:
            rows.append(("Warning", f"basis or nodes too coarse: beyond {space['limit']:g}"))
    for key, value in list((summary.get("solver") or {}).items())[:_MOST_ROWS]:
        rows.append((f"Solver {short(key)}", _plain(value)))
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
    facts = claims.machine(run.path, run.attachments)
    rows = [(short(key), short(value)) for key, value in facts.items() if value]
    return [row for row in rows if row[0] != "recorded"][:_MOST_ROWS]


def date(run: Run) -> str | None:
    """Say when the recording was begun, by the clock of its machine."""
    return claims.machine(run.path, run.attachments).get("recorded")


def short(text: str) -> str:
    """Give a text from a recording so that a table or a picture can hold it."""
    shown = printable(text).replace("\n", " ")
    return shown if len(shown) <= _LONGEST else shown[: _LONGEST - 2] + " …"


def _plain(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else short(str(value))
