"""Telemetry says what the simulation says, and builds nothing that nobody asked for."""

from __future__ import annotations

import numpy as np
import pytest

from soft_sim_ros.recording import topics
from soft_sim_ros.recording.decode import decode
from soft_sim_ros.recording.telemetry import LEDGER, Telemetry


@pytest.fixture
def telemetry(arm) -> Telemetry:
    arm.advance(123_456_789)
    return Telemetry(arm, 11, "base", "/left/soft_arm")


def test_topics_are_named_like_those_of_a_node(telemetry: Telemetry) -> None:
    names = {topic.key: (topic.name, topic.type) for topic in telemetry.topics}
    assert names == {
        "backbone": ("/left/soft_arm/backbone", topics.POSES),
        "joint_states": ("/left/joint_states", topics.JOINTS),
        "strain_state": ("/left/soft_arm/strain_state", topics.JOINTS),
        "energy": ("/left/soft_arm/energy", topics.FLOATS),
        "tip_pose": ("/left/soft_arm/tip_pose", topics.POSE),
    }
    assert topics.topic("joint_states", "/soft_arm").name == "/joint_states"


def test_every_message_carries_the_state_at_its_time(arm, telemetry: Telemetry) -> None:
    backbone = decode(topics.POSES, telemetry.backbone())
    assert (backbone.stamp_ns, backbone.frame_id) == (arm.time_ns, "base")
    np.testing.assert_array_equal(backbone.poses, arm.poses())
    tip = decode(topics.POSE, telemetry.tip_pose())
    np.testing.assert_array_equal(tip.poses[0], arm.poses()[-1])
    assert tip.stamp_ns == arm.time_ns

    joints = decode(topics.JOINTS, telemetry.joint_states())
    assert joints.name == arm.actuator_names
    expected = arm.ports()
    for got, put in zip((joints.position, joints.velocity, joints.effort), expected, strict=True):
        np.testing.assert_array_equal(got, put)

    strains = decode(topics.JOINTS, telemetry.strain_state())
    assert strains.name == arm.coordinate_names and strains.effort.size == 0
    np.testing.assert_array_equal(strains.position, arm.q)
    np.testing.assert_array_equal(strains.velocity, arm.v)

    energy = decode(topics.FLOATS, telemetry.energy())
    assert energy.labels == tuple(LEDGER)
    np.testing.assert_array_equal(energy.data, arm.ledger())


def test_poses_are_sampled_only_when_asked_for_and_once_per_state(arm, telemetry) -> None:
    telemetry.joint_states(), telemetry.strain_state(), telemetry.energy()
    assert arm.sampled == 0
    telemetry.backbone(), telemetry.tip_pose(), telemetry.backbone()
    assert arm.sampled == 1


def test_a_reset_at_the_same_time_is_seen(arm, telemetry: Telemetry) -> None:
    before = telemetry.backbone()
    arm.q = np.zeros_like(arm.q)  # the time goes on after a reset, the state does not
    after = decode(topics.POSES, telemetry.backbone())
    assert after.stamp_ns == decode(topics.POSES, before).stamp_ns
    np.testing.assert_array_equal(after.poses, arm.poses())


def test_one_pose_is_not_a_backbone(arm) -> None:
    with pytest.raises(ValueError, match="poses = 1: expected at least 2"):
        Telemetry(arm, 1, "base", "/soft_arm")
