"""An arm with use_sim_time goes by the clock of another program, and says where they disagree."""

import itertools
import time
from pathlib import Path

import pytest
from geometry_msgs.msg import PoseArray
from peer import simulator, wait_for
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String

from soft_sim_ros.experiments.resimulation import Rerun
from soft_sim_ros.recording.reader import read_run

SCENE = Path(__file__).with_name("arm.yaml")
MS = 1_000_000
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


def nanoseconds(stamp):
    return stamp.sec * 1000 * MS + stamp.nanosec


class Master:
    """Owns time: publishes ticks and hears the states of one arm."""

    def __init__(self, peer, arm="", qos=10):
        self.publisher = peer.talk(Clock, "/clock", qos)
        self.states, self.arrivals = [], []
        peer.node.create_subscription(JointState, f"{arm}/joint_states", self._hear, 1000)

    def _hear(self, message):
        self.arrivals.append(time.monotonic())
        self.states.append(message)

    @property
    def stamps(self):
        return [nanoseconds(message.header.stamp) for message in list(self.states)]

    def tick(self, time_ns):
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(time_ns, 1000 * MS)
        self.publisher.publish(message)

    def tick_and_wait(self, time_ns):
        """Tick until the arm answers: DDS may lose the first one, and the same again is none."""
        self._until(time_ns, lambda: time_ns in self.stamps)

    def join(self, time_ns, program):
        """Tick until the arm has heard it."""
        self._until(time_ns, lambda: "joined /clock" in program.text)

    def _until(self, time_ns, condition, patience=10.0):
        end = time.monotonic() + patience
        while not condition():
            assert time.monotonic() < end, f"no answer to {time_ns} ns in {self.stamps[-3:]}"
            self.tick(time_ns)
            again = time.monotonic() + 0.3
            while time.monotonic() < again and not condition():
                time.sleep(0.002)


def follower(folder, **parameters):
    return simulator(folder, scene=SCENE, use_sim_time="true", **parameters)


def test_in_lock_step_every_tick_is_answered_and_nothing_moves_without_one(tmp_path, peer):
    record = tmp_path / "run"
    program = follower(tmp_path, record=record)
    assert "following /clock in lock_step" in program.text
    master = Master(peer)
    command = peer.talk(Float64MultiArray, "soft_arm/command")
    time.sleep(0.3)
    assert master.states == [], "nobody has told the time yet"
    begin = 5_000 * MS
    for k in range(60):
        master.tick_and_wait(begin + 10 * MS * k)
        # what is sent between two ticks acts from the first of them on
        command.publish(Float64MultiArray(data=[0.002 * k, -0.001 * k]))
        time.sleep(0.003)
    time.sleep(0.3)
    assert master.stamps == [begin + 10 * MS * k for k in range(60)]
    efforts = [list(message.effort) for message in master.states]
    assert efforts[40][0] == pytest.approx(0.002 * 39) and efforts[40][1] == pytest.approx(-0.039)
    assert peer.node.count_publishers("/clock") == 1, "who follows the clock does not publish it"
    assert program.end() == 0, program.text
    run = read_run(record)
    assert run.metadata["time"] == "lock_step"
    assert run.end == pytest.approx(0.59), "its own time is simulation time"
    comparison = Rerun(run).compare()
    assert comparison.identical and comparison.messages == 60 * 5


def test_a_clock_that_jumps_is_followed_said_and_computed_again_alike(tmp_path, peer):
    record = tmp_path / "run"
    program = follower(tmp_path, record=record)
    master = Master(peer)
    events = peer.listen(String, "soft_arm/events")
    command = peer.talk(Float64MultiArray, "soft_arm/command")
    starts = (7_003 * MS, 20 * MS, 900_000 * MS)  # where it joins, jumps back, jumps ahead
    master.join(starts[0], program)
    for start in starts:
        command.publish(Float64MultiArray(data=[0.1, 0.1]))
        for k in range(20):
            master.tick(start + 10 * MS * k)
            time.sleep(0.01)
    wait_for(lambda: 900_190 * MS in master.stamps, f"the last state in {master.stamps}")
    back, ahead = (master.stamps.index(t) for t in (20 * MS, 900_000 * MS))
    parts = (master.stamps[:back], master.stamps[back:ahead], master.stamps[ahead:])
    for start, stamps in zip(starts, parts, strict=True):
        assert all(stamp % (10 * MS) == 0 for stamp in stamps), "whole publish periods"
        assert start <= stamps[0] < start + 20 * MS
        assert stamps[-1] > start + 170 * MS
        assert {b - a for a, b in itertools.pairwise(stamps)} == {10 * MS}
    assert "/clock jumped back from 7.193 to 0.02 s" in program.text
    assert "/clock jumped forward from 0.21 to 900 s" in program.text
    assert sum(m.data.startswith("time_offset: ") for m in list(events)) >= 2
    assert program.end() == 0, program.text
    run = read_run(record)
    assert Rerun(run).compare().identical
    times = run.joint_states.time
    assert max(b - a for a, b in itertools.pairwise(times)) < 0.0101, "the motion has no gap"


def test_a_clock_that_stands_still_holds_the_arm_and_both_are_said(tmp_path, peer):
    program = follower(tmp_path)
    program.wait_for_text("waits for /clock, which nobody publishes")
    master = Master(peer)
    for k in range(5):
        master.tick_and_wait(1_000 * MS + 10 * MS * k)
    program.wait_for_text("/clock stands still at 1.04 s, and so does the arm")
    late = peer.listen(JointState, "soft_arm/strain_state")
    wait_for(lambda: late, "the state for who came late")
    assert nanoseconds(late[0].header.stamp) == 1_040 * MS
    master.tick_and_wait(1_050 * MS)
    program.wait_for_text("/clock goes on at 1.05 s")
    assert program.text.count("stands still") == 1
    refused = peer.trigger("soft_arm/step")
    assert not refused.success and "follows /clock" in refused.message
    assert program.end() == 0, program.text


def test_after_a_pause_the_stamps_leap_over_what_has_passed(tmp_path, peer):
    program = follower(tmp_path)
    master = Master(peer)
    master.tick_and_wait(0)
    master.tick_and_wait(10 * MS)
    assert peer.pause(True).success
    for k in range(2, 200):
        master.tick(10 * MS * k)
    time.sleep(0.1)
    assert max(master.stamps) == 10 * MS
    assert peer.pause(False).success
    master.tick_and_wait(2_000 * MS)
    assert min(t for t in master.stamps if t > 10 * MS) >= 1_990 * MS
    assert program.end() == 0, program.text


def test_resampled_a_slow_clock_moves_the_arm_evenly_and_never_ahead_of_it(tmp_path, peer):
    program = follower(tmp_path, follow_clock="resampled")
    # as a player of bags publishes it
    master = Master(peer, qos=BEST_EFFORT)
    master.join(0, program)
    for k in range(12):
        master.tick(200 * MS * k)
        now = time.monotonic()
        assert all(stamp <= 200 * MS * k for stamp in master.stamps)
        time.sleep(max(0.0, 0.2 - (time.monotonic() - now)))
    late = [a for a, t in zip(master.arrivals, master.stamps, strict=False) if t >= 600 * MS]
    gaps = sorted(b - a for a, b in itertools.pairwise(late))
    assert len(gaps) > 100
    # 20 states between two ticks, one every 10 ms: all at once would be gaps of nothing
    assert gaps[len(gaps) // 2] == pytest.approx(0.01, abs=0.003)
    assert gaps[len(gaps) // 5] > 0.004
    assert program.end() == 0, program.text


def test_a_best_effort_clock_is_heard_in_lock_step_too(tmp_path, peer):
    program = follower(tmp_path)
    publisher = peer.node.create_publisher(Clock, "/clock", BEST_EFFORT)
    program.wait_for_text("published as best effort")
    peer.node.destroy_publisher(publisher)
    master = Master(peer, qos=BEST_EFFORT)
    master.tick_and_wait(0)
    master.tick_and_wait(10 * MS)
    assert program.end() == 0, program.text


def test_two_arms_on_one_clock_have_the_same_stamps_whenever_they_joined(tmp_path, peer):
    left = simulator(tmp_path, "-r", "__ns:=/left", scene=SCENE, use_sim_time="true")
    master = Master(peer, "/left")
    for k in range(10):
        master.tick_and_wait(10 * MS * k)
    right = simulator(tmp_path, "-r", "__ns:=/right", scene=SCENE, use_sim_time="true")
    other = peer.listen(JointState, "/right/joint_states")
    master.join(90 * MS, right)
    for k in range(100, 200):
        master.tick(1 * MS * k)
        time.sleep(0.002)
    wait_for(lambda: len(other) >= 9, "states of the other arm")
    common = {nanoseconds(m.header.stamp) for m in other}
    assert common <= set(master.stamps)
    assert max(common) == max(master.stamps) == 190 * MS
    assert left.end() == 0 and right.end() == 0, left.text + right.text


def test_an_arm_of_its_own_time_says_at_once_how_far_it_is_from_anothers_clock(tmp_path, peer):
    program = simulator(tmp_path, scene=SCENE, publish_clock="false")
    states = peer.listen(PoseArray, "soft_arm/backbone")
    wait_for(lambda: states, "the arm")
    publisher = peer.node.create_publisher(Clock, "/clock", 1)
    message, begin = Clock(), time.monotonic()
    message.clock.sec = 200
    while "s behind another node's /clock" not in program.text:
        publisher.publish(message)
        time.sleep(0.02)
        assert time.monotonic() - begin < 5.0, program.text
    (line,) = [line for line in program.text.splitlines() if "s behind another" in line]
    apart = float(line.partition("stamps are ")[2].split()[0])
    assert 190.0 < apart < 200.0 and "use_sim_time:=true follows it" in line
    peer.node.destroy_publisher(publisher)
    assert program.end() == 0, program.text
