"""Readings as messages: bytes that other libraries understand, and read back as they were."""

import numpy as np
import pytest

from soft_sim_ros.core.simulation.reading import Reading
from soft_sim_ros.recording.decode import decode, stack
from soft_sim_ros.recording.metadata import Channel
from soft_sim_ros.recording.sensor_series import find_sensors, series_of
from soft_sim_ros.recording.sensors import SensorMessages, sensor_topics
from soft_sim_ros.recording.topics import IMU, JOINTS, POSES, WRENCH
from soft_sim_ros.scene import parse_scene

SCENE = """
materials:
  rubber: {density: 1100, young_modulus: 1.0e6, poisson_ratio: 0.5}
bodies:
  - {joint: swing, kind: universal, axes: [[0, 1, 0], [0, 0, 1]]}
  - rod: arm
    sections:
      - {name: a, length: 0.4, material: rubber, cross_section: {shape: circle, radius: 0.01}}
actuators:
  - {tendon: pull, rod: arm, offset: [0.0, 0.01]}
sensors:
  - {strain: gauge, rod: arm}
  - {curvature: fbg, rod: arm, s: [0.1, 0.2]}
  - {imu: unit, body: arm, noise: {acceleration: [0.1, 0.2, 0.3]}}
  - {wrench: cell, body: swing}
  - {tendon: line, actuator: pull}
  - {encoder: angles, joint: swing}
"""
SENSORS = parse_scene(SCENE).sensors
TIME = 3_000_000_007


class Arm:
    """Something with readings: any numbers."""

    time_ns = TIME + 5

    def __init__(self):
        rng = np.random.default_rng(1)
        self.readings = {
            one.name: Reading(
                one.name, one.kind, TIME, TIME + 5, one.labels, rng.normal(size=len(one.labels))
            )
            for one in SENSORS
        }

    def sensors(self):
        return self.readings


def made():
    arm = Arm()
    return arm, SensorMessages(arm, SENSORS, "/left/soft_arm", lambda: 1_000_000_000)


@pytest.mark.parametrize("one", SENSORS, ids=lambda one: one.name)
def test_a_reading_comes_back_as_it_was(one):
    arm, messages = made()
    topic = {topic.key: topic for topic in messages.topics}[f"sensors/{one.name}"]
    assert topic.name == f"/left/soft_arm/sensors/{one.name}"
    data = messages.message(one.name)
    series = series_of(topic.type, np.array([TIME + 5]), stack(topic.type, [data]))
    assert series.labels == one.labels
    np.testing.assert_array_equal(series.values[0], arm.readings[one.name].values)
    assert series.measured_ns.tolist() == [TIME + 1_000_000_000]
    assert series.frame_id == (f"left/soft_arm/sensors/{one.name}" if one.framed else "")
    quantity = one.labels[0].split("/")[0]
    np.testing.assert_array_equal(
        np.ravel(series[quantity][0]), np.ravel(arm.readings[one.name][quantity])
    )
    assert decode(topic.type, data).stamp_ns == TIME + 1_000_000_000


@pytest.mark.parametrize("one", SENSORS, ids=lambda one: one.name)
def test_another_library_writes_the_same_bytes(one):
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    (topic,) = sensor_topics("/left/soft_arm", [one])
    data = made()[1].message(one.name)
    message = store.deserialize_cdr(data, topic.type)
    assert bytes(store.serialize_cdr(message, topic.type)) == data


def test_an_imu_tells_its_variances_and_zero_where_it_knows_none():
    from rosbags.typesys import Stores, get_typestore

    message = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(made()[1].message("unit"), IMU)
    variance = np.diag([0.1**2, 0.2**2, 0.3**2]).ravel()
    np.testing.assert_allclose(message.linear_acceleration_covariance, variance)
    assert not message.orientation_covariance.any()
    assert not message.angular_velocity_covariance.any()


def test_a_reading_is_handed_out_once_when_it_gets_out():
    arm, messages = made()
    assert [key for key, _ in messages.new()] == [f"sensors/{one.name}" for one in SENSORS]
    assert not list(messages.new())
    arm.time_ns += 1  # none of them got out just now
    messages = SensorMessages(arm, SENSORS, "/soft_arm")
    assert not list(messages.new())
    assert len(list(messages.newest())) == len(SENSORS)


def channels(*topics):
    return [Channel(name, kind, "", {}) for name, kind in topics]


def test_sensors_are_found_below_a_node_and_are_not_taken_for_anything_else():
    arm = [("/soft_arm/backbone", POSES), ("/soft_arm/sensors/joint_states", JOINTS)]
    assert find_sensors(channels(*arm), None) == {"joint_states": 1}
    # a node may be called sensors
    odd = [("/sensors/backbone", POSES), ("/sensors/strain_state", JOINTS)]
    assert find_sensors(channels(*odd), None) == {}
    two = [*arm, ("/other/backbone", POSES), ("/other/sensors/imu", IMU)]
    assert find_sensors(channels(*two), "/other") == {"imu": 3}
    foreign = [("/camera/sensors/imu", IMU), ("/arm/sensors/force", WRENCH)]
    assert find_sensors(channels(*foreign), None) == {}
