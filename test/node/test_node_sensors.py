"""Sensors over DDS: standard messages, stamped when measured, recorded, replayed."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from peer import Program, simulator, wait_for
from sensor_msgs.msg import Imu, JointState
from std_srvs.srv import SetBool

from soft_sim_ros.experiments.resimulation import rerun
from soft_sim_ros.recording.reader import read_run

SCENE = Path(__file__).with_name("sensing.yaml")
REPLAY = (
    "-c",
    "import sys; from soft_sim_ros.node.replay import main; sys.exit(main(sys.argv[1:]))",
)
WEIGHT = 1100.0 * np.pi * 0.015**2 * 0.3 * 9.81


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sensing")
    program = simulator(folder, scene=SCENE, record=folder / "run", publish_rate=20.0)
    yield program, folder
    if program.process.poll() is None:
        assert program.end() == 0, program.text


def stamp_ns(message):
    return message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec


def test_each_sensor_has_a_topic_at_its_own_rate_in_the_recording_too(arm, peer):
    program, folder = arm
    units = peer.listen(Imu, "soft_arm/sensors/tip", 1000)
    wrenches = peer.listen(WrenchStamped, "soft_arm/sensors/clamp", 1000)
    strains = peer.listen(JointState, "soft_arm/sensors/gauge", 1000)
    wait_for(lambda: len(units) > 100 and len(strains) > 20, "readings")
    unit = units[-1]
    assert unit.header.frame_id == "soft_arm/sensors/tip"
    # it hangs: its x points down, and it is held up
    force = unit.linear_acceleration
    assert force.x == pytest.approx(-9.81, abs=0.2)
    assert abs(force.y) < 0.2
    assert unit.orientation.y == pytest.approx(np.sqrt(0.5), abs=1e-3)
    assert unit.linear_acceleration_covariance[4] == pytest.approx(0.02**2)
    assert unit.orientation_covariance[0] == 0.0
    times = [stamp_ns(one) for one in list(units)]
    assert set(np.diff(times)) == {5_000_000}
    assert wrenches[-1].header.frame_id == "soft_arm/sensors/clamp"
    assert wrenches[-1].wrench.force.x == pytest.approx(WEIGHT, rel=1e-3)
    gaps = np.diff([stamp_ns(one) for one in list(wrenches)])
    assert set(gaps) <= {16_000_000, 17_000_000}
    assert list(strains[-1].name) == ["strain"]
    assert len(strains[-1].position) == 1
    assert not len(strains[-1].velocity)
    assert set(np.diff([stamp_ns(one) for one in list(strains)])) == {20_000_000}

    peer.ask(SetBool, "soft_arm/pause", SetBool.Request(data=True))
    late = peer.listen(WrenchStamped, "soft_arm/sensors/clamp")
    wait_for(lambda: late, "the newest reading of a paused arm")
    assert program.end() == 0, program.text

    run = read_run(folder / "run")
    tip = run.sensors["tip"]
    assert set(tip.time_ns - tip.measured_ns) == {13_000_000}
    assert run.counts["/soft_arm/sensors/tip"] == len(tip) > 100
    at = tip.measured_ns.tolist().index(times[0])
    assert units[0].linear_acceleration.z == tip["acceleration/z"][at]
    assert len(run.sensors["gauge"]) > 2 * len(run.tip_pose)
    result = rerun(run)
    assert result.identical, result
    read_by_rosbags(folder / "run", tip)


def read_by_rosbags(path, tip):
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store, found = get_typestore(Stores.ROS2_JAZZY), []
    with Reader(path) as bag:
        connections = [c for c in bag.connections if c.topic == "/soft_arm/sensors/tip"]
        for connection, _, data in bag.messages(connections=connections):
            found.append(store.deserialize_cdr(data, connection.msgtype))
    values = [one.linear_acceleration.z for one in found]
    np.testing.assert_array_equal(values, tip["acceleration/z"])
    assert [one.orientation.w for one in found] == tip["orientation/w"].tolist()


def test_a_replay_sends_readings_again(arm, peer):
    program, folder = arm
    if program.process.poll() is None:
        program.end()
    again = Program(folder, REPLAY, str(folder / "run"), "--rate", "0", "--delay", "3")
    units = peer.listen(Imu, "soft_arm/sensors/tip", 10_000)
    assert again.wait(60.0) == 0, again.text
    tip = read_run(folder / "run").sensors["tip"]
    wait_for(lambda: len(units) > 0.9 * len(tip), "most of the readings")
    assert stamp_ns(units[-1]) in tip.measured_ns


def test_readings_in_a_frame_have_that_frame_on_tf(monkeypatch):
    """tf2_msgs comes with ROS, not with its wheels: a stand-in."""
    from soft_sim_ros.core.settled import Simulation
    from soft_sim_ros.node.tip_frame import ArmFrames
    from soft_sim_ros.scene import load_scene

    for name in ("tf2_msgs", "tf2_msgs.msg"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    sys.modules["tf2_msgs.msg"].TFMessage = SimpleNamespace
    heard = []
    node = SimpleNamespace(
        get_fully_qualified_name=lambda: "/left/soft_arm",
        create_publisher=lambda *_, **__: SimpleNamespace(
            publish=heard.append, get_subscription_count=lambda: 1
        ),
    )
    simulation = Simulation(load_scene(SCENE))
    frames = ArmFrames(node, simulation.scene, "world", "", 0, lambda *_: None)
    frames.show(simulation)
    simulation.set_efforts([0.1, 0.2])
    simulation.advance(100)
    frames.send(0)
    found = {t.child_frame_id: t.transform for t in heard[0].transforms}
    assert [name for name in found if "sensors" in name] == [
        "left/soft_arm/sensors/tip", "left/soft_arm/sensors/clamp",
    ]  # fmt: skip
    assert found["left/soft_arm/sensors/tip"] == found["left/soft_arm/tip"]
    clamp = found["left/soft_arm/sensors/clamp"]
    assert (clamp.translation.z, clamp.rotation.y) == pytest.approx((0.5, np.sqrt(0.5)))
