"""A reset of time: stamps and clock begin anew, the recording goes on, rerun and replay follow."""

from pathlib import Path

import numpy as np
from peer import Program, simulator, wait_for
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String

from soft_sim_ros.experiments.resimulation import Rerun
from soft_sim_ros.recording.reader import read_run

SCENE = Path(__file__).with_name("arm.yaml")


def stamp(message):
    return message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec


def times(ticks):
    return [tick.clock.sec * 1_000_000_000 + tick.clock.nanosec for tick in list(ticks)]


def falls(values):
    """Count how often they go back."""
    return int(np.count_nonzero(np.diff(values) < 0))


def test_a_reset_with_time_begins_anew_at_0_for_stamps_clock_recording_and_replay(tmp_path, peer):
    record = tmp_path / "run"
    program = simulator(tmp_path, scene=SCENE, record=record, reset_time="true")
    states = peer.listen(JointState, "/joint_states", 1000)
    ticks = peer.listen(Clock, "/clock", 1000)
    events = peer.listen(String, "soft_arm/events")
    command = peer.talk(Float64MultiArray, "soft_arm/command")
    command.publish(Float64MultiArray(data=[0.2, 0.2]))
    wait_for(lambda: states and stamp(states[-1]) > 200_000_000, "the arm to run")
    answer = peer.trigger("soft_arm/reset")
    assert answer.success and answer.message == "initial state at t = 0 s"
    wait_for(lambda: 100_000_000 < stamp(states[-1]) < 200_000_000, "the time after the reset")
    stamps = [stamp(message) for message in list(states)]
    assert falls(stamps) == 1
    assert 0 in stamps[-20:]
    assert falls(times(ticks)) == 1
    told = [message.data for message in list(events)]
    assert told[0] == "reset" and told[1].startswith("time_offset: -")
    assert program.end() == 0, program.text

    run = read_run(record)
    assert Rerun(run).compare().identical
    assert (np.diff(run.joint_states.time_ns) >= 0).all(), "the log's time goes on"
    ticks.clear(), states.clear()
    words = ("replay", str(record), "--rate", "5", "--wait-for", "/joint_states", "/clock")
    replay = Program(tmp_path, ("-m", "soft_sim_ros"), *words)
    assert replay.wait() == 0, replay.text
    wait_for(lambda: len(states) == run.counts["/joint_states"], "the replayed states")
    wanted = {stamp(message) for message in states}
    wait_for(lambda: wanted <= set(times(ticks)), "a tick for every stamp")
    assert falls(times(ticks)) == 1
