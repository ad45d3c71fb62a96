"""Who comes while nothing moves sees the arm; who was there hears nothing twice."""

import time
from pathlib import Path

import pytest
from geometry_msgs.msg import PoseArray
from peer import simulator, wait_for
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

SCENE = Path(__file__).with_name("arm.yaml")


def stamps(messages):
    return {m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in list(messages)}


@pytest.fixture
def paused(tmp_path):
    latched = "qos_overrides./soft_arm/backbone.publisher.durability:=transient_local"
    program = simulator(
        tmp_path, "-p", latched, scene=SCENE, start_paused="true", record=tmp_path / "run"
    )
    yield program
    if program.process.poll() is None:
        assert program.end() == 0, program.text


def test_a_late_joiner_on_a_paused_arm_sees_its_state_and_its_time(paused, peer):
    first = peer.listen(JointState, "joint_states")
    ticks = peer.listen(Clock, "/clock")
    wait_for(lambda: first and ticks, "the state at the start")
    assert peer.trigger("soft_arm/step").success
    wait_for(lambda: 10_000_000 in stamps(first), "the state after the step")
    time.sleep(1.5)
    heard = len(first)
    late = peer.listen(JointState, "soft_arm/strain_state")
    wait_for(lambda: late, "the state for who came late")
    assert stamps(late) == {10_000_000}
    time.sleep(0.5)
    assert len(first) == heard, "others hear nothing twice"
    assert ticks[-1].clock.nanosec == 10_000_000
    # nothing of it is in the recording: five topics at 0 and at 10 ms, and the step
    assert paused.end() == 0, paused.text
    assert "; 11 messages recorded" in paused.text


def test_a_latched_topic_keeps_its_last_message_for_who_comes_later(paused, peer):
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    begin = time.monotonic()
    late = peer.listen(PoseArray, "soft_arm/backbone", latched)
    wait_for(lambda: late, "the latched state")
    assert time.monotonic() - begin < 3.0
    assert "incompatible" not in paused.text


def test_the_clock_has_a_rate_of_its_own(tmp_path, peer):
    program = simulator(
        tmp_path, scene=SCENE, publish_rate=50, clock_rate=500, start_paused="true", step_count=100
    )
    ticks, states = peer.listen(Clock, "/clock", 1000), peer.listen(JointState, "joint_states")
    wait_for(lambda: ticks and states, "the start")
    assert peer.trigger("soft_arm/step").success
    times = lambda: {m.clock.sec * 10**9 + m.clock.nanosec for m in list(ticks)}  # noqa: E731
    wait_for(lambda: max(times()) == 100_000_000, "the last tick")
    assert sorted(times()) == list(range(0, 100_000_001, 2_000_000))
    assert stamps(states) == set(range(0, 100_000_001, 20_000_000))
    assert program.end() == 0, program.text
