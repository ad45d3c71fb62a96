"""The URDF says what the scene says: tree, places, axes, limits, topics."""

import xml.etree.ElementTree as Xml

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from soft_sim_ros.commands.urdf import main
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import load_scene, packaged_scenes

NAMES = sorted(packaged_scenes())


def robot(name, *options, capsys):
    assert main([name, *options]) == 0
    return Xml.fromstring(capsys.readouterr().out)


def numbers(text):
    return np.array([float(word) for word in text.split()])


def place(tree, link, positions=None):
    """Pose (4, 4) of a link in the root link, for positions of joints by name."""
    parents = {joint.find("child").get("link"): joint for joint in tree.iter("joint")
               if joint.find("child") is not None}  # fmt: skip
    pose = np.eye(4)
    while link in parents:
        joint = parents[link]
        origin = joint.find("origin")
        step = np.eye(4)
        step[:3, :3] = Rotation.from_euler("xyz", numbers(origin.get("rpy"))).as_matrix()
        step[:3, 3] = numbers(origin.get("xyz"))
        amount = (positions or {}).get(joint.get("name"), 0.0)
        if joint.get("type") == "continuous":
            axis = numbers(joint.find("axis").get("xyz"))
            step[:3, :3] = step[:3, :3] @ Rotation.from_rotvec(amount * axis).as_matrix()
        elif joint.get("type") == "prismatic":
            step[:3, 3] += step[:3, :3] @ numbers(joint.find("axis").get("xyz")) * amount
        pose = step @ pose
        link = joint.find("parent").get("link")
    return pose


@pytest.mark.parametrize("name", NAMES)
def test_it_is_one_tree_of_links_with_names_of_their_own(name, capsys):
    tree = robot(name, capsys=capsys)
    links = [link.get("name") for link in tree.findall("link")]
    joints = tree.findall("joint")
    names = [joint.get("name") for joint in joints]
    assert len(set(links)) == len(links) and len(set(names)) == len(names)
    children = [joint.find("child").get("link") for joint in joints]
    assert sorted([*children, "world"]) == sorted(links)
    assert {joint.find("parent").get("link") for joint in joints} <= set(links)
    for joint in joints:
        if joint.get("type") == "prismatic":
            assert float(joint.find("limit").get("lower")) < float(joint.find("limit").get("upper"))


@pytest.mark.parametrize("name", ["mixed_chain", "gantry", "soft_arm"])
def test_its_tip_is_where_the_reference_shape_has_it_and_joints_move_it_alike(name, capsys):
    tree = robot(name, capsys=capsys)
    simulation = Simulation(load_scene(name))
    q = np.zeros(simulation.n_coordinates)
    positions = {}
    for i, coordinate in enumerate(simulation.coordinate_names):
        for actuator in simulation.scene.actuators:
            joint = getattr(actuator, "joint", None)
            own = ("first", "second")[getattr(actuator, "axis", 0)]
            if joint is not None and coordinate in (joint, f"{joint}/{own}"):
                q[i] = positions[actuator.name] = 0.3 + 0.2 * i
    simulation.set_state(q, np.zeros_like(q))
    expected = simulation.sampler(2).poses()[-1]
    found = place(tree, "tip_link", positions)
    assert found[:3, 3] == pytest.approx(expected[:3], abs=1e-7)
    turn = Rotation.from_quat(expected[3:]).as_matrix()
    assert found[:3, :3] == pytest.approx(turn, abs=1e-7)


def test_every_actuator_is_a_joint_with_its_limit_and_known_to_ros2_control(capsys):
    tree = robot("mixed_chain", "--node", "/left/soft_arm", capsys=capsys)
    joints = {joint.get("name"): joint for joint in tree.findall("joint")}
    efforts = {name: float(joints[name].find("limit").get("effort"))
               for name in ("yaw", "pitch", "elbow_motor_torque", "curl")}  # fmt: skip
    assert efforts == {"yaw": 2.0, "pitch": 4.0, "elbow_motor_torque": 1.0, "curl": 20.0}
    assert joints["curl"].get("type") == "prismatic" and joints["yaw"].get("type") == "continuous"
    control = tree.find("ros2_control")
    assert [joint.get("name") for joint in control.findall("joint")] == list(efforts)
    given = {param.get("name"): param.text for param in control.iter("param")}
    assert given["joint_commands_topic"] == "/left/soft_arm/joint_command"
    assert given["joint_states_topic"] == "/left/joint_states"
    assert control.findtext("hardware/plugin").endswith("/JointStateTopicSystem")


def test_a_rod_is_seen_with_its_radius_and_all_of_its_length(capsys):
    tree = robot("soft_arm", capsys=capsys)
    cylinders = [visual.find("geometry/cylinder") for visual in tree.iter("visual")]
    radii = [float(cylinder.get("radius")) for cylinder in cylinders]
    assert sum(float(cylinder.get("length")) for cylinder in cylinders) == pytest.approx(0.6)
    assert 0.029 < radii[0] < 0.030 and 0.022 < radii[-1] < 0.0225
