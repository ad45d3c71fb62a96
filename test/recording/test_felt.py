"""What an arm feels is recorded: reactions of constraints and contacts, for us and for others."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from soft_sim_ros.batch.rollout import Rollout
from soft_sim_ros.commands.felt import felt_lines
from soft_sim_ros.core.mechanics.contacts import resultants
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import RecordingError
from soft_sim_ros.experiments.resimulation import rerun
from soft_sim_ros.recording.cloud import FIELDS, CloudBuffer
from soft_sim_ros.recording.decode import DecodeError, decode
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.recording.topics import CLOUD, recorded_topics
from soft_sim_ros.recording.writer import BagWriter
from soft_sim_ros.scene import load_scene
from soft_sim_ros.scene.limbs import Limbs, limbs_of

SECTION = {"name": "all", "length": 0.3, "material": "rubber",
           "cross_section": {"shape": "circle", "radius": 0.01}}  # fmt: skip
DOCUMENT = {
    "name": "felt",
    "materials": {"rubber": {"young_modulus": 1e6, "poisson_ratio": 0.45, "density": 1100.0,
                             "viscosity": 2e3}},
    "bodies": [{"rod": "arm", "strains": ["bend_y"], "sections": [SECTION]}],
    "environment": [{"plane": "table", "position": [0, 0, -0.02], "contact": {"friction": 0.4}},
                    {"plane": "far_away", "position": [0, 0, -9.0]}],
    # one is released in the run, the other is made in it where the tip is then
    "constraints": [{"name": "held", "kind": "plane", "axis": [0, 0, 1], "end": 0.02,
                     "frames": [{"body": "arm"}]},
                    {"name": "caught", "kind": "plane", "axis": [0, 0, 1], "start": 0.105,
                     "frames": [{"body": "arm", "s": 0.15}]}],
    "numerics": {"step": 0.001, "basis": {"order": 3}},
}  # fmt: skip
TIME = 0.15


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("felt") / "felt.yaml"
    path.write_text(yaml.safe_dump(DOCUMENT))
    return load_scene(path)


@pytest.fixture(scope="module")
def folder(scene, tmp_path_factory):
    """Give a recording of a rod that is let go above a table, and caught again."""
    folder = tmp_path_factory.mktemp("felt") / "run"
    Rollout(scene, folder, space=False).run(TIME)
    return folder


@pytest.fixture(scope="module")
def run(folder):
    return read_run(folder)


@pytest.fixture(scope="module")
def states(scene, run):
    """Give what Python says of the recorded instants."""
    simulation, found = Simulation(scene), []
    for time_ns in run.contacts.time_ns.tolist():
        simulation.advance(time_ns // simulation.step_ns - simulation.step_index)
        found.append((simulation.contacts(), simulation.reactions()))
    return found


def test_reactions_are_recorded_as_python_tells_them(run, states):
    assert list(run.reactions) == ["held", "caught"]
    for name, series in run.reactions.items():
        assert series.frame_id == "world"
        told = [np.concatenate([r[name].moment, r[name].force]) for _, r in states]
        np.testing.assert_array_equal(series.wrench, told)
    held, caught = run.reactions["held"], run.reactions["caught"]
    assert (held.force[held.time < 0.019, 2] > 0.01).all()  # carries weight until it lets go
    assert not held.force[held.time > 0.021].any()
    assert not caught.force[caught.time < 0.105].any()
    assert np.abs(caught.force[caught.time > 0.11]).max() > 1e-3


def test_contacts_are_recorded_as_python_tells_them(run, states):
    series = run.contacts
    contacts = [contact for found, _ in states for contact in found]
    assert len(contacts) > 10
    assert len(contacts) == len(series.at)
    assert np.bincount(series.at, minlength=len(series)).tolist() == [len(c) for c, _ in states]
    for name in ("s", "gap", "normal_force", "point", "normal", "friction", "slip"):
        told = np.array([getattr(contact, name) for contact in contacts])
        np.testing.assert_allclose(getattr(series, name), told, rtol=1e-6, atol=1e-12)
    assert series.sticks.tolist() == [contact.sticks for contact in contacts]
    assert series.pairs == (("arm", "table"),)
    wrench = series.resultant("arm", "table")
    for found, (told, _) in zip(wrench, states, strict=True):
        expected = resultants(told).get(("arm", "table"), np.zeros(6))
        np.testing.assert_allclose(found, expected, atol=2e-6)
    assert not series.resultant("arm", "far_away").any()


def test_others_read_contacts_and_reactions(folder, run):
    """With the package rosbags, from the definitions inside the recording."""
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store, rows, forces = get_typestore(Stores.ROS2_JAZZY), 0, []
    with Reader(folder) as bag:
        for connection, _, data in bag.messages():
            if connection.topic == "/soft_arm/contacts":
                message = store.deserialize_cdr(data, connection.msgtype)
                assert (message.height, message.is_bigendian) == (1, False)
                assert message.row_step == message.width * message.point_step == len(message.data)
                kinds = {4: "<u2", 7: "<f4", 2: "u1"}
                own = np.dtype({
                    "names": [field.name for field in message.fields],
                    "formats": [kinds[field.datatype] for field in message.fields],
                    "offsets": [field.offset for field in message.fields],
                    "itemsize": message.point_step,
                })  # fmt: skip
                points = np.frombuffer(message.data, own)
                part = slice(rows, rows + len(points))
                np.testing.assert_array_equal(points["z"], run.contacts.point[part, 2])
                np.testing.assert_array_equal(
                    points["normal_force"], run.contacts.normal_force[part]
                )
                rows += len(points)
            elif connection.topic == "/soft_arm/reaction/held":
                message = store.deserialize_cdr(data, connection.msgtype)
                forces.append(message.wrench.force.z)
    assert rows == len(run.contacts.at) > 0
    assert forces == run.reactions["held"].force[:, 2].tolist()


@pytest.mark.parametrize("integrator", ["sdirk2", "adaptive"])
def test_a_run_with_latches_and_contact_is_the_same_bit_by_bit(integrator, run, tmp_path):
    if integrator != "sdirk2":
        numerics = DOCUMENT["numerics"] | {"integrator": integrator}
        path = tmp_path / "other.yaml"
        path.write_text(yaml.safe_dump(DOCUMENT | {"numerics": numerics}))
        Rollout(load_scene(path), tmp_path / "run", space=False).run(TIME)
        run = read_run(tmp_path / "run")
        assert run.reactions["held"].force[0, 2] > 0.01
        assert len(run.contacts.at) > 10
    found = rerun(run)
    assert found.identical
    assert found.messages == sum(
        count for topic, count in run.counts.items() if "events" not in topic
    )


def test_a_scene_without_any_has_no_such_topics():
    topics = {one.key for one in recorded_topics("/arm", limbs_of(load_scene("soft_arm")))}
    assert not topics & {"contacts", "reaction"}


def test_what_is_no_cloud_of_contacts_is_refused(tmp_path):
    cloud = CloudBuffer("world", ["arm"], ["table"]).fill(5, [])
    assert len(decode(CLOUD, cloud).points) == 0
    for at in range(4, len(cloud)):  # cut anywhere, it is an error, not a surprise
        with pytest.raises(DecodeError):
            decode(CLOUD, cloud[:at])
    other = cloud.replace(b"normal_force\0", b"normal_farce\0")
    with pytest.raises(DecodeError, match="normal_force"):
        decode(CLOUD, other)
    limbs = Limbs(touches=True, bodies=("arm",), shapes=("table",))
    with BagWriter(tmp_path / "run", recorded_topics("/arm", limbs)) as writer:
        writer.write("contacts", 0, other)
    with pytest.raises(RecordingError, match="normal_force"):
        read_run(tmp_path / "run").contacts  # noqa: B018
    assert len({name for name, _, _ in FIELDS}) == len(FIELDS)


def test_bodies_that_touch_one_another_without_any_surroundings_are_recorded_too(tmp_path):
    """A ball that lies on another one."""
    ball = {"kind": "sphere", "radius": 0.05}
    document = {
        "name": "balls",
        "bodies": [
            {"rigid_body": "below", "mass": 1.0, "inertia": [1e-3] * 3, "shape": ball},
            {"joint": "slide", "kind": "prismatic", "axis": [0, 0, 1], "parent": "base"},
            {"rigid_body": "above", "mass": 0.2, "inertia": [1e-4] * 3, "shape": ball},
        ],
        "initial": {"positions": {"slide": 0.0999}},
        "contact": {"stiffness": 1e5, "dissipation": 5.0},
        "pairs": [{"bodies": ["below", "above"]}],
        "numerics": {"step": 0.001},
    }
    path = tmp_path / "balls.yaml"
    path.write_text(yaml.safe_dump(document))
    rollout = Rollout(load_scene(path), tmp_path / "run", space=False)
    rollout.run(0.5)
    lines = list(felt_lines(rollout.simulation.scene, {}, rollout.simulation.contacts()))
    assert len(lines) == 1 and "points 1" in lines[0]
    recorded = read_run(tmp_path / "run").contacts
    up, down = (recorded.resultant(*pair)[-1] for pair in (("above", "below"), ("below", "above")))
    assert up[5] == pytest.approx(0.2 * 9.81, rel=1e-3)
    np.testing.assert_array_equal(up, -down)
