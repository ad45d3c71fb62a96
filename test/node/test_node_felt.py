"""Latches, reactions and contacts of a running node: over DDS, recorded, simulated again."""

from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from peer import simulator, wait_for
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import SetBool
from visualization_msgs.msg import Marker, MarkerArray

from soft_sim_ros.experiments.resimulation import rerun
from soft_sim_ros.recording.reader import read_run

SCENE = Path(__file__).with_name("latched.yaml")
FIXED = QoSProfile(
    depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE
)


def numbers(message, name):
    """Return a field of all points of a cloud."""
    (field,) = (one for one in message.fields if one.name == name)
    raw = np.frombuffer(bytes(message.data), np.uint8).reshape(message.width, message.point_step)
    kind = {7: "<f4", 4: "<u2", 2: "u1"}[field.datatype]
    own = raw[:, field.offset : field.offset + np.dtype(kind).itemsize]
    return np.ascontiguousarray(own).view(kind)[:, 0]


def test_an_arm_is_let_go_onto_a_table_and_caught_again(tmp_path, peer):
    program = simulator(tmp_path, scene=SCENE, record=tmp_path / "run", publish_rate=100)
    reactions = peer.listen(WrenchStamped, "soft_arm/reaction/latch")
    clouds = peer.listen(PointCloud2, "soft_arm/contacts")
    markers = peer.listen(MarkerArray, "soft_arm/markers")
    fixed = peer.listen(MarkerArray, "soft_arm/fixed_markers", FIXED)
    wait_for(lambda: reactions and clouds, "what the arm feels")
    assert reactions[-1].header.frame_id == "world"
    assert clouds[-1].width == 0
    # a beam that is held at its end carries 3/8 of its weight there
    weight = 1100.0 * np.pi * 1e-4 * 0.3 * 9.81
    wait_for(
        lambda: reactions[-1].wrench.force.z == pytest.approx(0.375 * weight, rel=0.05),
        "three eighths of the weight",
    )
    answer = peer.ask(SetBool, "soft_arm/constraint/latch", SetBool.Request(data=False))
    assert (answer.success, answer.message) == (True, "latch released")
    wait_for(lambda: clouds[-1].width > 0, "contact")
    wait_for(lambda: reactions[-1].wrench.force.z == 0.0, "a latch that lets go")
    wait_for(lambda: numbers(clouds[-1], "normal_force").sum() > 0.02, "a normal force")
    np.testing.assert_allclose(numbers(clouds[-1], "normal_z"), 1.0)
    assert numbers(clouds[-1], "z") == pytest.approx(-0.06, abs=1e-3)

    def arrows(group):
        found = (m for m in markers[-1].markers if m.ns == group and m.action == Marker.ADD)
        return [(m.points[0], m.points[1]) for m in found]

    wait_for(lambda: arrows("contacts"), "an arrow")
    tail, head = arrows("contacts")[0]
    assert head.z > tail.z == pytest.approx(-0.06, abs=1e-3)
    assert not arrows("reactions")
    (table,) = (m for message in fixed for m in message.markers if m.ns == "environment")
    assert table.type == Marker.CUBE
    assert table.pose.position.z + table.scale.z / 2 == pytest.approx(-0.06, abs=1e-9)
    answer = peer.ask(SetBool, "soft_arm/constraint/shelf", SetBool.Request(data=True))
    assert not answer.success
    assert "'shelf' is not met" in answer.message
    answer = peer.ask(SetBool, "soft_arm/constraint/latch", SetBool.Request(data=True))
    assert (answer.success, answer.message) == (True, "latch held")
    wait_for(lambda: arrows("reactions"), "the arrow of a reaction")
    assert program.end() == 0, program.text
    run = read_run(tmp_path / "run")
    assert [text for _, text in run.events] == ["released: latch", "held: latch"]
    assert len(run.contacts.at) > 5
    compared = rerun(run)
    assert compared.identical, compared
