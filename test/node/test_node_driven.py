"""Bases that follow poses, joints that follow positions, wrenches by name: over DDS, recorded."""

from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, WrenchStamped
from nav_msgs.msg import Odometry
from peer import simulator, wait_for
from sensor_msgs.msg import JointState

from soft_sim_ros.experiments.resimulation import rerun
from soft_sim_ros.recording.reader import read_run

SCENE = Path(__file__).with_name("carried.yaml")


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    folder = tmp_path_factory.mktemp("carried")
    program = simulator(folder, scene=SCENE, record=folder / "run", command_timeout=0.2)
    yield program, folder
    if program.process.poll() is None:
        assert program.end() == 0, program.text


def test_a_mobile_base_a_wrist_and_a_push_are_commanded_recorded_and_simulated_again(arm, peer):
    program, folder = arm
    states = peer.listen(JointState, "joint_states", 1000)
    tips = peer.listen(PoseStamped, "soft_arm/tip_pose")
    joints = peer.talk(JointState, "soft_arm/joint_command")
    poses = peer.talk(PoseStamped, "soft_arm/drive/base")
    odometry = peer.talk(Odometry, "soft_arm/drive_odometry/base")
    push = peer.talk(WrenchStamped, "soft_arm/external_wrench/elbow")
    wait_for(lambda: states, "a state")
    coordinates = [f"base/{label}" for label in ("rx", "ry", "rz", "x", "y", "z")]
    assert list(states[-1].name) == ["pitch", *coordinates, "wrist"]

    def state(name):
        at = list(states[-1].name).index(name)
        return states[-1].position[at], states[-1].velocity[at], states[-1].effort[at]

    assert state("wrist")[0] == pytest.approx(0.1)
    nan = float("nan")
    names = ["wrist", "pitch"]
    joints.publish(JointState(name=names, position=[-0.2, nan], effort=[nan, 0.05]))
    wait_for(lambda: state("wrist")[0] == pytest.approx(-0.2), "the wrist")
    assert state("wrist")[1] == 0.0
    message = PoseStamped()
    message.pose.position.x, message.pose.orientation.w = 0.4, 1.0
    poses.publish(message)
    wait_for(lambda: state("base/x")[0] == pytest.approx(0.4), "the base")
    assert tips[-1].pose.position.x > 0.5
    moving = Odometry()
    moving.pose.pose.position.x = 0.4
    # a quarter turn about z: what moves along its own x goes along y of the world
    moving.pose.pose.orientation.z = moving.pose.pose.orientation.w = np.sqrt(0.5)
    moving.twist.twist.linear.x = 0.3
    odometry.publish(moving)
    at = list(states[-1].name).index("base/y")
    rates = lambda: [message.velocity[at] for message in list(states)]  # noqa: E731
    wait_for(lambda: any(x == pytest.approx(0.3) for x in rates()), "the rate of the base")
    # nobody renews it, so it is brought to rest
    wait_for(lambda: state("base/y")[1] == 0.0, "rest")
    wrench = WrenchStamped()
    wrench.wrench.force.z = 1.0
    before = state("wrist")[2]
    push.publish(wrench)
    wait_for(lambda: abs(state("wrist")[2] - before) > 0.02, "what the wrist feels of the push")
    wrench.header.frame_id = "nowhere"
    push.publish(wrench)
    program.wait_for_text("refused ~/external_wrench/elbow: frame 'nowhere'")
    joints.publish(JointState(name=["wrist"], effort=[1.0]))
    program.wait_for_text("expected a position or a velocity")
    assert program.end() == 0, program.text
    run = read_run(folder / "run")
    kinds = {entry.key for entry in run.inputs}
    assert kinds >= {"drive/base", "drive_odometry/base", "external_wrench/elbow", "joint_command"}
    compared = rerun(run)
    assert compared.identical, compared
