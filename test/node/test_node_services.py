"""Pause, step and reset: exactly, and only when they make sense."""

import re
import time
from pathlib import Path

import numpy as np
import pytest
import yaml
from peer import simulator, wait_for
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String

SCENE = Path(__file__).with_name("arm.yaml")
PERIOD_NS = 10_000_000


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    result = simulator(tmp_path_factory.mktemp("arm"), scene=SCENE, command_timeout=0)
    yield result
    assert result.end() == 0, result.text


@pytest.fixture
def arm(program, peer):
    states = peer.listen(JointState, "soft_arm/strain_state", 1000)
    wait_for(lambda: states, "a state")
    yield states
    peer.pause(False)


def stamp(message):
    return message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec


def bits(message):
    return bytes(message.position), bytes(message.velocity)


def last(states):
    """Last state, when no more come."""
    count = -1
    while count != len(states):
        count = len(states)
        time.sleep(0.2)
    return states[-1]


def test_pausing_freezes_time_and_every_bit_of_the_state(arm, peer):
    moving = peer.talk(Float64MultiArray, "soft_arm/command")
    moving.publish(Float64MultiArray(data=[0.3, 0.2]))
    time.sleep(0.1)
    ticks = peer.listen(Clock, "/clock")
    assert peer.pause(True).success
    frozen = last(arm)
    assert any(abs(v) > 0.0 for v in frozen.velocity), "the arm must be moving to prove anything"
    count, tick_count = len(arm), len(ticks)
    time.sleep(0.5)
    assert (len(arm), len(ticks)) == (count, tick_count)
    assert peer.pause(True).success, "pausing twice is no error"
    assert peer.pause(False).success
    wait_for(lambda: len(arm) > count, "the arm to move on")
    assert 0 < stamp(arm[count]) - stamp(frozen) <= PERIOD_NS


def test_a_frozen_state_is_the_state_that_the_next_step_starts_from(arm, peer):
    # Two steps of one period from a state equal one uninterrupted stretch of two periods.
    def two_periods(interrupted):
        assert peer.pause(True).success
        assert peer.trigger("soft_arm/reset").success
        start = last(arm)
        moving = peer.talk(Float64MultiArray, "soft_arm/command")
        moving.publish(Float64MultiArray(data=[0.3, 0.2]))
        time.sleep(0.2)
        for _ in range(2):
            assert peer.trigger("soft_arm/step").success
            if interrupted:
                time.sleep(0.3)
        end = last(arm)
        assert stamp(end) - stamp(start) == 2 * PERIOD_NS
        return np.array([end.position, end.velocity])

    # Not bit for bit: they happen at other times, and times are rounded.
    waited, at_once = two_periods(interrupted=True), two_periods(interrupted=False)
    assert np.abs(waited).max() > 0.01
    assert waited == pytest.approx(at_once, rel=1e-9, abs=1e-12)


def test_a_step_is_one_publish_period_and_only_for_a_paused_arm(arm, peer):
    refused = peer.trigger("soft_arm/step")
    assert not refused.success
    assert "not paused" in refused.message
    assert peer.pause(True).success
    before = last(arm)
    assert peer.trigger("soft_arm/step").success
    after = last(arm)
    assert 0 < stamp(after) - stamp(before) == PERIOD_NS


def test_reset_restores_the_initial_state_and_time_goes_on(arm, peer):
    moving = peer.talk(Float64MultiArray, "soft_arm/command")
    assert peer.pause(True).success
    assert peer.trigger("soft_arm/reset").success
    initial = last(arm)
    moving.publish(Float64MultiArray(data=[0.3, 0.2]))
    time.sleep(0.2)
    for _ in range(5):
        assert peer.trigger("soft_arm/step").success
    moved = last(arm)
    assert bits(moved) != bits(initial)
    assert peer.trigger("soft_arm/reset").success
    again = last(arm)
    assert bits(again) == bits(initial)
    assert stamp(again) == stamp(moved) > stamp(initial)
    assert set(again.velocity) == {0.0}


def test_what_the_services_did_is_told_on_events(arm, peer):
    events = peer.listen(String, "soft_arm/events")
    time.sleep(0.2)
    peer.pause(True)
    peer.trigger("soft_arm/step")
    peer.trigger("soft_arm/reset")
    peer.pause(False)
    wait_for(lambda: len(events) >= 4, "four events")
    assert [m.data for m in events] == ["pause", "step", "reset", "resume"]


def test_a_step_of_too_many_steps_ends_by_itself_and_says_how_many_it_made(arm, peer):
    """While it steps, nothing else of the node answers."""

    def ask_for(count):
        parameter = Parameter("step_count", value=count).to_parameter_msg()
        request = SetParameters.Request(parameters=[parameter])
        (result,) = peer.ask(SetParameters, "soft_arm/set_parameters", request).results
        assert result.successful, result.reason

    assert peer.pause(True).success
    before = stamp(last(arm))
    ask_for(1_000_000)
    try:
        begin = time.monotonic()
        answer = peer.trigger("soft_arm/step")
        assert time.monotonic() - begin < 10.0
    finally:
        ask_for(0)
    assert not answer.success
    made = int(re.match(r"(\d+) of 1000000 steps, now at t = ", answer.message)[1])
    assert 0 < made < 1_000_000
    step_ns = round(1e9 * yaml.safe_load(SCENE.read_text())["numerics"]["step"])
    assert stamp(last(arm)) - before == made * step_ns  # it holds what was said
