"""The tip's transform; tf2_msgs comes with ROS, not with its wheels, so both cases are real."""

import importlib.util
import math
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import TransformStamped
from peer import PROGRAM, Program, simulator, wait_for

SCENE = Path(__file__).with_name("arm.yaml")
HAVE_TF = importlib.util.find_spec("tf2_msgs") is not None


@pytest.mark.skipif(HAVE_TF, reason="tf2_msgs is installed")
def test_without_tf2_msgs_asking_for_tf_is_refused_in_words(tmp_path):
    program = Program(
        tmp_path, PROGRAM, "--ros-args", "-p", "publish_tf:=true", "-p", f"scene:={SCENE}"
    )
    assert program.wait(300.0) == 2
    assert "publish_tf = True: expected False, because tf2_msgs is not installed" in program.text


@pytest.mark.skipif(not HAVE_TF, reason="tf2_msgs is not installed: the other test applies")
def test_the_tip_is_a_frame(tmp_path, peer):
    from tf2_msgs.msg import TFMessage

    program = simulator(tmp_path, scene=SCENE, publish_tf="true", frame_id="plate")
    messages = peer.listen(TFMessage, "/tf")
    base, transform = wait_for(lambda: messages, "a transform")[-1].transforms
    assert base.child_frame_id == "soft_arm/base"
    assert (transform.header.frame_id, transform.child_frame_id) == ("plate", "soft_arm/tip")
    move = transform.transform.translation
    assert math.dist((move.x, move.y, move.z), (0.0, 0.0, 0.5)) <= 0.31
    turn = transform.transform.rotation
    assert np.linalg.norm([turn.x, turn.y, turn.z, turn.w]) == pytest.approx(1.0, abs=1e-9)
    assert program.end() == 0


def nobody(*_):
    """Take no note of listeners that come and go."""


class Ear:
    """A node whose one publisher keeps what it is given."""

    def __init__(self):
        self.heard = []

    def get_fully_qualified_name(self):
        return "/left/soft_arm"

    def create_publisher(self, *_, **__):
        return SimpleNamespace(publish=self.heard.append, get_subscription_count=lambda: 1)


@pytest.fixture
def tf2(monkeypatch):
    """Stand in for tf2_msgs, which no wheel brings."""
    for name in ("tf2_msgs", "tf2_msgs.msg"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    sys.modules["tf2_msgs.msg"].TFMessage = SimpleNamespace


def test_chosen_frames_and_those_along_the_backbone_are_where_the_arm_has_them(tf2):
    from soft_sim_ros.core.settled import Simulation
    from soft_sim_ros.node.tip_frame import ArmFrames
    from soft_sim_ros.scene import load_scene

    simulation = Simulation(load_scene("mixed_chain"))
    node = Ear()
    frames = ArmFrames(node, simulation.scene, "world", "elbow, gripper", 5, nobody)
    frames.show(simulation)
    simulation.advance(20)
    frames.send(1_500_000_000)
    (message,) = node.heard
    found = {t.child_frame_id.removeprefix("left/soft_arm/"): t for t in message.transforms}
    along = [f"backbone_{i}" for i in range(5)]
    assert list(found) == ["base", "tip", "elbow", "gripper", *along]
    assert all(isinstance(t, TransformStamped) for t in message.transforms)
    stamps = {(t.header.stamp.sec, t.header.stamp.nanosec) for t in message.transforms}
    assert stamps == {(1, 500_000_000)}
    poses = simulation.sampler(5).poses()
    for name, pose in zip(along, poses, strict=True):
        move = found[name].transform.translation
        assert (move.x, move.y, move.z) == tuple(pose[:3])
    assert found["tip"].transform == found["backbone_4"].transform == found["gripper"].transform
    elbow = found["elbow"].transform.translation
    upper = simulation.scene.bodies[1].rod.length
    # the link before the elbow moves little out of its straight line
    distance = math.dist((elbow.x, elbow.y, elbow.z), (0.0, 0.0, 1.0))
    assert distance == pytest.approx(upper, rel=1e-2)


def test_a_frame_that_is_none_of_the_scene_is_refused_with_those_there_are(tf2):
    from soft_sim_ros.node.parameters import ParameterError
    from soft_sim_ros.node.tip_frame import ArmFrames
    from soft_sim_ros.scene import load_scene

    with pytest.raises(ParameterError, match=r"shoulder, elbow_motor, elbow, gripper.*'elbo'"):
        ArmFrames(Ear(), load_scene("mixed_chain"), "world", "elbo", 0, nobody)
