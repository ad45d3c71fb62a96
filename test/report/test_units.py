"""Nothing is drawn or written in a unit that it does not have."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from soft_sim_ros.recording import cdr
from soft_sim_ros.recording.reader import Run, read_run
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter
from soft_sim_ros.report import export_csv
from soft_sim_ros.report.numbers import motion_rows
from soft_sim_ros.report.plots import actuators

SCENE = """\
materials: {m: {young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}}
bodies:
  - {joint: slide, kind: prismatic, axis: [1, 0, 0]}
  - rod: arm
    sections:
      - {name: s, length: 0.2, material: m, cross_section: {shape: circle, radius: 0.02}}
actuators:
  - {chamber: muscle, rod: arm, offset: [0.01, 0], area: 1e-4}
  - {moment: bend, rod: arm, section: s, strain: bend_y}
  - {joint_force: push, joint: slide}
  - {tendon: rope, rod: arm, offset: [0, 0.01]}
  - {tendon: winch, rod: arm, offset: [0, 0.01], control: length, axial_stiffness: 9.0}
"""
NAMES = ("muscle", "bend", "push", "rope", "winch")
UNITS = {
    "muscle": ("m³", "m³/s", "Pa"),
    "bend": ("rad", "rad/s", "N·m"),
    "push": ("m", "m/s", "N"),
    "rope": ("m", "m/s", "N"),
    "winch": ("m", "m/s", "N"),
}


def recorded(directory: Path, scene: str | None) -> Run:
    """Record five ports for a while, effort (i + 1)·10ⁱ of port i at the end."""
    attachments = {} if scene is None else {"scene.yaml": scene.encode()}
    joints = cdr.JointStateBuffer(list(NAMES))
    with BagWriter(directory, recorded_topics("/soft_arm"), attachments=attachments) as bag:
        bag.write("command", 0, cdr.encode_floats([1.0, 2.0, 3.0, 4.0, 0.5]))
        wrench = cdr.WrenchStampedBuffer("world").fill(0, [0, 0, 1, 0, 0, 2])
        bag.write("external_wrench", 0, wrench)
        for index in range(5):
            values = np.array([(i + 1) * 10.0**i for i in range(5)]) * index / 4
            bag.write("joint_states", index * 10_000_000, joints.fill(0, values, values, values))
    return read_run(directory)


@pytest.fixture
def run(tmp_path: Path) -> Run:
    return recorded(tmp_path / "run", SCENE)


def shown(run: Run) -> dict[str, set[str]]:
    """Return the labels of the axes that each port is drawn on."""
    found: dict[str, set[str]] = {name: set() for name in NAMES}
    for axes in actuators(run).axes:
        for line in axes.lines:
            if line.get_label() in found:
                found[line.get_label()].add(axes.get_ylabel())
    return found


def test_lines_share_axes_only_with_lines_of_their_unit(run: Run) -> None:
    assert shown(run) == {name: {p, e} for name, (p, _, e) in UNITS.items()}


def test_a_table_has_the_unit_of_every_column_of_a_port(run: Run, tmp_path: Path) -> None:
    export_csv(run, tmp_path / "tables")
    header = (tmp_path / "tables" / "joint_states.csv").read_text("utf-8").splitlines()[0]
    expected = ["time"]
    for place, field in enumerate(("position", "velocity", "effort")):
        expected += [f"{field}:{name} ({UNITS[name][place]})" for name in NAMES]
    assert header.split(",") == expected


def test_a_table_of_inputs_has_the_unit_of_every_command(run: Run, tmp_path: Path) -> None:
    export_csv(run, tmp_path / "tables")
    lines = (tmp_path / "tables" / "inputs.csv").read_text("utf-8").splitlines()
    assert lines[0] == "time,topic,name,value,unit"
    commands = [line.rpartition(",")[2] for line in lines if "/command," in line]
    assert commands == ["Pa", "N·m", "N", "N", "m"]
    wrench = [line.rpartition(",")[2] for line in lines if "wrench" in line]
    assert wrench == ["N·m"] * 3 + ["N"] * 3


def test_the_largest_effort_is_that_of_its_unit(run: Run) -> None:
    told = dict(motion_rows(run))["Largest effort"]
    assert told == "1 Pa (muscle), 20 N·m (bend), 5e+04 N (winch)"


@pytest.mark.parametrize("scene", [None, "bodies: [{from: a later version}]\n"])
def test_without_a_scene_no_unit_is_claimed(scene: str | None, tmp_path: Path) -> None:
    run = recorded(tmp_path / "run", scene)
    assert shown(run) == {name: {""} for name in NAMES}
    export_csv(run, tmp_path / "tables")
    assert "(" not in (tmp_path / "tables" / "joint_states.csv").read_text("utf-8")
