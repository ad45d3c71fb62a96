"""Shapes of arms: true sizes, in their places, against volumes and lengths known otherwise."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.recording.cdr_markers import MarkerArrayBuffer
from soft_sim_ros.scene import load_scene, packaged_scenes, parse_scene
from soft_sim_ros.scene.actuator import TendonActuator
from soft_sim_ros.viewing.outline import FEW
from soft_sim_ros.viewing.scenery import Scenery
from soft_sim_ros.viewing.shapes import REMOVED, SHOWN, ramp
from soft_sim_ros.viewing.tube import rotations, triangles

POLYGON = FEW / 2 * np.sin(2 * np.pi / FEW)  # area of the outline of a unit circle
ROD = """
name: rod
gravity: [0, 0, 0]
materials: {{m: {{young_modulus: 1.0e+6, poisson_ratio: 0.5, density: 1000.0}}}}
bodies:
  - rod: arm
    sections:
      - {{name: a, length: 0.4, material: m, cross_section: {shape}}}
{more}
numerics: {{step: 0.001}}
"""


def drawn(simulation):
    """Draw a simulation; return its canvases by group and number."""
    scenery = Scenery(simulation)
    shapes = [part.shape for part in scenery.parts]
    message = MarkerArrayBuffer(
        "world", [(s.group, s.number, s.kind, s.scale, s.colour, s.points) for s in shapes]
    )
    scenery.draw(message.slates)
    names = [(s.group, s.number) for s in shapes]
    assert len(set(names)) == len(names)
    return dict(zip(names, message.slates, strict=True))


def volume(points):
    """Volume of a closed surface of triangles (3 T, 3) that are seen counter-clockwise outside."""
    a, b, c = points.reshape(-1, 3, 3).transpose(1, 0, 2)
    return float(np.einsum("ti,ti->", a, np.cross(b, c))) / 6.0


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ("{shape: circle, radius: 0.02}", POLYGON * 0.02**2 * 0.4),
        # a cone cut off
        (
            "{shape: circle, radius: [0.03, 0.01]}",
            POLYGON * (0.03**2 + 0.03 * 0.01 + 0.01**2) / 3 * 0.4,
        ),
        ("{shape: annulus, outer: 0.02, inner: 0.015}", POLYGON * 0.02**2 * 0.4),
        ("{shape: rectangle, width_y: 0.05, width_z: 0.01}", 0.05 * 0.01 * 0.4),
        ("{shape: ellipse, semi_axis_y: 0.03, semi_axis_z: 0.01}", POLYGON * 0.03 * 0.01 * 0.4),
    ],
)
def test_a_tube_encloses_the_volume_of_its_rod_with_its_outside_out(shape, expected):
    simulation = Simulation(parse_scene(ROD.format(shape=shape, more="")))
    assert volume(drawn(simulation)["rods", 0].points) == pytest.approx(expected, rel=1e-9)


def test_a_broad_rod_is_broad_along_y():
    shape = "{shape: rectangle, width_y: 0.05, width_z: 0.01}"
    points = drawn(Simulation(parse_scene(ROD.format(shape=shape, more=""))))["rods", 0].points
    assert np.ptp(points, axis=0) == pytest.approx([0.4, 0.05, 0.01])


def test_the_edges_of_a_tube_are_each_in_two_triangles_once_in_each_direction():
    found = triangles(5, FEW)
    edges = {(a, b) for t in found.tolist() for a, b in zip(t, t[1:] + t[:1], strict=True)}
    assert len(edges) == 3 * len(found)
    assert all((b, a) in edges for a, b in edges)


def test_rotations_are_those_of_the_quaternions():
    turns = Rotation.random(50, random_state=3)
    assert rotations(turns.as_quat()) == pytest.approx(turns.as_matrix(), abs=1e-14)


@pytest.mark.parametrize("name", ["tendon_arm", "winch_arm"])
def test_a_tendon_is_drawn_as_long_as_the_model_says_it_is(name):
    simulation = Simulation(load_scene(name))
    simulation.set_efforts([0.01 * min(a.limits[1], 1e3) for a in simulation.scene.actuators])
    simulation.advance(100)
    canvases = drawn(simulation)
    shorter = simulation.ports()[0]
    tendons = [a for a in simulation.scene.actuators if isinstance(a, TendonActuator)]
    assert tendons
    for number, actuator in enumerate(simulation.scene.actuators):
        if actuator in tendons:
            points = canvases["tendons", number].points
            length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
            rest = simulation.model.tendon_rest[number]
            # a line of 16 pieces per turn is shorter than the helix by 0.6 % at most
            assert length == pytest.approx(rest - shorter[number], rel=8e-3)
            assert length < rest - shorter[number] + 1e-4 * rest


def test_colours_go_from_slack_to_full_and_stay_colours():
    shares = [-np.inf, -1.0, 0.0, 0.25, 0.5, 1.0, 7.0, np.inf]
    colours = np.array([ramp(share) for share in shares])
    assert ((colours >= 0.0) & (colours <= 1.0)).all()
    assert (np.diff(colours[2:6, 0]) != 0).all()
    assert (colours[5] == colours[7]).all()


def test_a_load_is_an_arrow_while_its_schedule_lets_it_act():
    load = (
        "loads: [{point: push, body: arm, s: 0.4, force: [0, 0, 3.0], "
        "schedule: {start: 0.01, end: 0.02}}]"
    )
    text = ROD.format(shape="{shape: circle, radius: 0.02}", more=load)
    simulation = Simulation(parse_scene(text))
    arrow = drawn(simulation)["loads", 0]
    assert arrow.action[0] == REMOVED
    simulation.advance(15)
    arrow = drawn(simulation)["loads", 0]
    assert arrow.action[0] == SHOWN
    tip = simulation.sampler(2).poses()[-1, :3]
    assert arrow.points[0] == pytest.approx(tip, abs=1e-12)
    direction = arrow.points[1] - arrow.points[0]
    assert direction[2] > 0.0 and np.abs(direction[:2]).max() < 1e-12


@pytest.mark.parametrize("name", sorted(packaged_scenes()))
def test_every_scene_of_the_package_can_be_drawn(name):
    simulation = Simulation(load_scene(name))
    for canvas in drawn(simulation).values():
        assert np.isfinite(canvas.points).all() and np.isfinite(canvas.pose).all()
        assert np.linalg.norm(canvas.pose[3:]) == pytest.approx(1.0, abs=1e-9)


def test_a_motor_lies_along_its_joints_axis_and_a_body_at_its_centre():
    text = """
name: two
gravity: [0, 0, 0]
materials: {}
bodies:
  - {joint: hip, kind: revolute, axis: [0, 1, 0], offset: {position: [0.1, 0, 0]}}
  - rigid_body: block
    mass: 2.0
    inertia: [0.01, 0.02, 0.02]
    com: {position: [0.3, 0, 0]}
numerics: {step: 0.001}
"""
    simulation = Simulation(parse_scene(text))
    simulation.set_state([0.5], [0.0])
    canvases = drawn(simulation)
    motor = canvases["joints", 0].pose
    assert motor[:3] == pytest.approx([0.1, 0, 0])
    assert Rotation.from_quat(motor[3:]).apply([0, 0, 1]) == pytest.approx([0, 1, 0], abs=1e-12)
    centre = [0.1 + 0.3 * np.cos(0.5), 0.0, -0.3 * np.sin(0.5)]
    assert canvases["bodies", 1].pose[:3] == pytest.approx(centre, abs=1e-12)


def test_the_bytes_are_what_ros_reads_and_writes():
    serialization = pytest.importorskip("rclpy.serialization", reason="no ROS 2 here")
    from visualization_msgs.msg import MarkerArray

    scenery = Scenery(Simulation(load_scene("mixed_chain")))
    shapes = [part.shape for part in scenery.parts]
    message = MarkerArrayBuffer(
        "plate", [(s.group, s.number, s.kind, s.scale, s.colour, s.points) for s in shapes]
    )
    scenery.draw(message.slates)
    data = message.bytes(3_000_000_017)
    read = serialization.deserialize_message(data, MarkerArray)
    for shape, slate, marker in zip(shapes, message.slates, read.markers, strict=True):
        assert (marker.ns, marker.id, marker.type) == (shape.group, shape.number, shape.kind)
        assert (marker.header.stamp.sec, marker.header.stamp.nanosec) == (3, 17)
        assert (marker.header.frame_id, marker.frame_locked) == ("plate", True)
        scale = marker.scale
        assert (scale.x, scale.y, scale.z) == shape.scale
        colour = marker.color
        assert [colour.r, colour.g, colour.b, colour.a] == slate.colour.tolist()
        pose = [marker.pose.position.x, marker.pose.position.y, marker.pose.position.z]
        assert pose == slate.pose[:3].tolist()
        assert [(p.x, p.y, p.z) for p in marker.points] == [tuple(p) for p in slate.points.tolist()]
        assert not marker.colors and not marker.text and not marker.mesh_resource
    assert len(serialization.serialize_message(read)) == len(data)


def test_viewing_knows_no_ros():
    folder = Path(__file__).parents[2] / "soft_sim_ros" / "viewing"
    for file in folder.glob("*.py"):
        assert "rclpy" not in file.read_text() and "_msgs.msg" not in file.read_text()
