"""Sensors in scenes: what is read, and what is refused with which words."""

import numpy as np
import pytest

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import parse_scene

TEXT = """
materials:
  rubber: {{density: 1100, young_modulus: 1.0e6, poisson_ratio: 0.5}}
bodies:
  - {{joint: hinge, kind: revolute, axis: [0, 1, 0]}}
  - {{joint: ball, kind: spherical}}
  - rod: arm
    sections:
      - {{name: a, length: 0.4, material: rubber, cross_section: {{shape: circle, radius: 0.01}}}}
  - {{rigid_body: tool, mass: 0.1}}
actuators:
  - {{tendon: pull, rod: arm, offset: [0.0, 0.01]}}
  - {{joint_torque: motor, joint: hinge}}
sensors:
  - {}
"""


def read(entry):
    return parse_scene(TEXT.format(entry), "arm.yaml").sensors[0]


def test_what_is_not_written_has_its_default():
    one = read("{strain: gauge, rod: arm}")
    assert (one.name, one.kind, one.of, one.s) == ("gauge", "strain", "arm", (0.2,))
    assert (one.rate, one.seed, one.latency, one.labels) == (100.0, 0, 0.0, ("strain",))
    np.testing.assert_array_equal(one.direction, [1, 0, 0])
    assert not one.noise.any() and not one.bias.any()
    assert read("{imu: unit, body: arm}").s == (0.4,)
    assert read("{imu: unit, body: tool}").s == ()


def test_noise_is_by_quantity_and_by_component():
    one = read("{imu: unit, body: tool, noise: {acceleration: [1, 2, 3], orientation: 0.1}}")
    assert one.noise.tolist() == [0.1, 0.1, 0.1, 0, 0, 0, 0, 1, 2, 3]
    one = read("{curvature: fbg, rod: arm, s: [0.1, 0.2], noise: [1, 2, 3, 4, 5, 6]}")
    assert one.noise.tolist() == [1, 2, 3, 4, 5, 6]
    assert one.labels[3] == "curvature/1/torsion"
    one = read("{encoder: angle, joint: hinge, bias: {velocity: -0.5}}")
    assert dict(zip(one.labels, one.bias, strict=True)) == {
        "position/hinge": 0.0,
        "velocity/hinge": -0.5,
    }


def test_sensors_of_one_seed_have_streams_of_their_own():
    one, other = read("{strain: a, rod: arm}"), read("{strain: b, rod: arm}")
    assert one.seed == other.seed and one.stream != other.stream


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("{gauge: a}", r"sensors\[0\].* one of the keys strain, curvature, imu, wrench"),
        ("{imu: a, strain: b, body: arm}", "only one of strain and imu"),
        ("{strain: a, rod: leg}", r"sensors\[0\].rod = leg: expected the name of a rod"),
        ("{strain: a, rod: arm, s: 0.5}", r"sensors\[0\].s = 0.5: expected a number in \[0, 0.4"),
        ("{strain: a, rod: arm, direction: [0, 0, 0]}", "direction, not a vector of length 0"),
        ("{strain: a, rod: arm, body: arm}", "body = arm: expected a known key"),
        ("{curvature: a, rod: arm, s: []}", "at least one arc length"),
        ("{imu: a, body: tool, s: 0.1}", "no such key: tool is not a rod"),
        ("{imu: a, body: tool, noise: 0.1}", "a mapping: orientation, angular_velocity, accel"),
        ("{imu: a, body: tool, noise: {acceleratoin: 1}}", "did you mean acceleration"),
        ("{imu: a, body: tool, noise: {acceleration: -1}}", "a number >= 0"),
        ("{imu: a, body: tool, noise: {acceleration: [1, 2]}}", "a list of 3 entries"),
        ("{wrench: a, body: tool}", "the name of a joint or rod, one of hinge, ball, arm"),
        ("{tendon: a, actuator: motor}", "the name of a tendon, one of pull"),
        ("{encoder: a, joint: ball}", "revolute, prismatic or universal joint, one of hinge"),
        ("{encoder: a, joint: hinge, rate: 0}", "rate = 0: expected a number > 0"),
        ("{encoder: a, joint: hinge, seed: 1.5}", "seed = 1.5: expected a whole number"),
        ("{encoder: a, joint: hinge, latency: -1}", "latency = -1: expected a number in"),
        ("{encoder: a, joint: hinge, rate: 1e6, latency: 10}", "at most 0.1 s at 1e\\+06 Hz"),
        ("{encoder: a, joint: hinge}\n  - {encoder: a, joint: hinge}", "a name that is not used"),
    ],
)
def test_what_makes_no_sense_is_refused_by_its_key(entry, words):
    with pytest.raises(SceneError, match=words):
        read(entry)
