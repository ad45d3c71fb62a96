"""Simulated time never runs ahead of its factor, and keeps up with it, whatever comes in."""

import threading
import time
from pathlib import Path

import pytest
from geometry_msgs.msg import WrenchStamped
from peer import simulator, wait_for
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from soft_sim_ros.node import clock
from soft_sim_ros.node.clock import FASTEST, SLOWEST, Pacer

SCENE = Path(__file__).with_name("arm.yaml")
MS = 1_000_000
PERIOD = 4e-3  # s of simulated time between two instants of control
FACTORS = [1e-3, 0.02, 0.1, 0.5, 1.0, 3.0, 10.0]


class Hours:
    """A clock that only sleeping moves, and how long it has been slept."""

    def __init__(self, monkeypatch):
        self.ns = 0
        monkeypatch.setattr(clock.time, "sleep", self.sleep)

    def sleep(self, seconds):
        self.ns += max(1, round(seconds * 1e9))


def instants(pacer, count, disturb=lambda k: None):
    """Wait for instants 4 ms apart as the physics does, interrupted as often as it can be."""
    for k in range(count):
        while not pacer.wait(4 * k * MS, lambda: True):
            disturb(k)


@pytest.mark.parametrize("factor", [SLOWEST, *FACTORS, FASTEST])
def test_interrupted_waits_take_as_long_as_others(monkeypatch, factor):
    hours = Hours(monkeypatch)
    instants(Pacer(factor, lambda: hours.ns), 20)
    assert hours.ns == pytest.approx(19 * 4 * MS / factor, rel=1e-6)


@pytest.mark.parametrize("disturb", ["restart", "factor"])
def test_neither_pauses_nor_changes_of_the_factor_gain_time(monkeypatch, disturb):
    hours = Hours(monkeypatch)
    pacer = Pacer(0.02, lambda: hours.ns)

    def disturbance(k):
        if disturb == "restart":
            pacer.restart(4 * k * MS)
        else:
            pacer.factor = pacer.factor

    instants(pacer, 20, disturbance)
    assert hours.ns == pytest.approx(19 * 4 * MS / 0.02, rel=1e-3)


def test_an_early_instant_stays_early_when_the_factor_changes(monkeypatch):
    hours = Hours(monkeypatch)
    pacer = Pacer(0.02, lambda: hours.ns)
    pacer.wait(0, lambda: True)
    assert not pacer.wait(4 * MS, lambda: True)  # after one piece of 20 ms: 0.4 ms of 4 are over
    pacer.factor = 1.0
    before = hours.ns
    assert pacer.wait(4 * MS, lambda: False)
    assert hours.ns - before == pytest.approx(3.6 * MS, rel=1e-3)


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    # Every instant of control is heard: /clock ticks at the same rate.
    result = simulator(
        tmp_path_factory.mktemp("arm"), scene=SCENE, publish_rate=250, real_time_factor=0.02
    )
    yield result
    assert result.end() == 0, result.text


def test_no_storm_of_commands_and_calls_makes_time_run_ahead_or_stop(program, peer):
    ticks = []
    peer.node.create_subscription(
        Clock, "/clock", lambda m: ticks.append((time.monotonic(), m.clock)), 100
    )
    senders = [
        (peer.talk(Float64MultiArray, "soft_arm/command"), Float64MultiArray(data=[0.1, 0.1])),
        (
            peer.talk(JointState, "soft_arm/joint_command"),
            JointState(name=["yaw"], effort=[0.2]),
        ),
        (peer.talk(WrenchStamped, "soft_arm/external_wrench"), WrenchStamped()),
        (peer.talk(Float64MultiArray, "soft_arm/command"), Float64MultiArray(data=[1.0])),
    ]
    over = threading.Event()

    def storm():
        while not over.wait(0.004):
            for publisher, message in senders:
                publisher.publish(message)

    storming = threading.Thread(target=storm)
    storming.start()
    try:
        for factor in FACTORS:
            request = SetParameters.Request(
                parameters=[Parameter("real_time_factor", value=factor).to_parameter_msg()]
            )
            (result,) = peer.ask(SetParameters, "soft_arm/set_parameters", request).results
            assert result.successful, result.reason
            begin, first = time.monotonic(), len(ticks)
            while time.monotonic() < begin + 1.5:
                # calls while it runs: neither may begin a step early
                assert peer.pause(False).success
                if factor < 0.5:
                    assert peer.pause(True).success
                    assert peer.pause(False).success
                time.sleep(0.05)
            heard = ticks[first:]
            if len(heard) < 2:
                assert factor <= 0.02
                continue
            (t0, c0), (t1, c1) = heard[0], heard[-1]
            simulated = (c1.sec - c0.sec) + 1e-9 * (c1.nanosec - c0.nanosec)
            # one instant may lie on either edge, and the first tick may have been heard late
            assert simulated <= factor * (t1 - t0 + 0.1) + PERIOD, factor
            if factor <= 1.0:
                assert simulated >= 0.5 * factor * (t1 - t0) - 2 * PERIOD, factor
    finally:
        over.set()
        storming.join()


@pytest.mark.parametrize("factor", [1e-310, 1e-4, -1.0, 1e4, float("inf"), float("nan")])
def test_a_factor_that_cannot_be_kept_is_refused_while_running(program, peer, factor):
    request = SetParameters.Request(
        parameters=[Parameter("real_time_factor", value=factor).to_parameter_msg()]
    )
    (result,) = peer.ask(SetParameters, "soft_arm/set_parameters", request).results
    assert not result.successful
    assert "real_time_factor" in result.reason and result.reason.isprintable()
    assert program.process.poll() is None


def test_a_pause_is_answered_long_before_a_slow_instant_is_due(program, peer):
    request = SetParameters.Request(
        parameters=[Parameter("real_time_factor", value=SLOWEST).to_parameter_msg()]
    )
    peer.ask(SetParameters, "soft_arm/set_parameters", request)
    begin = time.monotonic()
    assert peer.pause(True).success
    assert time.monotonic() - begin < 2.0, "an instant is 4 s long"
    wait_for(lambda: peer.pause(False).success, "the arm to go on")
