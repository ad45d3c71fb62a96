"""What a running node says: names, types, stamps, rates, qualities of service, diagnostics."""

import json
import time
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseArray, PoseStamped
from peer import simulator, wait_for
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from soft_sim_ros.recording.telemetry import LEDGER

SCENE = Path(__file__).with_name("arm.yaml")
POSES = 11


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    program = simulator(
        tmp_path_factory.mktemp("arm"),
        scene=SCENE,
        poses=POSES,
        frame_id="plate",
        publish_rate=50,
    )
    yield program
    assert program.end() == 0, program.text


def ns(stamp):
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def some(messages, count=5):
    wait_for(lambda: len(messages) >= count, f"{count} messages, got {len(messages)}")
    return list(messages)


def test_backbone_is_poses_from_base_to_tip_in_the_frame_of_the_parameter(arm, peer):
    message = some(peer.listen(PoseArray, "soft_arm/backbone"))[-1]
    assert message.header.frame_id == "plate"
    assert len(message.poses) == POSES
    base = message.poses[0].position
    assert (base.x, base.y, base.z) == pytest.approx((0.0, 0.0, 0.5), abs=1e-12)
    steps = np.diff([(p.position.x, p.position.y, p.position.z) for p in message.poses], axis=0)
    assert np.linalg.norm(steps, axis=1) == pytest.approx(0.3 / (POSES - 1), rel=1e-3)
    for pose in message.poses:
        q = pose.orientation
        assert q.x**2 + q.y**2 + q.z**2 + q.w**2 == pytest.approx(1.0, abs=1e-9)


def test_tip_pose_is_the_last_pose_of_the_backbone(arm, peer):
    backbone = peer.listen(PoseArray, "soft_arm/backbone")
    tip = peer.listen(PoseStamped, "soft_arm/tip_pose")
    some(tip), some(backbone)
    by_stamp = {ns(message.header.stamp): message.poses[-1] for message in list(backbone)}
    pairs = [(m.pose, by_stamp.get(ns(m.header.stamp))) for m in list(tip)]
    shared = [(pose, other) for pose, other in pairs if other is not None]
    assert shared
    assert all(pose == other for pose, other in shared)


def test_joint_states_are_conjugate_positions_velocities_and_efforts_by_actuator(arm, peer):
    message = some(peer.listen(JointState, "joint_states"))[-1]
    assert list(message.name) == ["pitch", "yaw"]
    assert len(message.position) == len(message.velocity) == len(message.effort) == 2
    assert list(message.effort) == [0.01, 0.0], "without commands: the safe efforts"


def test_strain_state_names_every_coordinate(arm, peer):
    message = some(peer.listen(JointState, "soft_arm/strain_state"))[-1]
    assert len(message.name) == len(set(message.name)) == len(message.position)
    assert len(message.velocity) == len(message.position)
    assert len(message.effort) == 0


def test_energy_says_what_its_numbers_are(arm, peer):
    message = some(peer.listen(Float64MultiArray, "soft_arm/energy"))[-1]
    assert [one.label for one in message.layout.dim] == list(LEDGER), "one for every number"
    assert {one.size for one in message.layout.dim} == {1}
    assert len(message.data) == len(LEDGER)
    assert np.isfinite(message.data).all()


def test_stamps_are_simulated_time_on_the_grid_of_the_publish_rate(arm, peer):
    messages = some(peer.listen(PoseArray, "soft_arm/backbone"), 10)
    stamps = np.array([ns(message.header.stamp) for message in messages])
    assert (np.diff(stamps) == 20_000_000).all()
    assert (stamps % 20_000_000 == 0).all()


def test_messages_come_at_the_publish_rate_of_real_time(arm, peer):
    messages = peer.listen(JointState, "joint_states")
    some(messages, 1)
    before, begin = len(messages), time.monotonic()
    time.sleep(2.0)
    rate = (len(messages) - before) / (time.monotonic() - begin)
    assert rate == pytest.approx(50.0, rel=0.1)


def test_the_clock_ticks_after_the_state_of_that_time_was_sent(arm, peer):
    arrivals = []
    for kind, topic, stamp in (
        (JointState, "joint_states", lambda m: m.header.stamp),
        (Clock, "/clock", lambda m: m.clock),
    ):
        peer.node.create_subscription(
            kind, topic, lambda m, s=stamp, t=topic: arrivals.append((t, ns(s(m)))), 100
        )
    wait_for(lambda: len(arrivals) > 60, "ticks and states")
    seen = list(arrivals)
    first = max(next(s for t, s in seen if t == topic) for topic in ("/clock", "joint_states"))
    ticks = [s for t, s in seen if t == "/clock" and s >= first]
    states = [s for t, s in seen if t == "joint_states" and s >= first]
    common = min(len(ticks), len(states))
    assert ticks[:common] == states[:common]
    # DDS keeps the order within a topic only; across topics the later one must not lead by a period
    for position, (topic, stamp) in enumerate(seen):
        if topic == "/clock" and stamp > first:
            assert ("joint_states", stamp - 20_000_000) in seen[:position]


def test_the_topics_have_the_names_and_types_of_the_manual(arm, peer):
    some(peer.listen(JointState, "joint_states"), 1)
    known = dict(peer.node.get_topic_names_and_types())
    expected = {
        "/soft_arm/backbone": "geometry_msgs/msg/PoseArray",
        "/joint_states": "sensor_msgs/msg/JointState",
        "/soft_arm/strain_state": "sensor_msgs/msg/JointState",
        "/soft_arm/energy": "std_msgs/msg/Float64MultiArray",
        "/soft_arm/tip_pose": "geometry_msgs/msg/PoseStamped",
        "/soft_arm/events": "std_msgs/msg/String",
        "/soft_arm/command": "std_msgs/msg/Float64MultiArray",
        "/soft_arm/joint_command": "sensor_msgs/msg/JointState",
        "/soft_arm/external_wrench": "geometry_msgs/msg/WrenchStamped",
        "/clock": "rosgraph_msgs/msg/Clock",
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    }
    assert {name: known.get(name) for name in expected} == {n: [t] for n, t in expected.items()}


def test_state_is_offered_reliable_and_commands_are_taken_reliable_with_depth_one(arm, peer):
    some(peer.listen(JointState, "joint_states"), 1)
    (state,) = peer.node.get_publishers_info_by_topic("/joint_states")
    assert state.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    assert state.qos_profile.durability == DurabilityPolicy.VOLATILE
    (command,) = peer.node.get_subscriptions_info_by_topic("/soft_arm/command")
    assert command.qos_profile.reliability == ReliabilityPolicy.RELIABLE


def test_a_best_effort_listener_hears_as_well(arm, peer):
    best_effort = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    some(peer.listen(PoseArray, "soft_arm/backbone", best_effort), 3)


def test_an_incompatible_listener_is_reported(arm, peer):
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    peer.listen(PoseArray, "soft_arm/backbone", latched)
    arm.wait_for_text("incompatible QoS")
    assert "/soft_arm/backbone" in arm.text


def test_diagnostics_tell_how_the_node_is_doing_once_a_second(arm, peer):
    messages = peer.listen(DiagnosticArray, "/diagnostics")
    begin = time.monotonic()
    some(messages, 3)
    assert 1.5 < time.monotonic() - begin < 4.5
    (status,) = messages[-1].status
    assert status.name == "soft_arm: physics"
    assert status.hardware_id == "test_arm"
    assert status.level in (DiagnosticStatus.OK, DiagnosticStatus.WARN)
    values = {entry.key: entry.value for entry in status.values}
    assert float(values["real-time factor"]) == pytest.approx(1.0, rel=0.1)
    assert 0.0 < float(values["step cost p50 (us)"]) <= float(values["step cost p99 (us)"])
    assert abs(float(values["energy residual (J)"])) < 1.0
    assert values["command age (s)"] == "none"
    assert values["dropped log messages"] == "0"
    assert values["last error"] == "none"
    assert int(values["overruns"]) >= 0


def test_the_real_time_factor_changes_while_running_also_to_a_whole_number(arm, peer):
    ticks = peer.listen(Clock, "/clock")

    def speed(factor):
        request = SetParameters.Request(
            parameters=[Parameter("real_time_factor", value=factor).to_parameter_msg()]
        )
        (result,) = peer.ask(SetParameters, "soft_arm/set_parameters", request).results
        assert result.successful, result.reason
        time.sleep(0.3)
        some(ticks, 1)
        first, begin = ns(ticks[-1].clock), time.monotonic()
        time.sleep(1.0)
        return (ns(ticks[-1].clock) - first) / 1e9 / (time.monotonic() - begin)

    assert speed(0.5) == pytest.approx(0.5, rel=0.15)
    assert speed(2) == pytest.approx(2.0, rel=0.15)
    assert speed(1.0) == pytest.approx(1.0, rel=0.15)


def test_arms_live_side_by_side_in_namespaces_and_one_of_them_owns_time(tmp_path, arm, peer):
    other = simulator(
        tmp_path,
        "-r",
        "__ns:=/left",
        "-p",
        "qos_overrides./left/soft_arm/backbone.publisher.reliability:=best_effort",
        scene=SCENE,
        publish_clock="false",
        poses=5,
    )
    try:
        assert len(some(peer.listen(PoseArray, "soft_arm/backbone"), 2)[-1].poses) == POSES
        best_effort = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
        left = some(peer.listen(PoseArray, "/left/soft_arm/backbone", best_effort), 2)
        assert len(left[-1].poses) == 5
        some(peer.listen(JointState, "/left/joint_states"), 2)
        (offered,) = peer.node.get_publishers_info_by_topic("/left/soft_arm/backbone")
        assert offered.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
        (clock,) = peer.node.get_publishers_info_by_topic("/clock")
        assert clock.node_namespace == "/"
    finally:
        assert other.end() == 0, other.text


def test_a_node_with_a_tolerance_says_how_far_off_the_tip_may_be(tmp_path, peer):
    text = SCENE.read_text()
    scene = tmp_path / "exact.yaml"
    scene.write_text(
        text[: text.index("numerics:")] + "numerics: {step: 0.002, tolerance: 1.0e-3}\n"
    )
    program = simulator(tmp_path, scene=scene, record=tmp_path / "run")
    assert "meets the tolerance in a probe: arm: orders bend_y" in program.text
    reports = peer.listen(DiagnosticArray, "/diagnostics")
    hand = peer.talk(Float64MultiArray, "soft_arm/command")
    wait_for(hand.get_subscription_count, "the subscription")

    def estimate() -> float:
        hand.publish(Float64MultiArray(data=[0.3, 0.2]))
        values = {v.key: v.value for m in list(reports)[-1:] for v in m.status[0].values}
        return float(values.get("error estimate (of the length)", "0"))

    wait_for(lambda: estimate() > 0.0, "an estimate")
    assert program.end() == 0, program.text
    accuracy = json.loads((tmp_path / "run" / "summary.json").read_text())["accuracy"]
    assert accuracy["tolerance"] == 1e-3 and 0.0 < accuracy["error_rel"] < 1e-3
