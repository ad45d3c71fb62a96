"""The tip's transform; tf2_msgs comes with ROS, not with its wheels, so both cases are real."""

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest
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
    (transform,) = wait_for(lambda: messages, "a transform")[-1].transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("plate", "soft_arm/tip")
    move = transform.transform.translation
    assert math.dist((move.x, move.y, move.z), (0.0, 0.0, 0.5)) <= 0.31
    turn = transform.transform.rotation
    assert np.linalg.norm([turn.x, turn.y, turn.z, turn.w]) == pytest.approx(1.0, abs=1e-9)
    assert program.end() == 0
