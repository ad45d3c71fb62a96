"""Runs into recordings hold readings of sensors at their own rate, and can be computed again."""

import numpy as np
import pytest

from soft_sim_ros import Rollout, parse_scene, read_run, rerun
from soft_sim_ros.batch.programme import Programme
from soft_sim_ros.commands.check import sections
from soft_sim_ros.report import export_csv, export_npz, write_report

SCENE = """
name: pendulum
bodies:
  - {joint: hinge, kind: revolute, axis: [0, 1, 0], stiffness: 0.1}
  - {rigid_body: bob, mass: 0.1, inertia: [1e-4, 1e-4, 1e-4], com: {position: [0.2, 0, 0]}}
actuators:
  - {joint_torque: motor, joint: hinge}
numerics: {step: 0.001}
sensors:
  - {encoder: angle, joint: hinge, rate: 300}
  - {imu: unit, body: bob, rate: 250, latency: 0.0105, noise: {acceleration: 0.1}}
  - {wrench: cell, body: hinge, rate: 50}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sensed") / "run"
    times = np.array([0.0, 0.0313, 0.1])
    programme = Programme(times, np.array([[0.05], [-0.1], [0.02]]))
    Rollout(parse_scene(SCENE), folder, programme, publish_rate=40.0).run(0.2)
    return read_run(folder)


def test_readings_come_at_their_own_rate_stamped_when_they_were_measured(run):
    assert len(run.tip_pose) == 9
    found = run.sensors
    assert {name: len(one) for name, one in found.items()} == {"angle": 61, "unit": 48, "cell": 11}
    unit = found["unit"]
    assert unit.measured_ns[:3].tolist() == [0, 4_000_000, 8_000_000]
    assert set(unit.time_ns - unit.measured_ns) == {11_000_000}
    assert unit["acceleration"].shape == (48, 3)
    assert found["angle"].time_ns[:3].tolist() == [0, 4_000_000, 7_000_000]
    joints = run.joint_states
    shared = sorted({*joints.time_ns.tolist()} & {*found["cell"].time_ns.tolist()})
    assert len(shared) > 1


def test_a_run_with_sensors_is_computed_again_to_the_bit(run):
    result = rerun(run)
    assert result.identical, result
    assert result.largest["/soft_arm/sensors/unit"] == 0.0


def test_another_seed_changes_readings_and_not_the_motion(run):
    scene = parse_scene(SCENE.replace("latency", "seed: 5, latency"))
    result = rerun(run, scene)
    differs = {name for name, most in result.largest.items() if most > 0.0}
    assert differs == {"/soft_arm/sensors/unit"}


def test_report_and_tables_show_every_sensor(run, tmp_path):
    page = write_report(run.path, tmp_path / "report.html").read_text("utf-8")
    assert all(f"<h2>Sensor {name}</h2>" in page for name in run.sensors)
    tables = {path.name: path for path in export_csv(run, tmp_path)}
    lines = tables["sensor_angle.csv"].read_text("utf-8").splitlines()
    assert lines[0] == "time,measured,position/hinge,velocity/hinge"
    assert len(lines) == 62
    with np.load(export_npz(run, tmp_path / "run.npz")) as arrays:
        np.testing.assert_array_equal(arrays["sensor_cell_values"], run.sensors["cell"].values)
        assert arrays["sensor_cell_labels"].tolist()[0] == "torque/x"


def test_check_lists_sensors():
    lines = list(sections(parse_scene(SCENE)))
    assert "sensor angle: encoder of hinge at 300 Hz" in lines
    assert "sensor unit: imu of bob at 250 Hz, 0.0105 s late, with noise" in lines
