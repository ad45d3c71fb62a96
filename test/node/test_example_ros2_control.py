"""The ros2_control example: its files agree with each other, with the scene and with the node."""

import math
import runpy
import sys
import time
from types import ModuleType, SimpleNamespace
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
import yaml
from peer import ROOT, simulator, wait_for
from sensor_msgs.msg import JointState

from soft_sim_ros.commands.urdf import main as urdf
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.node.parameters import ROWS
from soft_sim_ros.scene import load_scene

FOLDER = ROOT / "examples" / "ros2_control"
CONTROL = Xml.parse(FOLDER / "soft_arm.urdf").getroot().find("ros2_control")
PARAMETERS = {one.get("name"): one.text for one in CONTROL.find("hardware").iter("param")}
JOINTS = [joint.get("name") for joint in CONTROL.findall("joint")]
CONTROLLERS = yaml.safe_load((FOLDER / "controllers.yaml").read_text())
MANAGER = CONTROLLERS["controller_manager"]["ros__parameters"]


def controller(name):
    return CONTROLLERS[name]["ros__parameters"]


@pytest.fixture(scope="module")
def nodes():
    """The nodes of the launch file, from stand-ins of the classes of ROS's launch."""
    contents = {
        "launch": {"LaunchDescription": lambda entities: entities},
        "launch_ros": {},
        "launch_ros.actions": {"Node": lambda **fields: SimpleNamespace(**fields)},
    }
    with pytest.MonkeyPatch.context() as patch:
        for name, attributes in contents.items():
            module = ModuleType(name)
            vars(module).update(attributes)
            patch.setitem(sys.modules, name, module)
        found = runpy.run_path(str(FOLDER / "arm.launch.py"))
        return found["generate_launch_description"]()


def test_the_description_is_what_the_verb_writes(capsys):
    assert urdf(["soft_arm"]) == 0
    assert capsys.readouterr().out == (FOLDER / "soft_arm.urdf").read_text()


@pytest.mark.parametrize("scene", ["soft_arm", "winch_arm"])
def test_a_joint_has_the_command_interface_that_the_node_takes(scene, capsys):
    assert urdf([scene]) == 0
    control = Xml.fromstring(capsys.readouterr().out).find("ros2_control")
    wound = {a.name for a in load_scene(scene).actuators if getattr(a, "control", "") == "length"}
    assert bool(wound) == (scene == "winch_arm")
    for joint in control.findall("joint"):
        (command,) = [one.get("name") for one in joint.findall("command_interface")]
        assert command == ("position" if joint.get("name") in wound else "effort")


def test_controllers_use_joints_and_interfaces_that_the_description_has():
    for name in ("torques", "trajectory"):
        assert controller(name)["joints"] == JOINTS
        assert "type" in MANAGER[name]
    commands = {one.get("name") for one in CONTROL.iter("command_interface")}
    states = {one.get("name") for one in CONTROL.iter("state_interface")}
    assert {controller("torques")["interface_name"]} <= commands
    assert set(controller("trajectory")["command_interfaces"]) <= commands
    assert set(controller("trajectory")["state_interfaces"]) <= states
    limits = {a.name: a.limits[1] for a in load_scene("soft_arm").actuators}
    clamps = {j: one["i_clamp"] for j, one in controller("trajectory")["gains"].items()}
    assert clamps == limits, "the integral part asks for no more than the arm takes"


def test_the_launch_starts_the_arm_with_parameters_it_has_and_controllers_there_are(nodes):
    arm, publisher, manager, *spawners = nodes
    (given,) = arm.parameters
    for name, value in given.items():
        assert ROWS[name].accept(value) == value
    assert given["clock_rate"] > MANAGER["update_rate"]
    assert given["publish_rate"] == MANAGER["update_rate"]
    description = publisher.parameters[0]["robot_description"]
    assert Xml.fromstring(description).get("name") == given["scene"]
    assert manager.parameters == [str(FOLDER / "controllers.yaml")]
    assert [one.arguments[0] for one in spawners] == ["torques", "trajectory"]
    assert CONTROLLERS["/**"]["ros__parameters"]["use_sim_time"] is True


def test_what_the_hardware_of_the_description_sends_moves_the_arm(tmp_path, nodes, peer):
    words = [
        w for name, value in nodes[0].parameters[0].items() for w in ("-p", f"{name}:={value}")
    ]
    program = simulator(tmp_path, *words)
    states = peer.listen(JointState, PARAMETERS["joint_states_topic"])
    publisher = peer.talk(JointState, PARAMETERS["joint_commands_topic"])
    wait_for(lambda: states, "a state")
    assert list(states[-1].name) == JOINTS
    wanted = [0.4, math.nan, -0.3, 0.2, math.nan, 0.1]
    threshold = float(PARAMETERS["trigger_joint_command_threshold"])
    sent, end = 0, time.monotonic() + 1.5  # beyond command_timeout
    while time.monotonic() < end:
        apart = sum(abs(e - w) for e, w in zip(states[-1].effort, wanted, strict=True))
        if not apart <= threshold:  # NaN is never near
            publisher.publish(JointState(name=JOINTS, effort=wanted))
            sent += 1
        time.sleep(1.0 / MANAGER["update_rate"])
    assert sent > 50, "as the hardware does while a joint is not claimed"
    assert list(states[-1].effort) == [0.0 if math.isnan(w) else w for w in wanted]
    assert "refused" not in program.text
    assert program.end() == 0, program.text


def test_the_gains_of_the_trajectory_controller_bring_the_arm_where_it_should_go():
    """A port of the controller's PID with a clamped integral part, at the manager's rate."""
    simulation = Simulation(load_scene("soft_arm"))
    inputs = Inputs(simulation, 1.0, 0.5)
    gains = controller("trajectory")["gains"]
    p, i, d, clamp = (
        np.array([gains[j][key] for j in JOINTS]) for key in ("p", "i", "d", "i_clamp")
    )
    period = 1.0 / MANAGER["update_rate"]
    goal, summed = np.array([0.3, 0.1, 0.2, -0.1, 0.1, 0.1]), np.zeros(len(JOINTS))
    for k in range(round(4.0 / period)):
        position, velocity, _ = simulation.ports()
        share = min(1.0, k * period)
        error = share * goal - position
        summed = np.clip(summed + i * error * period, -clamp, clamp)
        effort = p * error + summed + d * (goal * (share < 1.0) - velocity)
        inputs.take(inputs.effort_order(effort))
        inputs.advance(round(period / simulation.step_ns * 1e9))
    position, velocity, _ = simulation.ports()
    np.testing.assert_allclose(position, goal, atol=0.005)
    assert np.abs(velocity).max() < 0.05
