"""Reading a recording: arrays for what is there, clear words for what is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from soft_sim_ros import read_run as public_read_run
from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.bag import Bag, channel
from soft_sim_ros.recording.cdr import JointStateBuffer, PoseArrayBuffer, encode_string
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.recording.topics import STRING, Topic, recorded_topics, topic
from soft_sim_ros.recording.writer import BagWriter


def test_arrays_have_one_row_per_message(record) -> None:
    directory, _ = record(steps=50)
    run = public_read_run(directory)
    assert run.backbone.poses.shape == (50, 21, 7) and run.backbone.frame_id == "world"
    assert run.tip_pose.poses.shape == (50, 7)
    assert run.joint_states.name == tuple(f"section{i}/bend_y" for i in range(3))
    assert run.joint_states.effort.shape == (50, 3)
    assert run.strain_state.position.shape == (50, 5) and run.strain_state.effort.shape == (50, 0)
    np.testing.assert_array_equal(run.backbone.time, np.arange(50) / 100)
    np.testing.assert_array_equal(run.backbone.poses[:, -1], run.tip_pose.poses)
    np.testing.assert_array_equal(
        run.energy["kinetic"], run.energy.values[:, run.energy.names.index("kinetic")]
    )
    assert (run.start, run.end, run.duration) == (0.0, 0.49, 0.49)
    assert run.counts["/left/soft_arm/backbone"] == 50
    assert "250 messages" in repr(run)


def test_one_file_may_be_read_without_its_directory(record) -> None:
    directory, _ = record(steps=3)
    assert len(read_run(directory / "swing_0.mcap").backbone) == 3


def test_an_unknown_entry_of_the_ledger_names_the_known_ones(record) -> None:
    directory, _ = record(steps=2)
    with pytest.raises(KeyError, match="'heat' is not in the ledger; it has kinetic, elastic"):
        read_run(directory).energy["heat"]


def test_topics_that_were_not_recorded_are_empty(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "few", [topic("joint_states", "/soft_arm")]) as bag:
        bag.write("joint_states", 0, JointStateBuffer(["a"]).fill(0, [1], [2], [3]))
    run = read_run(tmp_path / "few")
    assert run.joint_states.position.tolist() == [[1.0]]
    assert len(run.backbone) == len(run.energy) == len(run.tip_pose) == 0
    assert run.commands == run.events == run.wrenches == []


@pytest.mark.parametrize("inside", [None, [], ["notes.txt", "video.mp4"]])
def test_what_is_not_a_recording_is_refused_with_what_was_found(tmp_path: Path, inside) -> None:
    directory = tmp_path / "thing"
    if inside is not None:
        directory.mkdir()
        for name in inside:
            (directory / name).write_text("x")
    expected = {
        None: "does not exist",
        0: "expected .*mcap and metadata.yaml, found nothing",
        2: "expected .*mcap and metadata.yaml, found notes.txt, video.mp4",
    }[None if inside is None else len(inside)]
    with pytest.raises(RecordingError, match=expected):
        read_run(directory)


def test_a_file_that_is_not_mcap_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.mcap").write_bytes(b"SQLite format 3\0" * 10)
    with pytest.raises(RecordingError, match=r"x.mcap: is not an MCAP file"):
        read_run(tmp_path / "x.mcap")


def foreign(path: Path, plugin: StoragePlugin) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection("/chatter", STRING, typestore=store)
        writer.write(connection, 5, encode_string("hello"))


def test_a_foreign_bag_is_refused_by_naming_its_topics(tmp_path: Path) -> None:
    foreign(tmp_path / "chat", StoragePlugin.MCAP)
    with pytest.raises(RecordingError, match=r"it holds /chatter \(std_msgs/msg/String\)") as error:
        read_run(tmp_path / "chat")
    assert "~/backbone" in str(error.value)


def test_a_bag_in_another_storage_is_refused(tmp_path: Path) -> None:
    foreign(tmp_path / "chat", StoragePlugin.SQLITE3)
    with pytest.raises(RecordingError, match=r"expected \*\.mcap .* found chat.db3"):
        read_run(tmp_path / "chat")


def test_a_missing_part_is_named(record) -> None:
    directory, _ = record(steps=1500, split_bytes=400_000)
    (directory / "swing_0.mcap").unlink()
    with pytest.raises(RecordingError, match=r"metadata.yaml names swing_0.mcap, which is not"):
        read_run(directory)


def test_several_arms_in_one_bag_are_told_apart_by_node(tmp_path: Path) -> None:
    topics = [*recorded_topics("/left/arm"), *recorded_topics("/right/arm")]
    bag = Bag(tmp_path / "two", [channel(t) for t in topics], metadata={}, attachments={})
    buffer = PoseArrayBuffer("world", 2)
    names = [t.name for t in topics]
    bag.add(names.index("/left/arm/backbone"), 0, buffer.fill(0, np.zeros((2, 7))))
    bag.add(names.index("/right/arm/backbone"), 0, buffer.fill(0, np.ones((2, 7))))
    bag.close()
    with pytest.raises(RecordingError, match=r"several arms .*/left/arm/backbone, /right/arm/back"):
        read_run(tmp_path / "two")
    assert read_run(tmp_path / "two", node="/right/arm").backbone.poses.max() == 1.0
    assert read_run(tmp_path / "two", node="/left/arm").backbone.poses.max() == 0.0
    with pytest.raises(RecordingError, match="of /middle/arm"):
        read_run(tmp_path / "two", node="/middle/arm")


def test_messages_that_change_shape_are_refused_with_their_topic(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "odd", recorded_topics("/arm")) as bag:
        bag.write("backbone", 0, PoseArrayBuffer("world", 2).fill(0, np.zeros((2, 7))))
        bag.write("backbone", 1, PoseArrayBuffer("world", 3).fill(1, np.zeros((3, 7))))
    run = read_run(tmp_path / "odd")
    with pytest.raises(RecordingError, match=r"/arm/backbone: .* message 1 of 2 differs in size"):
        run.backbone  # noqa: B018


def test_messages_out_of_order_come_in_the_order_of_time(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "order", [Topic("events", "/arm/events", STRING)]) as bag:
        for time_ns, text in ((9, "c"), (3, "a"), (3, "b")):
            bag.write("events", time_ns, encode_string(text))
    run = read_run(tmp_path / "order")
    assert run.events == [(3, "a"), (3, "b"), (9, "c")]
    assert [m.time_ns for m in run.messages()] == [3, 3, 9]
