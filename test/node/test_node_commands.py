"""Commands move the arm; bad ones are refused in words and change nothing."""

import time
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from peer import simulator, wait_for
from rcl_interfaces.msg import Log
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String

SCENE = Path(__file__).with_name("arm.yaml")
TIMEOUT, RAMP = 0.1, 0.05


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    result = simulator(
        tmp_path_factory.mktemp("arm"),
        scene=SCENE,
        start_paused="true",
        command_timeout=TIMEOUT,
        command_ramp=RAMP,
        real_time_factor=0,
        publish_rate=1000,
    )
    yield result
    assert result.end() == 0, result.text


class Bench:
    """A paused arm that is stepped by hand: every test begins at its initial state."""

    def __init__(self, program, peer):
        self.program, self.peer = program, peer
        self.joints = peer.listen(JointState, "joint_states", 1000)
        self.events = peer.listen(String, "soft_arm/events", 1000)
        self.command = peer.talk(Float64MultiArray, "soft_arm/command")
        self.joint_command = peer.talk(JointState, "soft_arm/joint_command")
        self.wrench = peer.talk(WrenchStamped, "soft_arm/external_wrench")
        self.rosout = peer.listen(Log, "/rosout", 1000)
        self.reset()

    def reset(self):
        count = len(self.joints)
        assert self.peer.trigger("soft_arm/reset").success
        self.initial = wait_for(lambda: self.joints[count:], "the initial state")[-1]
        self.at = self.time(self.initial)

    def time(self, message):
        return message.header.stamp.sec * 1000 + message.header.stamp.nanosec // 1_000_000

    def steps(self, count):
        """States after each of ``count`` steps of 1 ms."""
        for _ in range(count):
            answer = self.peer.trigger("soft_arm/step")
            assert answer.success, answer.message
        last = self.at + count
        wait_for(lambda: self.joints and self.time(self.joints[-1]) >= last, f"state at {last} ms")
        states = [m for m in list(self.joints) if self.time(m) > self.at]
        self.at = last
        assert [self.time(m) for m in states] == list(range(last - count + 1, last + 1))
        return states

    def warned(self, text):
        # rosout has it for operators, the terminal for people
        wait_for(lambda: any(text in log.msg for log in list(self.rosout)), f"{text!r} on /rosout")
        assert text in self.program.text


@pytest.fixture
def bench(program, peer):
    return Bench(program, peer)


def settle():
    """Give a message on the loopback the time to arrive; a step takes up what has."""
    time.sleep(0.15)


def test_a_command_is_applied_from_the_next_step_on_and_moves_the_arm(bench):
    before = bench.steps(1)[-1]
    bench.command.publish(Float64MultiArray(data=[0.2, -0.1]))
    settle()
    states = bench.steps(5)
    assert list(before.effort) == [0.01, 0.0]
    assert all(list(m.effort) == [0.2, -0.1] for m in states)
    assert states[-1].position[0] > before.position[0]
    assert states[-1].position[1] < before.position[1]


def test_a_joint_command_may_name_a_subset_in_any_order(bench):
    bench.joint_command.publish(JointState(name=["yaw"], effort=[0.3]))
    settle()
    assert list(bench.steps(1)[-1].effort) == [0.01, 0.3]
    bench.joint_command.publish(JointState(name=["yaw", "pitch"], effort=[0.1, 0.2]))
    settle()
    assert list(bench.steps(1)[-1].effort) == [0.2, 0.1]


def test_efforts_beyond_the_limits_are_cut_and_said(bench):
    bench.command.publish(Float64MultiArray(data=[7.0, -0.1]))
    settle()
    assert list(bench.steps(1)[-1].effort) == [0.5, -0.1]
    bench.warned("pitch = 7 cut to 0.5")


@pytest.mark.parametrize(
    ("topic", "message", "complaint"),
    [
        ("command", Float64MultiArray(data=[0.2]), "~/command: 1 efforts for 2 actuators"),
        (
            "command",
            Float64MultiArray(data=[0.2, float("nan")]),
            "~/command: not finite: yaw = nan",
        ),
        (
            "joint_command",
            JointState(name=["pitch", "roll"], effort=[0.2, 0.2]),
            "~/joint_command: unknown actuator 'roll': expected some of pitch, yaw",
        ),
        (
            "joint_command",
            JointState(name=["pitch", "yaw"], effort=[0.2]),
            "~/joint_command: 1 efforts for 2 names",
        ),
        (
            "joint_command",
            JointState(name=["pitch", "pitch"], effort=[0.2, 0.1]),
            "~/joint_command: actuator named more than once: pitch",
        ),
        (
            "joint_command",
            JointState(name=["pitch"], effort=[float("-inf")]),
            "~/joint_command: not finite: pitch = -inf",
        ),
    ],
)
def test_a_bad_command_is_refused_with_what_is_wrong_and_moves_nothing(
    bench, topic, message, complaint
):
    getattr(bench, topic).publish(message)
    bench.warned(complaint)
    states = bench.steps(20)
    assert all(list(state.effort) == [0.01, 0.0] for state in states)
    # The arm hangs in equilibrium: without a new effort it stays there.
    assert list(states[-1].position) == pytest.approx(list(bench.initial.position), abs=1e-9)


def wrench(frame_id, **force):
    message = WrenchStamped()
    message.header.frame_id = frame_id
    for axis, value in force.items():
        setattr(message.wrench.force, axis, value)
    return message


@pytest.mark.parametrize("frame_id", ["", "world"])
def test_an_external_wrench_pushes_the_tip_in_the_frame_of_the_poses(bench, frame_id):
    free = bench.steps(20)[-1]
    bench.reset()
    bench.wrench.publish(wrench(frame_id, x=0.5))
    settle()
    pushed = bench.steps(20)[-1]
    # The arm hangs: local y is world y, so a push along world x turns it about y.
    assert abs(pushed.position[0] - free.position[0]) > 1e-3
    assert pushed.position[1] == pytest.approx(free.position[1], abs=1e-9)


def test_a_wrench_in_the_frame_tip_turns_with_the_tip(bench):
    # The tip's own x points down along the hanging arm and its z along the world's x.
    free = bench.steps(20)[-1]
    shapes = {}
    for axis in ("x", "z"):
        bench.reset()
        bench.wrench.publish(wrench("tip", **{axis: 0.5}))
        settle()
        shapes[axis] = bench.steps(20)[-1].position[0] - free.position[0]
    assert 5.0 * abs(shapes["x"]) < abs(shapes["z"]) > 1e-3


def test_a_wrench_in_another_frame_or_with_nan_is_refused(bench):
    free = bench.steps(3)[-1]
    bench.reset()
    bench.wrench.publish(wrench("camera", x=0.5))
    bench.warned("~/external_wrench: frame 'camera': expected 'world'")
    bench.wrench.publish(wrench("world", x=float("nan")))
    bench.warned("~/external_wrench: not finite: force.x = nan")
    assert list(bench.steps(3)[-1].position) == list(free.position)


def test_a_command_that_is_not_renewed_ramps_to_the_safe_effort(bench):
    bench.command.publish(Float64MultiArray(data=[0.2, -0.1]))
    settle()
    efforts = np.array([m.effort for m in bench.steps(160)])
    begin = np.array([0.2, -0.1])
    safe = np.array([0.01, 0.0])
    # Row k is the effort of the step from k to k+1 ms after the command.
    share = np.clip((np.arange(160) - 100.0) / 50.0, 0.0, 1.0)[:, None]
    assert efforts == pytest.approx(begin + share * (safe - begin), abs=1e-12)
    assert (efforts[-1] == safe).all()
    assert bench.events[-1].data != "command_timeout"
    assert any(m.data == "command_timeout: pitch, yaw" for m in list(bench.events))


def test_complaints_about_a_flood_of_bad_commands_are_few(bench):
    before = bench.program.text.count("~/command: 3 efforts")
    for _ in range(300):
        bench.command.publish(Float64MultiArray(data=[0.0, 0.0, 0.0]))
    bench.warned("~/command: 3 efforts for 2 actuators")
    settle()
    assert bench.program.text.count("~/command: 3 efforts") - before <= 2
