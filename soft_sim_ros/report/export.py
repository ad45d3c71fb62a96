"""A recording as plain tables and arrays."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.recording.decode import FloatArray, JointState, Odometry, Poses, Wrench
from soft_sim_ros.recording.reader import Input, Run
from soft_sim_ros.recording.series import JointSeries, PoseSeries
from soft_sim_ros.report.units import UNKNOWN, labelled, port_units
from soft_sim_ros.scene.actuator import Units

_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_WRENCH_UNITS = ("N·m",) * 3 + ("N",) * 3
_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_POSE_UNITS = ("m",) * 3 + ("",) * 4
_CONTACT = (
    "s (m)",
    *(f"{axis} (m)" for axis in "xyz"),
    *(f"normal_{axis}" for axis in "xyz"),
    "gap (m)",
    "normal_force (N)",
    *(f"friction_{axis} (N)" for axis in "xyz"),
    *(f"slip_{axis} (m/s)" for axis in "xyz"),
)
_TWIST = ("wx", "wy", "wz", "vx", "vy", "vz")
_TWIST_UNITS = ("rad/s",) * 3 + ("m/s",) * 3
_WRENCH = ("moment_x", "moment_y", "moment_z", "force_x", "force_y", "force_z")


def export_csv(run: Run, directory: str | Path) -> list[Path]:
    """Write one table per recorded topic; numbers are exact, the first column is time in s.

    Columns of actuators name their units where the scene inside the recording tells them; all
    other values are SI. Topics that were not recorded make no table. Commands, wrenches and
    events share ``inputs.csv``, one line per value.

    Parameters
    ----------
    run : the recording
    directory : where the tables go; made if missing

    Returns
    -------
    list of Path
        the tables written
    """
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    written = []
    units = port_units(run)

    def table(name: str, time: NDArray, columns: Sequence[str], values: NDArray) -> None:
        if len(time) == 0:
            return
        path = directory / f"{name}.csv"
        with path.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(["time", *columns])
            rows = np.column_stack([time, values.reshape(len(time), -1)])
            writer.writerows(map(repr, row) for row in rows.tolist())
        written.append(path)

    for name, series in _poses(run).items():
        many = range(series.poses.shape[1]) if series.poses.ndim == 3 else ("",)
        columns = [f"{part}{index}" for index in many for part in _POSE]
        table(name, series.time, columns, series.poses)
    for name, readings in run.sensors.items():
        columns = ["measured", *readings.labels]
        values = np.column_stack([readings.measured, readings.values])
        table(f"sensor_{name}", readings.time, columns, values)
    for name, joints in (("joint_states", run.joint_states), ("strain_state", run.strain_state)):
        columns, values = _columns(joints, units if name == "joint_states" else {})
        table(name, joints.time, columns, values)
    for name, felt in run.reactions.items():
        columns = [labelled(*pair) for pair in zip(_WRENCH, _WRENCH_UNITS, strict=True)]
        table(f"reaction_{name}", felt.time, columns, felt.wrench)
    if len(run.contacts.at):
        path = directory / "contacts.csv"
        with path.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(["time", "body", "other", "sticks", *_CONTACT])
            found = run.contacts
            names = zip(found.body.tolist(), found.other.tolist(), found.sticks, strict=True)
            rows = np.column_stack([found.time[found.at], _contact_values(run)]).tolist()
            for row, (body, other, sticks) in zip(rows, names, strict=True):
                writer.writerow([repr(row[0]), body, other, int(sticks), *map(repr, row[1:])])
        written.append(path)
    table("energy", run.energy.time, run.energy.names, run.energy.values)
    if run.inputs:
        path = directory / "inputs.csv"
        with path.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(["time", "topic", "name", "value", "unit"])
            for entry in run.inputs:
                for name, value, unit in _values(entry, units):
                    writer.writerow([repr(entry.time_ns / 1e9), entry.topic, name, value, unit])
        written.append(path)
    return written


def export_npz(run: Run, file: str | Path) -> Path:
    """Write every array of a recording into one ``.npz`` file, times in ns and SI units.

    Parameters
    ----------
    run : the recording
    file : file to write; ``.npz`` is added if missing

    Returns
    -------
    Path
        the file written
    """
    path = Path(file)
    if path.suffix != ".npz":
        path = path.with_name(path.name + ".npz")
    arrays: dict[str, Any] = {}
    for name, series in _poses(run).items():
        arrays[f"{name}_time_ns"], arrays[f"{name}_poses"] = series.time_ns, series.poses
    arrays |= {
        "energy_time_ns": run.energy.time_ns,
        "energy_names": np.array(run.energy.names, dtype=str),
        "energy_values": run.energy.values,
    }
    for name, readings in run.sensors.items():
        own: dict[str, Any] = {"time_ns": readings.time_ns, "measured_ns": readings.measured_ns}
        own |= {"labels": np.array(readings.labels, dtype=str), "values": readings.values}
        arrays |= {f"sensor_{name}_{part}": array for part, array in own.items()}
    for name, joints in (("joint_states", run.joint_states), ("strain_state", run.strain_state)):
        arrays[f"{name}_time_ns"] = joints.time_ns
        arrays[f"{name}_name"] = np.array(joints.name, dtype=str)
        for field in ("position", "velocity", "effort"):
            arrays[f"{name}_{field}"] = getattr(joints, field)
    for name, felt in run.reactions.items():
        arrays[f"reaction_{name}_time_ns"] = felt.time_ns
        arrays[f"reaction_{name}_wrench"] = felt.wrench
    if len(contacts := run.contacts):
        arrays["contacts_time_ns"] = contacts.time_ns
        for field in ("at", "body", "other", "s", "point", "normal", "gap", "normal_force",
                      "friction", "slip", "sticks"):  # fmt: skip
            arrays[f"contacts_{field}"] = getattr(contacts, field)
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(path, **arrays)
    return path


def _poses(run: Run) -> dict[str, PoseSeries]:
    """Return all poses by the names of their tables; each of several has its own."""
    named = {f"backbone_{name}": one for name, one in run.backbones.items() if name}
    tips = {f"tip_pose_{name}": one for name, one in run.tip_poses.items() if name}
    return (named or {"backbone": run.backbone}) | {"tip_pose": run.tip_pose} | tips


def _contact_values(run: Run) -> NDArray:
    found = run.contacts
    parts = (found.s, found.point, found.normal, found.gap, found.normal_force, found.friction,
             found.slip)  # fmt: skip
    return np.column_stack(parts)


def _columns(joints: JointSeries, units: Mapping[str, Units]) -> tuple[list[str], NDArray]:
    names, blocks = [], []
    for field in ("position", "velocity", "effort"):
        values = getattr(joints, field)
        if values.shape[1]:
            names += [
                labelled(f"{field}:{name}", getattr(units.get(name, UNKNOWN), field))
                for name in joints.name
            ]
            blocks.append(values)
    return names, np.hstack(blocks) if blocks else np.empty((len(joints), 0))


def _values(entry: Input, units: Mapping[str, Units]) -> list[tuple[str, str, str]]:
    """Take one input apart into named values with the units of commands."""
    message = entry.message
    if isinstance(message, FloatArray):
        commands = [of.command for of in units.values()]
        commands += [""] * (len(message.data) - len(commands))
        return [(str(i), repr(v), commands[i]) for i, v in enumerate(message.data.tolist())]
    if isinstance(message, JointState):
        return [
            (f"{field}:{name}", repr(value), command if field == "effort" else "")
            for field in ("position", "velocity", "effort")
            for name, value in zip(message.name, getattr(message, field).tolist(), strict=False)
            for command in (units.get(name, UNKNOWN).command,)
        ]
    if isinstance(message, Wrench):
        values = zip(_WRENCH, message.wrench.tolist(), _WRENCH_UNITS, strict=True)
        return [(name, repr(value), unit) for name, value, unit in values]
    if isinstance(message, Poses | Odometry):
        pose = message.poses[0] if isinstance(message, Poses) else message.pose
        rows = list(zip(_POSE, pose.tolist(), _POSE_UNITS, strict=True))
        if isinstance(message, Odometry):
            rows += zip(_TWIST, message.twist.tolist(), _TWIST_UNITS, strict=True)
        return [(name, repr(value), unit) for name, value, unit in rows]
    return [("", str(message), "")]
