"""A finite command that no arm can follow is cut, and taken back if need be: it stops no arm."""

from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from peer import simulator, wait_for
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String

from soft_sim_ros.core.accuracy.watch import WatchedInputs
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.bounds import Bounds
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import Diverged
from soft_sim_ros.experiments.resimulation import Rerun
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.scene import load_scene, packaged_scenes, parse_scene

FILE = Path(__file__).with_name("arm.yaml")
SCENE = load_scene(FILE)
# yaw has no limits of its own
FREE = FILE.read_text().replace("strain: bend_z, limits: [-0.5, 0.5]}", "strain: bend_z}")
SIZES = [1e308, 1e200, 1e20, 1e6]


def bounds():
    return Bounds.of_arm(SCENE, 0.3)


@pytest.mark.parametrize("name", packaged_scenes())
def test_every_arm_has_bounds_that_are_finite_and_hold_its_limits(name):
    scene = load_scene(name)
    found = Bounds.of_arm(scene, 1.0)
    assert 0.0 < found.force < np.inf and 0.0 < found.moment < np.inf
    for (low, high), actuator in zip(found.efforts, scene.actuators, strict=True):
        assert -np.inf < low <= actuator.safe <= high < np.inf
        for mine, given in ((low, actuator.limits[0]), (high, actuator.limits[1])):
            assert mine == given or not np.isfinite(given)


def test_the_bounds_are_those_of_the_manual():
    # a round rubber arm: E, radius and density of arm.yaml, by hand
    area, inertia = np.pi * 0.015**2, np.pi * 0.015**4 / 4.0
    weight = 1100.0 * area * 0.3 * 9.81
    found = bounds()
    assert found.force == pytest.approx(max(0.1 * 5e5 * area, 10.0 * weight), rel=1e-9)
    assert found.moment == pytest.approx(10.0 * 5e5 * inertia / 0.3, rel=1e-9)
    set_by_hand = Bounds.of_arm(SCENE, 0.3, moment=2.0, force=3.0)
    assert (set_by_hand.moment, set_by_hand.force) == (2.0, 3.0)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("direction", [(1, 0, 0), (0, -1, 0), (1, 1, 1), (3, -4, 0)])
def test_a_wrench_is_cut_to_its_bounds_and_keeps_its_direction(size, direction):
    unit = np.array(direction) / np.linalg.norm(direction)
    wrench = np.concatenate([0.5 * size * unit, size * unit / np.abs(unit).max()])
    cut, said = bounds().cut(wrench)
    assert np.linalg.norm(cut[:3]) == pytest.approx(bounds().moment)
    assert np.linalg.norm(cut[3:]) == pytest.approx(bounds().force)
    assert cut[3:] / bounds().force == pytest.approx(unit)
    assert len(said) == 2 and "cut to" in said[0] and "N·m" in said[0]


def test_a_wrench_inside_its_bounds_is_not_touched():
    wrench = np.array([0.1, -0.2, 0.0, 1.0, -2.0, 3.0])
    cut, said = bounds().cut(wrench)
    assert cut.tobytes() == wrench.tobytes() and said == ()


def test_what_a_recording_says_of_the_bounds_is_what_was_in_force():
    found = bounds()
    again = Bounds.recorded(SCENE, found.facts())
    assert again.efforts.tobytes() == found.efforts.tobytes()
    assert (again.moment, again.force) == (found.moment, found.force)
    assert Bounds.recorded(SCENE, {}).force == np.inf, "as before there were any"
    for text in ("[[1]]", "[[NaN, 1], [0, 1]]", '"x"', "{"):
        with pytest.raises(ValueError, match="effort_limits"):
            Bounds.recorded(SCENE, {"effort_limits": text})
    for name in ("moment_limit", "force_limit"):
        for text in ("x", "nan", "-1", ""):
            with pytest.raises(ValueError, match=name):
                Bounds.recorded(SCENE, {name: text})


class Stubborn(Simulation):
    """Gives up while it is pushed by more than 1 N or N·m."""

    def advance(self, steps):
        if np.abs(self._held.tip).max() > 1.0:
            super().advance(min(steps, 3))
            raise Diverged(self.time, "made to fail by the test")
        super().advance(steps)


def test_withdrawing_drops_the_wrench_first_then_the_efforts_and_then_nothing():
    arm = Simulation(SCENE)
    inputs = Inputs(arm, 0.0, 0.0)
    inputs.command([0.2, 0.0])
    inputs.wrench([0.0, 0.0, 0.0, 0.1, 0.0, 0.0], "tip")
    inputs.advance(5)
    assert inputs.withdraw() == ["~/external_wrench"]
    assert tuple(arm.ports()[2]) == (0.2, 0.0)
    assert inputs.withdraw() == ["pitch"]
    assert tuple(arm.ports()[2]) == (0.01, 0.0)
    assert inputs.withdraw() == []


def test_a_failed_attempt_leaves_no_bit_behind_when_its_command_is_withdrawn():
    def run(arm, fails):
        inputs = Inputs(arm, 1.0, 0.5)
        inputs.command([0.3, -0.2])
        inputs.advance(7)
        inputs.wrench([0.0, 0.0, 0.0, 2.0, 0.0, 1.0])
        if fails:
            with pytest.raises(Diverged):
                inputs.advance(8)
        else:  # as a re-simulation does
            inputs.advance(3)
            inputs.update()
        assert inputs.withdraw() == ["~/external_wrench"]
        inputs.advance(50)
        return arm.q.tobytes(), arm.v.tobytes(), arm.ledger().tobytes()

    assert run(Stubborn(SCENE), True) == run(Simulation(SCENE), False)


def test_the_companion_of_a_watched_run_goes_along_when_a_command_is_withdrawn():
    text = FILE.read_text()
    text = text[: text.index("numerics:")] + "numerics: {step: 0.002, tolerance: 0.01}\n"
    from soft_sim_ros.core.accuracy.contract import choose

    inputs = WatchedInputs(Stubborn(choose(parse_scene(text)).scene), 0.0, 0.0)
    inputs.advance(4)
    inputs.wrench([0.0, 0.0, 0.0, 2.0, 0.0, 0.0])
    with pytest.raises(Diverged):
        inputs.advance(8)
    assert inputs.withdraw() == ["~/external_wrench"]
    inputs.advance(20)
    assert inputs.companion.step_index == inputs.simulation.step_index
    assert inputs.error_rel < 0.05


@pytest.fixture(scope="module")
def node(tmp_path_factory):
    folder = tmp_path_factory.mktemp("absurd")
    scene = folder / "free.yaml"
    scene.write_text(FREE)
    program = simulator(folder, scene=scene, record=folder / "run", command_timeout=0.5)
    program.folder = folder
    yield program
    program.end()


def wrench(size, frame):
    message = WrenchStamped()
    message.header.frame_id = frame
    for vector in (message.wrench.force, message.wrench.torque):
        vector.x, vector.y, vector.z = size, -size, size
    return message


def test_no_finite_command_stops_the_arm(node, peer):
    push = peer.talk(WrenchStamped, "soft_arm/external_wrench")
    command = peer.talk(Float64MultiArray, "soft_arm/command")
    joint = peer.talk(JointState, "soft_arm/joint_command")
    states = peer.listen(JointState, "joint_states", 1000)
    events = peer.listen(String, "soft_arm/events", 1000)
    diagnostics = peer.listen(DiagnosticArray, "/diagnostics")

    def stamp():
        return states[-1].header.stamp.sec + 1e-9 * states[-1].header.stamp.nanosec

    wait_for(lambda: states, "a state")
    for size in SIZES[:2]:
        for publisher, message in (
            (push, wrench(size, "world")),
            (push, wrench(-size, "tip")),
            (command, Float64MultiArray(data=[size, -size])),
            (joint, JointState(name=["yaw"], effort=[size])),
        ):
            before = stamp()
            publisher.publish(message)
            wait_for(lambda b=before: stamp() > b + 0.6, "the arm to go on", 30.0)
    assert not [e.data for e in list(events) if e.data.startswith("diverged")]
    assert "N cut to" in node.text and "yaw = 1e+308 cut to" in node.text
    assert "Traceback" not in node.text and "RuntimeWarning" not in node.text
    before = stamp()
    wait_for(lambda: stamp() > before + 1.2, "calm", 30.0)
    count = len(diagnostics)
    status = wait_for(lambda: diagnostics[count + 1 :], "news")[-1].status[0]
    assert status.level != status.ERROR, status.message


def test_a_recording_of_it_is_simulated_again_to_the_same_bits(node):
    assert node.end() == 0, node.text
    run = read_run(node.folder / "run")
    assert float(run.metadata["force_limit"]) == bounds().force
    comparison = Rerun(run).compare()
    assert comparison.messages > 100
    assert comparison.different == 0, comparison
