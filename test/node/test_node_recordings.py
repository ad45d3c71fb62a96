"""What a node has recorded can be replayed byte for byte and computed again bit for bit."""

import json
import signal
import time
from collections import Counter, defaultdict

import numpy as np
import pytest
from peer import Peer, Program, wait_for
from rclpy.serialization import deserialize_message
from recorded_run import record_eventful_run
from rosgraph_msgs.msg import Clock

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.node.publishers import message_class
from soft_sim_ros.recording.cdr import encode_string
from soft_sim_ros.recording.orders import read_order
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.recording.topics import ALL, INPUTS, OUTPUTS, resolve
from soft_sim_ros.scene import parse_scene

REPLAY = (
    "-c",
    "import sys; from soft_sim_ros.node.replay import main; sys.exit(main(sys.argv[1:]))",
)


@pytest.fixture(scope="module")
def record(tmp_path_factory, context):
    driver = Peer(context)
    try:
        return record_eventful_run(tmp_path_factory.mktemp("recorded"), driver)
    finally:
        driver.close()


@pytest.fixture(scope="module")
def run(record):
    return read_run(record)


def test_the_recording_holds_what_happened(run):
    texts = [text for _, text in run.events]
    assert [t for t in texts if not t.startswith("command_timeout")] == [
        "pause",
        "step",
        "step",
        "resume",
        "reset",
    ]
    assert any(t.startswith("command_timeout") for t in texts)
    assert [key for _, key, _, _ in run.inputs].count("external_wrench") == 2
    assert not any(
        np.isnan(entry.message.data).any() for entry in run.inputs if entry.key == "command"
    )
    assert run.counts["/soft_arm/backbone"] == run.counts["/joint_states"]
    assert run.metadata["command_timeout"] == "0.2"
    assert run.metadata["command_ramp"] == "0.1"
    assert run.metadata["frame_id"] == "plate"
    assert run.metadata["node"] == "/soft_arm"


def test_the_summary_counts_what_the_recording_holds(record, run):
    summary = json.loads((record / "summary.json").read_text())
    assert summary["recording"]["recorded"] == sum(run.counts.values())
    assert summary["commands"]["refused"] == 1
    assert summary["commands"]["clamped"] == 1
    taken = sum(run.counts[resolve(name, "/soft_arm")] for name, _, _ in INPUTS.values())
    assert summary["commands"]["accepted"] == taken
    assert summary["messages_sent"]["joint_states"] <= run.counts["/joint_states"]


def test_computing_the_recorded_run_again_gives_the_same_bytes(run):
    simulation = Simulation(parse_scene(run.scene_text))
    settings = run.metadata
    frame_id = settings["frame_id"]
    inputs = Inputs(simulation, float(settings["command_timeout"]), float(settings["command_ramp"]))
    telemetry = Telemetry(simulation, int(settings["poses"]), frame_id, settings["node"])
    keys = {resolve(name, settings["node"]): key for key, (name, _, _) in ALL.items()}
    reset = encode_string("reset")
    compared = defaultdict(int)
    for message in run.messages():
        key = keys[message.topic]
        if key in INPUTS or message.data == reset or key in OUTPUTS:
            inputs.advance((message.time_ns - simulation.time_ns) // simulation.step_ns)
            assert simulation.time_ns == message.time_ns
        if key in INPUTS:
            inputs.take(read_order(inputs, key, message.data, frame_id))
        elif message.data == reset:
            inputs.reset()
        elif key in OUTPUTS:
            assert getattr(telemetry, key)() == message.data, (key, message.time_ns)
            compared[key] += 1
    assert set(compared) == set(OUTPUTS)
    assert min(compared.values()) > 100


def replay(folder, record, *options):
    return Program(folder, REPLAY, str(record), *options)


def heard(run, *keys):
    """Words for a replay that begins when the test hears these topics; every one if not told."""
    return ("--wait-for", *(keys or run.counts))


class Listener:
    """Hears every topic of a recording as bytes, and the clock, in order of arrival."""

    def __init__(self, peer, run):
        self.peer, self.heard, self.ticks, self.arrivals = peer, defaultdict(list), [], []
        for channel in run.channels:
            peer.node.create_subscription(
                message_class(channel.type),
                channel.topic,
                self.heard[channel.topic].append,
                1000,
                raw=True,
            )
        peer.node.create_subscription(Clock, "/clock", self._tick, 1000)

    def _tick(self, message):
        self.arrivals.append(time.monotonic())
        self.ticks.append(message.clock.sec * 1_000_000_000 + message.clock.nanosec)


def recorded_by_topic(run):
    messages = defaultdict(list)
    for message in run.messages():
        messages[message.topic].append(message.data)
    return messages


def on_the_wire(data):
    """DDS fills messages up to whole words of four bytes."""
    return data + bytes(-len(data) % 4)


def test_a_replay_gives_the_same_bytes_in_the_same_order_and_time(tmp_path, record, run, peer):
    listener = Listener(peer, run)
    commands = {resolve(name, "/soft_arm") for name, _, _ in INPUTS.values()}
    waited = heard(run, *(set(run.counts) - commands), "/clock")
    program = replay(tmp_path, record, "--rate", "2", *waited)
    assert program.wait() == 0, program.text
    expected = recorded_by_topic(run)
    for topic, messages in expected.items():
        if topic in commands:
            assert listener.heard[topic] == [], f"{topic} would command a running arm"
        else:
            wait_for(lambda t=topic, m=messages: len(listener.heard[t]) == len(m), topic)
            assert listener.heard[topic] == [on_the_wire(data) for data in messages]
    assert listener.ticks == sorted({m.time_ns for m in run.messages() if m.topic not in commands})
    elapsed = listener.arrivals[-1] - listener.arrivals[0]
    assert elapsed == pytest.approx(run.duration / 2.0, rel=0.1)
    sent = sum(len(messages) for topic, messages in expected.items() if topic not in commands)
    assert f"done: {sent} messages, 1 passes" in program.text


def test_a_replay_offers_the_recorded_types_and_qualities_of_service(tmp_path, record, run, peer):
    program = replay(tmp_path, record, "--with-commands", "--loop")
    for channel in run.channels:
        wait_for(lambda c=channel: peer.node.count_publishers(c.topic), channel.topic)
        (info,) = peer.node.get_publishers_info_by_topic(channel.topic)
        assert info.topic_type == channel.type
        assert info.qos_profile.reliability.name.lower() == channel.qos.reliability
        assert info.qos_profile.durability.name.lower() == channel.qos.durability
    program.send(signal.SIGINT)
    assert program.wait() == 0, program.text
    assert "Traceback" not in program.text
    assert "stopped: " in program.text


def test_with_commands_a_replay_sends_those_too_as_fast_as_asked(tmp_path, record, run, peer):
    listener = Listener(peer, run)
    program = replay(tmp_path, record, "--with-commands", "--rate", "0", *heard(run))
    assert program.wait() == 0, program.text
    topic = "/soft_arm/external_wrench"
    expected = recorded_by_topic(run)[topic]
    wait_for(lambda: len(listener.heard[topic]) == len(expected), topic)
    assert listener.heard[topic] == expected
    wrench = deserialize_message(expected[0], message_class("geometry_msgs/msg/WrenchStamped"))
    assert wrench.header.frame_id == "plate"
    assert f"done: {sum(run.counts.values())} messages" in program.text


@pytest.mark.parametrize(
    ("options", "topics", "clock"),
    [
        (["--no-clock"], {"backbone", "strain_state", "energy", "tip_pose", "events"}, False),
        (["--topics", "~/backbone", "/joint_states", "~/command"], {"backbone", "command"}, True),
        (["--commands-only"], {"command", "joint_command", "external_wrench"}, False),
    ],
)
def test_a_replay_sends_what_is_asked_for_and_nothing_else(
    tmp_path, record, run, peer, options, topics, clock
):
    listener = Listener(peer, run)
    names = {f"/soft_arm/{key}" for key in topics}
    if "--commands-only" not in options:
        names.add("/joint_states")
    waited = heard(run, *names, *(["/clock"] if clock else []))
    program = replay(tmp_path, record, "--rate", "0", *options, *waited)
    assert program.wait() == 0, program.text
    expected = recorded_by_topic(run)
    for topic in names:
        wait_for(lambda t=topic: len(listener.heard[t]) == len(expected[t]), topic)
    assert {topic for topic, heard in listener.heard.items() if heard} == names
    assert bool(listener.ticks) == clock


def test_a_topic_that_is_not_there_is_refused_with_the_nearest(tmp_path, record):
    program = replay(tmp_path, record, "--topics", "~/backbon")
    assert program.wait() == 2
    assert "has no topic '~/backbon'; the nearest is /soft_arm/backbone" in program.text


def test_a_replay_in_a_namespace_and_under_other_names(tmp_path, record, run, peer):
    heard_on = {
        topic: peer.node.create_subscription(kind, topic, lambda m, t=topic: counts.update([t]), 99)
        for topic, kind in (
            ("/left/soft_arm/tip_pose", message_class("geometry_msgs/msg/PoseStamped")),
            ("/elsewhere", message_class("sensor_msgs/msg/JointState")),
        )
    }
    counts = Counter()
    rules = ("--ros-args", "-r", "__ns:=/left", "-r", "/left/joint_states:=/elsewhere")
    waited = heard(run, "/joint_states", "~/tip_pose")
    program = replay(tmp_path, record, "--rate", "10", *waited, *rules)
    assert program.wait() == 0, program.text
    wait_for(lambda: counts["/elsewhere"] == run.counts["/joint_states"], "joint states")
    assert counts["/left/soft_arm/tip_pose"] == run.counts["/soft_arm/tip_pose"]
    assert set(counts) == set(heard_on)
    assert "/joint_states, as /elsewhere" in program.text


def test_a_looping_replay_begins_again_until_it_is_stopped(tmp_path, record, run, peer):
    listener = Listener(peer, run)
    program = replay(tmp_path, record, "--rate", "10", "--loop")
    backwards = lambda: np.count_nonzero(np.diff(listener.ticks) < 0)  # noqa: E731
    wait_for(lambda: backwards() >= 2, "two new beginnings")
    program.send(signal.SIGTERM)
    assert program.wait() == 0, program.text


def test_a_replay_waits_for_subscribers_it_is_told_of_and_says_who_has_none(
    tmp_path, record, run, peer
):
    words = ("--rate", "0", "--delay", "0", "--wait-for", "~/tip_pose")
    program = replay(tmp_path, record, *words, "--topics", "~/tip_pose", "~/energy")
    program.wait_for_text("waiting for a subscriber of /soft_arm/tip_pose")
    poses = peer.listen(message_class("geometry_msgs/msg/PoseStamped"), "/soft_arm/tip_pose", 1000)
    assert program.wait() == 0, program.text
    wait_for(lambda: len(poses) == run.counts["/soft_arm/tip_pose"], "all poses")
    assert "/soft_arm/energy (no subscriber)" in program.text


def test_a_replay_does_not_wait_for_what_it_does_not_send(tmp_path, record):
    program = replay(tmp_path, record, "--no-clock", "--wait-for", "/clock")
    assert program.wait() == 2
    assert "would wait for ever for /clock: it is not replayed" in program.text


def test_what_is_no_recording_is_said_in_words(tmp_path):
    program = replay(tmp_path, tmp_path / "nothing")
    assert program.wait() == 2
    assert "nothing: does not exist" in program.text
    assert "Traceback" not in program.text
