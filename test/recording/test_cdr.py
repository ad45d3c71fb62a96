"""The bytes of every message are those that ROS 2 itself would write."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rosbags.typesys import Stores, get_typestore

from soft_sim_ros.recording import cdr, topics
from soft_sim_ros.recording.decode import CLOCK, DecodeError, _walk, decode, stack

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES = STORE.types

numbers = st.floats(allow_nan=True, allow_infinity=True, width=64)
times = st.integers(0, 2**31 * 10**9 - 1)
texts = st.text(st.characters(blacklist_characters="\0", blacklist_categories=("Cs",)), max_size=12)


def vectors(size: int) -> st.SearchStrategy[np.ndarray]:
    return arrays(np.float64, size, elements=numbers)


def header(time_ns: int, frame_id: str) -> object:
    seconds, nanoseconds = divmod(time_ns, 10**9)
    stamp = TYPES["builtin_interfaces/msg/Time"](seconds, nanoseconds)
    return TYPES["std_msgs/msg/Header"](stamp, frame_id)


def pose(values: np.ndarray) -> object:
    x, y, z, *q = values
    point = TYPES["geometry_msgs/msg/Point"](x, y, z)
    return TYPES["geometry_msgs/msg/Pose"](point, TYPES["geometry_msgs/msg/Quaternion"](*q))


def reference(kind: str, *fields: object) -> bytes:
    """Serialise with rosbags, which pads with zeros as we do."""
    return bytes(STORE.serialize_cdr(TYPES[kind](*fields), kind))


@given(times, texts, st.integers(0, 6).flatmap(lambda n: vectors(7 * n)))
def test_pose_array(time_ns: int, frame: str, values: np.ndarray) -> None:
    poses = values.reshape(-1, 7)
    data = cdr.PoseArrayBuffer(frame, len(poses)).fill(time_ns, poses)
    expected = reference(topics.POSES, header(time_ns, frame), [pose(p) for p in poses])
    assert data == expected
    back = decode(topics.POSES, data)
    assert (back.stamp_ns, back.frame_id) == (time_ns, frame)
    np.testing.assert_array_equal(back.poses, poses)


@given(times, texts, st.lists(texts, max_size=4), st.tuples(*[st.booleans()] * 3), st.data())
def test_joint_state(time_ns, frame, names, present, data) -> None:
    values = [data.draw(vectors(len(names) if there else 0)) for there in present]
    position, velocity, effort = present
    buffer = cdr.JointStateBuffer(
        names, position=position, velocity=velocity, effort=effort, frame_id=frame
    )
    message = buffer.fill(time_ns, *values)
    assert message == reference(topics.JOINTS, header(time_ns, frame), names, *values)
    back = decode(topics.JOINTS, message)
    assert (back.stamp_ns, back.frame_id, back.name) == (time_ns, frame, tuple(names))
    for got, put in zip((back.position, back.velocity, back.effort), values, strict=True):
        np.testing.assert_array_equal(got, put)


@given(texts, st.integers(0, 5).flatmap(vectors))
def test_float_array(label: str, values: np.ndarray) -> None:
    n = len(values)
    dimension = TYPES["std_msgs/msg/MultiArrayDimension"]
    layout = TYPES["std_msgs/msg/MultiArrayLayout"]([dimension(label, n, n)] if label else [], 0)
    message = cdr.encode_floats(values, label)
    assert message == reference(topics.FLOATS, layout, values)
    back = decode(topics.FLOATS, message)
    assert back.labels == ((label,) if label else ())
    np.testing.assert_array_equal(back.data, values)


@given(times, texts, vectors(7))
def test_pose_stamped(time_ns: int, frame: str, values: np.ndarray) -> None:
    message = cdr.PoseStampedBuffer(frame).fill(time_ns, values)
    assert message == reference(topics.POSE, header(time_ns, frame), pose(values))
    np.testing.assert_array_equal(decode(topics.POSE, message).poses[0], values)


@given(times, texts, vectors(6))
def test_wrench_has_the_moment_first_here_and_the_force_first_in_the_message(
    time_ns: int, frame: str, values: np.ndarray
) -> None:
    message = cdr.WrenchStampedBuffer(frame).fill(time_ns, values)
    vector = TYPES["geometry_msgs/msg/Vector3"]
    wrench = TYPES["geometry_msgs/msg/Wrench"](vector(*values[3:]), vector(*values[:3]))
    assert message == reference(topics.WRENCH, header(time_ns, frame), wrench)
    np.testing.assert_array_equal(decode(topics.WRENCH, message).wrench, values)


@given(times, texts)
def test_clock_and_string(time_ns: int, text: str) -> None:
    clock = cdr.ClockBuffer().fill(time_ns)
    seconds, nanoseconds = divmod(time_ns, 10**9)
    stamp = TYPES["builtin_interfaces/msg/Time"](seconds, nanoseconds)
    assert clock == reference(CLOCK, stamp)
    assert decode(CLOCK, clock) == time_ns
    message = cdr.encode_string(text)
    assert message == reference(topics.STRING, text)
    assert decode(topics.STRING, message) == text


def test_a_buffer_forgets_the_message_before() -> None:
    buffer = cdr.PoseArrayBuffer("world", 2)
    first, second = np.arange(14.0).reshape(2, 7), -np.ones((2, 7))
    earlier = buffer.fill(5, first)
    assert buffer.fill(2**40, second) == cdr.PoseArrayBuffer("world", 2).fill(2**40, second)
    np.testing.assert_array_equal(decode(topics.POSES, earlier).poses, first)


def test_a_buffer_refuses_another_number_of_poses() -> None:
    with pytest.raises(ValueError, match="broadcast"):
        cdr.PoseArrayBuffer("world", 3).fill(0, np.zeros((2, 7)))


@settings(max_examples=30)
@given(st.integers(1, 5), st.integers(1, 8), st.booleans())
def test_a_stack_equals_its_messages(count: int, n: int, big_endian: bool) -> None:
    rng = np.random.default_rng(count * 10 + n)
    names = [f"joint{i}" * i for i in range(n)]
    values = rng.normal(size=(count, 2, n))
    payloads = []
    for index in range(count):
        fields = (header(index * 10**9 + 7, "f"), names, *values[index], np.zeros(0))
        message = TYPES[topics.JOINTS](*fields)
        payloads.append(
            bytes(STORE.serialize_cdr(message, topics.JOINTS, little_endian=not big_endian))
        )
    found = stack(topics.JOINTS, payloads)
    assert found.stamps_ns.tolist() == [i * 10**9 + 7 for i in range(count)]
    assert found.texts == tuple(names)
    np.testing.assert_array_equal(found.blocks[0], values[:, 0])
    np.testing.assert_array_equal(found.blocks[1], values[:, 1])
    assert found.blocks[2].shape == (count, 0)


def test_a_stack_refuses_messages_of_another_layout_and_says_which() -> None:
    one = cdr.JointStateBuffer(["a", "b"]).fill(0, [1, 2], [3, 4], [5, 6])
    other = cdr.JointStateBuffer(["a", "c"]).fill(0, [1, 2], [3, 4], [5, 6])
    longer = cdr.JointStateBuffer(["a"]).fill(0, [1], [3], [5])
    with pytest.raises(DecodeError, match="message 2 of 3 differs in layout"):
        stack(topics.JOINTS, [one, one, other])
    with pytest.raises(DecodeError, match="message 1 of 2 differs in size"):
        stack(topics.JOINTS, [one, longer])


@given(st.binary(max_size=80), st.sampled_from([topics.POSES, topics.JOINTS, topics.FLOATS]))
def test_any_bytes_are_decoded_or_refused(data: bytes, kind: str) -> None:
    try:
        decode(kind, b"\0\1\0\0" + data)
    except DecodeError as error:
        assert kind in str(error)


@given(st.integers(0, 100))
def test_a_message_cut_short_is_refused(length: int) -> None:
    whole = cdr.JointStateBuffer(["a", "b"]).fill(3, [1, 2], [3, 4], [5, 6])
    cut = whole[: min(length, len(whole) - 1)]
    with pytest.raises(DecodeError):
        decode(topics.JOINTS, cut)


def covered(kind: str, data: bytes) -> np.ndarray:
    """Mark the bytes that carry something; the rest is padding, which rclpy leaves as it is."""
    walk = _walk(kind, data)
    mask = np.zeros(len(data), bool)
    for part in walk.fixed:
        mask[part] = True
    if walk.stamp is not None:
        mask[walk.stamp : walk.stamp + 8] = True
    for at, count in walk.blocks:
        mask[at : at + 8 * count] = True
    return mask


@pytest.mark.parametrize("frame", ["", "world", "a_frame"])
def test_rclpy_writes_the_same_bytes_and_reads_them_back(frame: str) -> None:
    serialization = pytest.importorskip("rclpy.serialization", reason="needs rclpy")
    from geometry_msgs.msg import PoseArray, PoseStamped, WrenchStamped
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64MultiArray, String

    rng = np.random.default_rng(1)
    time_ns, names = 12_345_678_901, ["one", "number two"]
    ours = {
        PoseArray: (topics.POSES, cdr.PoseArrayBuffer(frame, 4).fill(time_ns, rng.random((4, 7)))),
        PoseStamped: (topics.POSE, cdr.PoseStampedBuffer(frame).fill(time_ns, rng.random(7))),
        WrenchStamped: (topics.WRENCH, cdr.WrenchStampedBuffer(frame).fill(time_ns, rng.random(6))),
        JointState: (
            topics.JOINTS,
            cdr.JointStateBuffer(names, effort=False, frame_id=frame).fill(
                time_ns, rng.random(2), rng.random(2)
            ),
        ),
        Float64MultiArray: (topics.FLOATS, cdr.encode_floats(rng.random(3), "a,b,c")),
        String: (topics.STRING, cdr.encode_string("reset")),
        Clock: (CLOCK, cdr.ClockBuffer().fill(time_ns)),
    }
    for message_class, (kind, data) in ours.items():
        message = serialization.deserialize_message(data, message_class)
        theirs = serialization.serialize_message(message)
        mask = covered(kind, data)
        assert 0 <= len(theirs) - len(data) < 8, kind  # rclpy also pads behind an empty sequence
        same = np.frombuffer(theirs[: len(data)], np.uint8) == np.frombuffer(data, np.uint8)
        assert same[mask].all(), kind
        assert not np.frombuffer(data, np.uint8)[2:][~mask[2:]].any(), "padding must be zero"
        assert decode(kind, theirs) is not None
    backbone = serialization.deserialize_message(ours[PoseArray][1], PoseArray)
    assert backbone.header.frame_id == frame
    assert backbone.header.stamp.sec == 12 and backbone.header.stamp.nanosec == 345_678_901
    expected = np.random.default_rng(1).random((4, 7))
    for got, put in zip(backbone.poses, expected, strict=True):
        assert [got.position.x, got.position.y, got.position.z] == put[:3].tolist()
        o = got.orientation
        assert [o.x, o.y, o.z, o.w] == put[3:].tolist()
    joints = serialization.deserialize_message(ours[JointState][1], JointState)
    assert joints.name == names and len(joints.effort) == 0 and len(joints.velocity) == 2


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
@pytest.mark.parametrize(
    ("kind", "layout", "values"),
    [
        (cdr.PoseArrayBuffer, ("base", 2), (7, np.arange(14.0).reshape(2, 7))),
        (cdr.JointStateBuffer, (("a", "b"),), (7, [1.0, 2.0], [3.0, 4.0], [5.0, 6.0])),
        (cdr.Float64MultiArrayBuffer, (2, "x"), ([1.0, 2.0],)),
        (cdr.PoseStampedBuffer, ("base",), (7, np.arange(7.0))),
        (cdr.WrenchStampedBuffer, ("base",), (7, np.arange(6.0))),
        (cdr.ClockBuffer, (), (7,)),
    ],
)
def test_a_copy_of_a_buffer_is_filled_as_the_original_and_by_itself(way, kind, layout, values):
    buffer = kind(*layout)
    empty, other = buffer._message.tobytes(), way(buffer)
    assert other.fill(*values) == kind(*layout).fill(*values) != empty
    assert buffer._message.tobytes() == empty
