"""Joint commands as topic-based ros2_control hardware sends them, over DDS and by themselves."""

import math
import time
from pathlib import Path

import numpy as np
import pytest
from peer import simulator, wait_for
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import CommandError
from soft_sim_ros.recording.decode import JointState as Decoded
from soft_sim_ros.recording.orders import joint_message_order
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.scene import load_scene

SCENE = Path(__file__).with_name("arm.yaml")
NAN = math.nan
JOINTS = ["pitch", "yaw"]


class Hardware:
    """What joint_state_topic_hardware_interface does in one cycle of the controller manager."""

    THRESHOLD = 1e-5  # its default

    def __init__(self, peer):
        self.states = peer.listen(JointState, "joint_states", 1000)
        self.publisher = peer.talk(JointState, "soft_arm/joint_command")
        self.sent = 0
        wait_for(lambda: self.states, "a state")

    def cycle(self, **command):
        """Read the newest state; write unless it agrees with the command of all joints."""
        state = dict(zip(self.states[-1].name, self.states[-1].effort, strict=True))
        efforts = [command.get(joint, NAN) for joint in JOINTS]
        far = sum(abs(state[joint] - e) for joint, e in zip(JOINTS, efforts, strict=True))
        if not far <= self.THRESHOLD:
            self.publisher.publish(JointState(name=JOINTS, effort=efforts))
            self.sent += 1

    def run(self, seconds, **command):
        """Cycle at 100 Hz and return the efforts (N, 2) that were heard meanwhile."""
        begin = len(self.states)
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.cycle(**command)
            time.sleep(0.01)
        return np.array([m.effort for m in self.states[begin:]])


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    folder = tmp_path_factory.mktemp("arm")
    program = simulator(
        folder, scene=SCENE, command_timeout=0.3, command_ramp=0.1, record=folder / "run"
    )
    yield program, folder
    if program.process.poll() is None:
        assert program.end() == 0, program.text


def test_ros2_control_hardware_drives_the_arm_and_its_timeouts_begin_when_it_leaves(arm, peer):
    program, folder = arm
    hardware = Hardware(peer)
    events = peer.listen(String, "soft_arm/events")
    # before any controller: all is NaN, which is no command
    assert (hardware.run(0.3) == [0.01, 0.0]).all()
    # one joint is claimed, and follows; the other goes on as it is
    assert (hardware.run(0.5, yaw=0.2)[20:] == [0.01, 0.2]).all()
    # all are claimed: a constant command is sent once and held, though the timeout is 0.3 s
    hardware.sent = 0
    assert (hardware.run(1.2, pitch=0.1, yaw=0.2)[20:] == [0.1, 0.2]).all()
    assert 0 < hardware.sent < 20
    assert not any(m.data.startswith("command_timeout") for m in list(events))
    # the controller is lost: what it asked for ends as every other command does
    peer.node.destroy_publisher(hardware.publisher)
    peer._publishers.remove(hardware.publisher)
    wait_for(lambda: list(hardware.states[-1].effort) == [0.01, 0.0], "the safe efforts")
    told = [m.data for m in list(events)]
    assert told.index("sender_left: ~/joint_command") < told.index("command_timeout: pitch, yaw")
    assert "refused" not in program.text
    assert program.end() == 0, program.text
    from soft_sim_ros.experiments.resimulation import Rerun

    compared = Rerun(read_run(folder / "run")).compare()
    assert compared.identical, compared


@pytest.fixture(scope="module")
def inputs():
    return Inputs(Simulation(load_scene(SCENE)), 0.1, 0.0)


def order_of(inputs, lasting=False, *, name, **fields):
    none: list[float] = []
    arrays = [np.array(fields.get(key, none)) for key in ("position", "velocity", "effort")]
    return joint_message_order(inputs, Decoded(0, "", tuple(name), *arrays), lasting)


@pytest.mark.parametrize(
    ("effort", "channels", "values"),
    [
        ([0.1, 0.2], [0, 1], [0.1, 0.2]),
        ([NAN, 0.2], [1], [0.2]),
        ([0.9, NAN], [0], [0.5]),
        ([NAN, NAN], [], []),
    ],
)
def test_nan_is_no_command_for_that_joint(inputs, effort, channels, values):
    order = order_of(inputs, name=JOINTS, effort=effort)
    assert (order.channels.tolist(), order.values.tolist()) == (channels, values)


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"name": JOINTS, "effort": [0.1]}, "1 efforts for 2 names"),
        ({"name": JOINTS}, "0 efforts for 2 names"),
        ({"name": JOINTS, "effort": [math.inf, NAN]}, "not finite: pitch = inf"),
        ({"name": ["pitch", "roll"], "effort": [0.1, NAN]}, "unknown actuator 'roll'"),
        ({"name": ["yaw", "yaw"], "effort": [NAN, NAN]}, "more than once: yaw"),
        ({"name": JOINTS, "position": [0.1, NAN]}, "positions for pitch: expected efforts"),
        ({"name": JOINTS, "position": [0.1]}, "1 positions for 2 names"),
    ],
)
def test_what_is_no_joint_command_is_refused(inputs, fields, complaint):
    with pytest.raises(CommandError, match=complaint):
        order_of(inputs, **fields)


def test_positions_are_for_winches_and_empty_arrays_say_nothing():
    winches = Inputs(Simulation(load_scene("winch_arm")), 0.1, 0.0)
    names = [a.name for a in winches.simulation.scene.actuators if a.control == "length"][:2]
    for fields in (
        {"position": [0.002, NAN]},
        {"position": [0.002, NAN], "velocity": [NAN, NAN], "effort": [NAN, NAN]},
        {"effort": [0.002, NAN]},
    ):
        order = order_of(winches, name=names, **fields)
        assert order.channels.tolist() == winches.channels(names[:1]).tolist()
        assert order.values.tolist() == [0.002]


def test_a_lasting_order_is_held_until_it_is_released_and_then_for_the_timeout(inputs):
    inputs.reset()
    inputs.take(order_of(inputs, lasting=True, name=["pitch"], effort=[0.2]))
    inputs.take(order_of(inputs, lasting=False, name=["yaw"], effort=[0.3]))
    efforts = lambda: inputs.simulation.ports()[2].tolist()  # noqa: E731
    inputs.advance(300)
    assert efforts() == [0.2, 0.0]
    inputs.take(inputs.released())
    assert inputs.released() is None
    inputs.advance(100)
    assert efforts() == [0.2, 0.0]
    inputs.advance(2)
    assert efforts() == [0.01, 0.0]
