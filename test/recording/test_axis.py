"""A recording says which times it goes by, and those of another program's are the arm's own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording import cdr
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.report import numbers
from soft_sim_ros.scene.limbs import CHAIN, Limbs

STORE = get_typestore(Stores.ROS2_JAZZY)
NOW = 1_790_000_000_000_000_000  # ns, by the clock on the wall
MS = 1_000_000
NAMES = "kinetic,elastic"


def plain(path: Path, slow: int, stamps=None, plugin=StoragePlugin.MCAP, limbs=CHAIN) -> Path:
    """Record as ``ros2 bag record`` does: an arm that runs ``slow`` times slower than real time.

    A state every 10 ms of simulation; a command halfway between the third and the fourth.
    """
    rng = np.random.default_rng(1)
    poses, joints = cdr.PoseArrayBuffer("world", 2), cdr.JointStateBuffer(["a"])
    energy = cdr.Float64MultiArrayBuffer(2, NAMES)
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        connections = {
            topic.key: writer.add_connection(topic.name, topic.type, typestore=STORE)
            for topic in recorded_topics("/soft_arm", limbs)
        }
        for index in range(20):
            stamp = index * 10 * MS if stamps is None else stamps[index]
            wall = NOW + index * 10 * MS * slow
            shape = poses.fill(stamp, np.full((2, 7), index))
            rows = (
                *((key, shape) for key in connections if key.startswith("backbone")),
                ("joint_states", joints.fill(stamp, [index], [0], [0])),
                ("energy", energy.fill([index, 0.0])),
            )
            for key, data in rows:  # what arrives late, arrives late
                writer.write(connections[key], wall + int(rng.integers(MS)), data)
            if index == 3:
                middle = wall + 5 * MS * slow
                writer.write(connections["command"], middle, cdr.encode_floats([1.0]))
    return path


@pytest.mark.parametrize("slow", [1, 10])
def test_a_bag_by_the_clock_on_the_wall_goes_by_the_stamps_of_the_arm(tmp_path, slow):
    run = read_run(plain(tmp_path / "bag", slow))
    expected = np.arange(20) * 10 * MS
    for series in (run.backbone, run.joint_states, run.energy):
        np.testing.assert_array_equal(series.time_ns, expected)
    np.testing.assert_array_equal(run.energy["kinetic"], np.arange(20))
    assert (run.start, run.end) == (0.0, 0.19)
    (command,) = run.commands
    assert abs(command.time_ns - 35 * MS) < 1.5 * MS
    assert run.time_axis == "header stamps" and "by header stamps" in repr(run)
    assert ("Times are", "header stamps") in numbers.motion_rows(run)


def test_every_branch_goes_by_its_stamps(tmp_path):
    limbs = Limbs(backbones=("left", "right"), tips=("left", "right"))
    run = read_run(plain(tmp_path / "bag", 10, limbs=limbs))
    assert list(run.backbones) == ["left", "right"]
    for series in run.backbones.values():
        np.testing.assert_array_equal(series.time_ns, np.arange(20) * 10 * MS)


def test_our_own_recordings_go_by_their_log(record):
    run = read_run(record(steps=3)[0])
    assert run.time_axis == "simulation time of the log"


@pytest.mark.parametrize(
    ("stamps", "axis"),
    [([0] * 20, "log time, the stamps stand still")],
)
def test_stamps_that_tell_nothing_are_not_used(tmp_path, stamps, axis):
    run = read_run(plain(tmp_path / "bag", 1, stamps))
    assert run.time_axis == axis
    assert run.start == pytest.approx(NOW / 1e9)


def test_a_sqlite_bag_is_told_how_to_be_converted(tmp_path):
    bag = plain(tmp_path / "my bag", 1, plugin=StoragePlugin.SQLITE3)
    command = "ros2 bag convert -i '.*my bag' -o convert.yaml"
    for path in (bag, next(bag.glob("*.db3"))):
        with pytest.raises(RecordingError, match=command) as caught:
            read_run(path)
        assert "output_bags: [{uri: my bag_mcap, storage_id: mcap, all: true}]" in str(caught.value)
