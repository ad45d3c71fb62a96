"""A recording is an ordinary rosbag2 directory, and says the same to independent readers."""

from __future__ import annotations

import json
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.interfaces import QosDurability, QosReliability
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording import messages
from soft_sim_ros.recording.cdr import WrenchStampedBuffer, encode_floats, encode_string
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.recording.topics import Qos, recorded_topics, topic
from soft_sim_ros.recording.writer import BagWriter


def test_rosbags_reads_every_message_byte_for_byte(record) -> None:
    directory, written = record()
    with Reader(directory) as reader:
        found = [(time, c.topic, bytes(data)) for c, time, data in reader.messages()]
        types = {c.topic: c.msgtype for c in reader.connections}
        assert reader.ros_distro == "jazzy"
    assert sorted(found) == sorted(written)
    assert types["/left/soft_arm/backbone"] == "geometry_msgs/msg/PoseArray"
    assert types["/left/soft_arm/events"] == "std_msgs/msg/String"  # also where nothing was said


def test_mcap_ros2_decodes_every_value_with_checksums_validated(record) -> None:
    directory, written = record()
    run = read_run(directory)
    seen: dict[str, list] = {}
    with (directory / "swing_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        for _, channel, message, decoded in reader.iter_decoded_messages():
            assert message.log_time == message.publish_time
            seen.setdefault(channel.topic, []).append((message.log_time, decoded))
    assert sum(map(len, seen.values())) == len(written)

    for (time_ns, theirs), ours in zip(
        seen["/left/soft_arm/backbone"], run.backbone.poses, strict=True
    ):
        stamp = theirs.header.stamp
        assert stamp.sec * 10**9 + stamp.nanosec == time_ns
        for pose, row in zip(theirs.poses, ours, strict=True):
            p, o = pose.position, pose.orientation
            assert [p.x, p.y, p.z, o.x, o.y, o.z, o.w] == row.tolist()
    assert [t for t, _ in seen["/left/soft_arm/backbone"]] == run.backbone.time_ns.tolist()
    for key, series in (("/left/joint_states", run.joint_states),):
        assert seen[key][0][1].name == list(series.name)
        for field in ("position", "velocity", "effort"):
            theirs = np.array([getattr(m, field) for _, m in seen[key]])
            np.testing.assert_array_equal(theirs, getattr(series, field))
    strains = [m for _, m in seen["/left/soft_arm/strain_state"]]
    np.testing.assert_array_equal([m.velocity for m in strains], run.strain_state.velocity)
    energies = [m for _, m in seen["/left/soft_arm/energy"]]
    np.testing.assert_array_equal([m.data for m in energies], run.energy.values)
    assert [one.label for one in energies[0].layout.dim] == list(run.energy.names)
    tips = [m.pose.position for _, m in seen["/left/soft_arm/tip_pose"]]
    np.testing.assert_array_equal([[p.x, p.y, p.z] for p in tips], run.tip_pose.positions)


def test_the_typed_messages_of_rosbags_agree(record) -> None:
    directory, _ = record(steps=3)
    store = get_typestore(Stores.ROS2_JAZZY)
    run = read_run(directory)
    with Reader(directory) as reader:
        chosen = [c for c in reader.connections if c.topic.endswith("/joint_states")]
        rows = [
            store.deserialize_cdr(data, c.msgtype).effort for c, _, data in reader.messages(chosen)
        ]
    np.testing.assert_array_equal(rows, run.joint_states.effort)


def test_metadata_and_indices_are_those_of_rosbag2(record) -> None:
    directory, written = record()
    content = yaml.safe_load((directory / "metadata.yaml").read_text())
    content = content["rosbag2_bagfile_information"]
    assert list(content) == [
        "version",
        "storage_identifier",
        "duration",
        "starting_time",
        "message_count",
        "topics_with_message_count",
        "compression_format",
        "compression_mode",
        "relative_file_paths",
        "files",
        "custom_data",
        "ros_distro",
    ]
    assert content["version"] == 9
    assert content["message_count"] == len(written)
    assert content["relative_file_paths"] == ["swing_0.mcap"]
    assert content["duration"]["nanoseconds"] == written[-1][0] - written[0][0]
    assert "&" not in (directory / "metadata.yaml").read_text()  # no aliases
    with (directory / "swing_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        records = [m.metadata for m in reader.iter_metadata() if m.name == "rosbag2"]
    assert len(records) == 2  # at open and at close
    assert yaml.safe_load(records[-1]["serialized_metadata"])["message_count"] == len(written)
    assert summary.statistics.message_count == len(written)
    assert all(chunk.message_index_offsets for chunk in summary.chunk_indexes)
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        assert channel.message_encoding == "cdr" and schema.encoding == "ros2msg"
        assert channel.metadata["topic_type_hash"] == messages.TYPE_HASHES[schema.name]
        assert schema.data.decode() == messages.schema(schema.name)


def test_qualities_of_service_come_back(tmp_path: Path) -> None:
    qos = Qos(depth=3, reliability="best_effort", durability="transient_local")
    with BagWriter(tmp_path / "q", [topic("backbone", "/a/arm", qos), topic("events", "/a/arm")]):
        pass
    with Reader(tmp_path / "q") as reader:
        theirs = {c.topic: c.ext.offered_qos_profiles[0] for c in reader.connections}
    best = theirs["/a/arm/backbone"]
    assert (best.depth, best.reliability, best.durability) == (
        3,
        QosReliability.BEST_EFFORT,
        QosDurability.TRANSIENT_LOCAL,
    )
    ours = {channel.topic: channel.qos for channel in read_run(tmp_path / "q").channels}
    assert ours == {"/a/arm/backbone": qos, "/a/arm/events": Qos(100)}


def test_the_scene_and_the_machine_are_inside(record) -> None:
    directory, _ = record(steps=2)
    run = read_run(directory)
    assert run.scene_text == "name: test arm\nlength: 0.6  # m\n"
    assert run.metadata == {"scene": "test arm"}
    facts = json.loads(run.attachments["machine.json"])
    assert facts["numpy"] == np.__version__ and facts["soft_sim_ros"]
    age = datetime.now().astimezone() - datetime.fromisoformat(facts["recorded"])
    assert timedelta(seconds=-1) < age < timedelta(minutes=5)
    with (directory / "swing_0.mcap").open("rb") as stream:
        names = {a.name: a.media_type for a in make_reader(stream).iter_attachments()}
    assert names == {"scene.yaml": "application/yaml", "machine.json": "application/json"}


def test_commands_events_and_wrenches_keep_their_order(tmp_path: Path) -> None:
    wrench = [0.1, 0.2, 0.3, 1.0, 2.0, 3.0]
    with BagWriter(tmp_path / "c", recorded_topics("/soft_arm")) as bag:
        bag.write("command", 0, encode_floats([0.1, -0.2]))
        bag.write("events", 5, encode_string("pause"))
        bag.write("external_wrench", 5, WrenchStampedBuffer("world").fill(3, wrench))
        bag.write("events", 5, encode_string("resume"))
        bag.write("command", 7, encode_floats([0.0]))
    run = read_run(tmp_path / "c")
    keys = [(entry.time_ns, entry.key) for entry in run.inputs]
    assert keys == [
        (0, "command"),
        (5, "events"),
        (5, "external_wrench"),
        (5, "events"),
        (7, "command"),
    ]
    assert [entry.message.data.tolist() for entry in run.commands] == [[0.1, -0.2], [0.0]]
    assert run.events == [(5, "pause"), (5, "resume")]
    ((time_ns, taken),) = run.wrenches
    assert time_ns == 5 and taken.stamp_ns == 3 and taken.frame_id == "world"
    np.testing.assert_array_equal(taken.wrench, wrench)
    assert [m.data for m in run.messages() if m.topic.endswith("events")] == [
        encode_string("pause"),
        encode_string("resume"),
    ]


def test_long_recordings_are_split_and_read_as_one(record) -> None:
    directory, written = record(steps=1500, split_bytes=400_000)
    files = sorted(path.name for path in directory.glob("*.mcap"))
    assert len(files) >= 2
    with Reader(directory) as reader:
        assert reader.message_count == len(written)
        assert len(list(reader.messages())) == len(written)
    run = read_run(directory)
    assert [(m.time_ns, m.topic, m.data) for m in run.messages()] == written
    assert run.scene_text is not None


def test_many_small_chunks_are_split_too_so_that_their_index_stays_small(
    record, monkeypatch
) -> None:
    monkeypatch.setattr("soft_sim_ros.recording.bag.SPLIT_COMMITS", 2)
    directory, written = record(steps=3000)
    assert len(list(directory.glob("*.mcap"))) >= 2
    with Reader(directory) as reader:
        assert reader.message_count == len(written)
    assert len(list(read_run(directory).messages())) == len(written)


def test_a_recording_is_never_overwritten(record, tmp_path: Path) -> None:
    directory, _ = record(steps=2)
    before = (directory / "swing_0.mcap").read_bytes()
    with pytest.raises(RecordingError, match=r"already holds a recording .swing_0.mcap."):
        BagWriter(directory, recorded_topics("/soft_arm"))
    assert (directory / "swing_0.mcap").read_bytes() == before


def test_a_directory_with_other_files_may_hold_a_recording(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "summary.json").write_text("{}")
    BagWriter(tmp_path / "run", recorded_topics("/soft_arm")).close()
    assert not read_run(tmp_path / "run").torn


def test_a_directory_that_cannot_be_made_is_an_error_at_once(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(RecordingError, match="cannot be written"):
        BagWriter(tmp_path / "file" / "run", recorded_topics("/soft_arm"))


def test_an_unknown_key_and_a_negative_time_are_refused_by_name(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "run", recorded_topics("/soft_arm")) as bag:
        with pytest.raises(RecordingError, match="has no topic 'spine'; it has backbone, "):
            bag.write("spine", 0, b"")
        with pytest.raises(ValueError, match="time_ns = -5 for events"):
            bag.write("events", -5, encode_string("x"))
