"""Whatever others send is looked at within bounds, and said on one line of bounded length."""

import time
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, MultiArrayDimension

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import CommandError
from soft_sim_ros.foreign import LONGEST, bare, listed, one_line, shown
from soft_sim_ros.node.commands import Gate, Throttle
from soft_sim_ros.scene import load_scene

SCENE = load_scene(Path(__file__).with_name("arm.yaml"))
EVIL = "pitch\n[FATAL] all is lost\x1b[2J\x1b]0;x\x07\u202e\u2028\x00\x9b1m\udcff"


@pytest.fixture(scope="module")
def inputs():
    return Inputs(Simulation(SCENE), 0.0, 0.0)


@pytest.fixture
def gate(inputs):
    said, taken = [], []
    result = Gate(inputs, "world", lambda *order: taken.append(order) or True, said.append)
    result.said, result.taken = said, taken
    return result


@pytest.mark.parametrize("write", [shown, bare, one_line])
@pytest.mark.parametrize(
    "text", [EVIL, "ä µ 弧", "", 5, None, [EVIL], EVIL.encode("utf-8", "replace")]
)
def test_every_text_is_shown_on_one_printable_line(write, text):
    line = write(text)
    assert line.isprintable()
    assert len(line.splitlines()) <= 1


def test_what_can_be_printed_is_shown_as_it_is():
    assert one_line("Rückgrat µ 弧 'x'") == "Rückgrat µ 弧 'x'"
    assert shown("Rückgrat") == "'Rückgrat'"


@pytest.mark.parametrize("write", [shown, bare])
def test_a_long_text_is_cut_and_its_length_said(write):
    line = write("\n" * 100_000)
    assert len(line) < 3 * LONGEST
    assert "(100000 characters)" in line


def test_a_long_list_is_cut_and_counted():
    assert listed(["a", "b\n"]) == "'a', 'b\\n'"
    assert listed(map(str, range(1000))).endswith("'4' and 995 more")


def joints(names, efforts=None):
    count = len(names)
    return JointState(
        name=names,
        # without these the serializer of rclpy, unlike that of DDS, leaves bytes at the end
        position=[0.0] * count,
        velocity=[0.0] * count,
        effort=[0.1] * count if efforts is None else efforts,
    )


def array(count, label=""):
    message = Float64MultiArray(data=[0.1] * count)
    message.layout.dim = [MultiArrayDimension(label=label)] if label else []
    return message


def wrench(frame_id):
    message = WrenchStamped()
    message.header.frame_id = frame_id
    return message


BAD = {
    "repeated names": ("joint_command", joints(["pitch"] * 100_000)),
    "few repeated names": ("joint_command", joints(["pitch"] * 300)),
    "unknown names": ("joint_command", joints([f"x{k}" for k in range(500)])),
    "a name with escapes": (
        "joint_command",
        joints([EVIL.replace("\x00", "").replace("\udcff", "")]),
    ),
    "a long name": ("joint_command", joints(["x" * 1_000_000])),
    "a fairly long name": ("joint_command", joints(["x" * 10_000])),
    "names without efforts": ("joint_command", joints(["a\nb"] * 400, [])),
    "no names": ("joint_command", joints([], [0.1] * 100)),
    "a huge array": ("command", array(1_000_000)),
    "a long array": ("command", array(1000)),
    "a huge label": ("command", array(2, "x" * 1_000_000)),
    "many labels": (
        "command",
        Float64MultiArray(
            layout=array(0, "x").layout.__class__(dim=[MultiArrayDimension()] * 50_000)
        ),
    ),
    "a frame with escapes": ("external_wrench", wrench("a\n\x1b[31m")),
    "a huge frame": ("external_wrench", wrench("x" * 1_000_000)),
    "a fairly long frame": ("external_wrench", wrench("x" * 10_000)),
}
BYTES = {
    "nothing": b"",
    "no CDR": b"\x1b[31m\n" * 50,
    "names announced that are not there": b"\0\1\0\0"
    + bytes(12)
    + b"\xff\xff\xff\x7f"
    + bytes(500),
    "no UTF-8": bytes(serialize_message(joints(["pitch"]))).replace(
        b"pitch", b"\xff\x1b\n\xfe\xff"
    ),
}


@pytest.mark.parametrize("name", [*BAD, *BYTES])
def test_a_bad_message_costs_little_and_is_refused_on_one_short_line(gate, name):
    key, message = BAD.get(name, ("joint_command", None))
    data = BYTES[name] if message is None else bytes(serialize_message(message))
    begin = time.process_time()
    gate.receive(key, data)
    assert time.process_time() - begin < 0.2
    (line,) = gate.said
    assert line.startswith("refused ~/") and line.isprintable() and len(line) < 1000, line
    assert (gate.refused, gate.accepted, gate.taken) == (1, 0, [])


def test_a_thousand_times_the_names_cost_about_a_thousand_times_as_much(inputs):
    def cost(count):
        names, efforts = ["pitch"] * count, np.zeros(count)
        begin = time.process_time()
        for _ in range(3):
            with pytest.raises(CommandError, match="more than once: pitch"):
                inputs.joint_order(names, efforts)
        return time.process_time() - begin

    cost(10)
    assert cost(100_000) < 30.0 * max(cost(10_000), 1e-3)


@pytest.mark.parametrize("what", ["names", "frames", "lengths", "numbers", "bytes"])
def test_a_flood_of_one_kind_is_few_lines_whatever_is_in_it(gate, what):
    for k in range(646):
        message = {
            "names": ("joint_command", joints([f"{'xyz'[k % 3] * (k + 1)}"])),
            "frames": ("external_wrench", wrench("ab"[k % 2] * (k + 1))),
            "lengths": ("command", array(k + 3)),
            "numbers": ("command", Float64MultiArray(data=[float("nan"), float(k)])),
        }.get(what)
        data = bytes([k % 256]) * 9 if message is None else bytes(serialize_message(message[1]))
        gate.receive("command" if message is None else message[0], data)
    assert gate.refused == 646
    assert len(gate.said) <= 2


def test_kinds_do_not_hide_each_other(gate):
    gate.receive("joint_command", bytes(serialize_message(joints(["roll"]))))
    gate.receive("command", bytes(serialize_message(array(3))))
    gate.receive("joint_command", bytes(serialize_message(joints(["pitch", "pitch"]))))
    assert len(gate.said) == 3


def test_a_flood_of_kinds_is_few_lines():
    said, now = [], [0.0]
    complain = Throttle(said.append, 1.0, lambda: now[0])
    for k in range(5000):
        complain(f"{'x' * k}")
    assert len(said) <= 101
    now[0] = 3.0
    complain("one more")
    assert len(said) <= 102


def test_orders_that_nobody_takes_up_do_not_pile_up(inputs):
    from soft_sim_ros.node.inbox import MOST_WAITING, Inbox

    inbox, said = Inbox(), []
    gate = Gate(inputs, "world", inbox.submit, said.append)
    data = bytes(serialize_message(array(2)))
    for _ in range(MOST_WAITING + 5):
        gate.receive("command", data)
    assert (gate.accepted, gate.refused) == (MOST_WAITING, 5)
    assert "too many commands wait" in said[-1]
