"""Orders, limits, timeouts: the efforts of every step as a function of time and orders alone."""

from pathlib import Path

import numpy as np
import pytest

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs, wrench_frame
from soft_sim_ros.errors import CommandError
from soft_sim_ros.node.commands import Throttle
from soft_sim_ros.scene import load_scene

SCENE = load_scene(Path(__file__).with_name("arm.yaml"))
SAFE = (0.01, 0.0)


@pytest.fixture
def arm():
    return Simulation(SCENE)


def efforts_by_step(inputs, count):
    simulation = inputs.simulation
    result = []
    for _ in range(count):
        inputs.advance(1)
        result.append(simulation.ports()[2])
    return np.array(result)


def test_without_orders_the_efforts_are_the_safe_ones(arm):
    inputs = Inputs(arm, 0.1, 0.1)
    assert (efforts_by_step(inputs, 3) == SAFE).all()
    assert inputs.take_events() == []


def test_a_timeout_of_zero_holds_the_last_order_for_ever(arm):
    inputs = Inputs(arm, 0.0, 0.1)
    inputs.command([0.2, 0.1])
    inputs.advance(3000)
    assert tuple(arm.ports()[2]) == (0.2, 0.1)


def test_each_actuator_times_out_by_itself(arm):
    inputs = Inputs(arm, 0.010, 0.0)
    inputs.command([0.2, 0.1])
    inputs.advance(6)
    inputs.joint_command(["yaw"], [0.3])
    efforts = efforts_by_step(inputs, 14)
    # pitch was ordered at 0 ms and holds up to 10 ms; yaw at 6 ms, up to 16 ms.
    assert (efforts[:, 0] == [0.2] * 5 + [0.01] * 9).all()
    assert (efforts[:, 1] == [0.3] * 11 + [0.0] * 3).all()
    assert inputs.take_events() == [
        (11_000_000, "command_timeout: pitch"),
        (17_000_000, "command_timeout: yaw"),
    ]


def test_an_order_during_the_ramp_ends_it_and_may_time_out_again(arm):
    inputs = Inputs(arm, 0.005, 0.010)
    inputs.joint_command(["yaw"], [0.4])
    inputs.advance(10)
    assert 0.0 < arm.ports()[2][1] < 0.4
    inputs.joint_command(["yaw"], [0.4])
    assert (efforts_by_step(inputs, 5)[:, 1] == 0.4).all()
    inputs.advance(20)
    assert [text for _, text in inputs.take_events()] == 2 * ["command_timeout: yaw"]


def test_reset_forgets_the_orders(arm):
    inputs = Inputs(arm, 0.1, 0.1)
    start = arm.q.copy()
    inputs.command([0.2, 0.1])
    inputs.wrench([0.0, 0.0, 0.0, 1.0, 0.0, 0.0], "tip")
    inputs.advance(5)
    inputs.reset()
    assert (arm.q == start).all()
    assert tuple(arm.ports()[2]) == SAFE
    inputs.advance(200)
    assert inputs.take_events() == []
    assert arm.q == pytest.approx(start, abs=1e-6), "no wrench is left"


def test_how_steps_are_grouped_does_not_change_a_bit():
    def run(groups):
        simulation = Simulation(SCENE)
        inputs = Inputs(simulation, 0.02, 0.013)
        for order in range(4):
            inputs.command([0.1 * order, -0.1])
            inputs.wrench([0.0, 0.0, 0.0, 0.0, 0.2, 0.0], ("world", "tip")[order % 2])
            for steps in groups:
                inputs.advance(steps)
        return simulation.q.tobytes(), simulation.v.tobytes(), inputs.take_events()

    assert run([60]) == run([1] * 60) == run([7, 20, 3, 30])


def test_limits_cut_and_say_so(arm):
    order = Inputs(arm, 0.0, 0.0).command([0.9, -0.7])
    assert order.values.tolist() == [0.5, -0.5]
    assert order.clamped == ("pitch = 0.9 cut to 0.5", "yaw = -0.7 cut to -0.5")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda i: i.command([0.1]), "1 efforts for 2 actuators (pitch, yaw)"),
        (lambda i: i.command([np.nan, np.inf]), "not finite: pitch = nan, yaw = inf"),
        (lambda i: i.joint_command(["role"], [0.1]), "unknown actuator 'role'"),
        (lambda i: i.joint_command([], []), "no names"),
        (lambda i: i.joint_command(["yaw", "yaw"], [0.1, 0.2]), "more than once: yaw"),
        (lambda i: i.joint_command(["yaw"], []), "0 efforts for 1 names (yaw)"),
        (lambda i: i.wrench([0.0] * 5), "shape (5,)"),
        (lambda i: i.wrench([0.0, np.nan, 0, 0, 0, 0]), "torque.y = nan"),
        (lambda i: i.wrench([0.0] * 6, "base"), "wrench frame 'base'"),
    ],
)
def test_a_bad_order_is_refused_whole(arm, call, message):
    inputs = Inputs(arm, 0.0, 0.0)
    with pytest.raises(CommandError) as caught:
        call(inputs)
    assert message in str(caught.value)
    assert inputs.last_order_ns is None
    assert (efforts_by_step(inputs, 2) == SAFE).all()


@pytest.mark.parametrize(
    ("name", "frame"), [("", "world"), ("plate", "world"), ("tip", "tip"), ("elbow", None)]
)
def test_a_wrench_is_dead_in_the_frame_of_the_poses_and_follows_in_the_frame_tip(name, frame):
    if frame:
        assert wrench_frame(name, "plate") == frame
    else:
        with pytest.raises(CommandError, match="'elbow': expected 'plate'"):
            wrench_frame(name, "plate")


@pytest.mark.parametrize(
    ("timeout", "ramp"), [(-1.0, 0.0), (0.0, float("nan")), (float("inf"), 0.0)]
)
def test_times_must_be_finite_and_not_negative(arm, timeout, ramp):
    with pytest.raises(ValueError, match="expected a finite number, zero or more"):
        Inputs(arm, timeout, ramp)


def test_complaints_that_differ_in_numbers_only_are_counted_instead_of_said():
    said, now = [], [0.0]
    complain = Throttle(said.append, 1.0, lambda: now[0])
    for k in range(10):
        complain(f"yaw = {k}")
    complain("pitch = 3")
    now[0] = 1.5
    complain("yaw = 11")
    assert said == ["yaw = 0", "pitch = 3", "yaw = 11 (9 more like it)"]
