"""What a viewer sees of a running node: the arm with its true thickness, in its place."""

from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import PoseArray, WrenchStamped
from peer import simulator, wait_for
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from visualization_msgs.msg import Marker, MarkerArray

from soft_sim_ros.viewing.outline import FEW
from soft_sim_ros.viewing.tube import triangles

SCENE = Path(__file__).with_name("arm.yaml")
RADIUS, LENGTH = 0.015, 0.3


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    program = simulator(
        tmp_path_factory.mktemp("arm"), scene=SCENE, poses=11, frame_id="plate", publish_rate=50
    )
    yield program
    assert program.end() == 0, program.text


def vector(point):
    return np.array([point.x, point.y, point.z])


def ns(stamp):
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def by_name(message):
    return {(marker.ns, marker.id): marker for marker in message.markers}


def rings(marker):
    """Corners (P, FEW, 3) of the tube that a marker's triangles make up."""
    points = np.array([(p.x, p.y, p.z) for p in marker.points])
    for count in range(2, 200):
        corners = triangles(count, FEW).ravel()
        if len(corners) == len(points):
            found = np.empty((count * FEW, 3))
            found[corners] = points
            return found.reshape(count, FEW, 3)
    raise AssertionError(f"{len(points)} points make no tube")


def test_the_tube_has_the_rods_radius_and_runs_from_the_base_to_the_tip(arm, peer):
    markers = peer.listen(MarkerArray, "soft_arm/markers")
    backbones = peer.listen(PoseArray, "soft_arm/backbone")
    wait_for(lambda: len(markers) > 30 and len(backbones) > 60, "markers and backbones")
    poses = {ns(m.header.stamp): m.poses for m in list(backbones)}
    compared = 0
    for message in list(markers):
        tube = by_name(message)["rods", 0]
        assert tube.header.frame_id == "plate" and tube.type == Marker.TRIANGLE_LIST
        found = poses.get(ns(tube.header.stamp))
        if found is None:
            continue
        compared += 1
        corners = rings(tube)
        middle = corners.mean(axis=1)
        for end, pose in ((0, found[0]), (-1, found[-1])):
            assert middle[end] == pytest.approx(vector(pose.position), abs=1e-12)
        radius = np.linalg.norm(corners - middle[:, None], axis=2)
        assert radius == pytest.approx(RADIUS, rel=1e-9)
    assert compared > 3


def test_names_and_numbers_of_points_never_change_and_stamps_are_simulated_time(arm, peer):
    markers = peer.listen(MarkerArray, "soft_arm/markers")
    wait_for(lambda: len(markers) > 10, "markers")
    seen = list(markers)
    shapes = [{name: len(m.points) for name, m in by_name(message).items()} for message in seen]
    assert all(shape == shapes[0] for shape in shapes)
    assert {("rods", 0), ("external_wrench", 0), ("external_wrench", 1)} <= set(shapes[0])
    stamps = [{ns(marker.header.stamp) for marker in message.markers} for message in seen]
    assert all(len(each) == 1 for each in stamps)
    times = np.array([each.pop() for each in stamps])
    assert (np.diff(times) > 0).all() and (times % 20_000_000 == 0).all()
    assert all(marker.frame_locked for message in seen for marker in message.markers)


def test_a_push_is_an_arrow_from_the_tip_along_the_force_and_goes_with_it(arm, peer):
    markers = peer.listen(MarkerArray, "soft_arm/markers")
    push = peer.talk(WrenchStamped, "soft_arm/external_wrench")
    wait_for(lambda: len(markers) > 3, "markers")

    def arrow():
        return by_name(markers[-1])["external_wrench", 0]

    assert arrow().action == Marker.DELETE
    message = WrenchStamped()
    message.wrench.force.y = 0.2
    push.publish(message)
    wait_for(lambda: arrow().action == Marker.ADD, "an arrow")
    tail, head = (vector(p) for p in arrow().points)
    direction = head - tail
    assert direction[1] > 0.0 and np.abs(direction[[0, 2]]).max() < 1e-9
    assert np.linalg.norm(direction) < 0.4 * LENGTH
    tip = rings(by_name(markers[-1])["rods", 0])[-1].mean(axis=0)
    assert np.linalg.norm(tip - tail) < 0.05
    wait_for(lambda: arrow().action == Marker.DELETE, "the end of the push")


def test_what_never_moves_is_there_for_those_who_come_late(arm, peer):
    late = QoSProfile(
        depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE
    )
    found = []
    peer.node.create_subscription(MarkerArray, "soft_arm/fixed_markers", found.append, late)
    wait_for(lambda: found, "the plate")
    (plate,) = found[0].markers
    assert (plate.ns, plate.id, plate.header.frame_id) == ("base", 0, "plate")
    # it touches the base from behind: the arm leaves it downwards
    assert vector(plate.pose.position) == pytest.approx([0, 0, 0.5 + plate.scale.z / 2], abs=1e-9)


def test_a_paused_arm_is_seen_where_it_stopped(arm, peer):
    markers = peer.listen(MarkerArray, "soft_arm/markers")
    backbones = peer.listen(PoseArray, "soft_arm/backbone")
    wait_for(lambda: len(markers) > 3, "markers")
    assert peer.pause(True).success
    try:
        last = wait_for(
            lambda: (
                backbones
                and markers
                and ns(backbones[-1].header.stamp) == ns(markers[-1].markers[0].header.stamp)
                and markers[-1]
            ),
            "markers of the last state",
        )
        tip = rings(by_name(last)["rods", 0])[-1].mean(axis=0)
        assert tip == pytest.approx(vector(backbones[-1].poses[-1].position), abs=1e-12)
    finally:
        assert peer.pause(False).success


def test_nothing_is_built_while_nobody_listens(monkeypatch):
    from soft_sim_ros.core.settled import Simulation
    from soft_sim_ros.node import markers as module
    from soft_sim_ros.scene import load_scene
    from soft_sim_ros.viewing import scenery

    built = []
    draw = scenery.Scenery.draw

    def counted(self, canvases):
        built.append(self)
        draw(self, canvases)

    monkeypatch.setattr(scenery.Scenery, "draw", counted)
    node = Silent()
    markers = module.Markers(node, "world", 30.0, lambda: True, lambda *_: None)
    markers.show(Simulation(load_scene(str(SCENE))))
    for index in range(5):
        markers.send(index)
    assert not built and markers.sent == 0
    node.listeners = 1
    markers.send(5)
    assert len(built) == 1 and markers.sent == 1


class Silent:
    """A node whose publishers count messages, and listeners as they are told."""

    listeners = 0

    def get_fully_qualified_name(self):
        return "/soft_arm"

    def create_publisher(self, *_, **__):
        return self

    def get_subscription_count(self):
        return self.listeners

    def publish(self, data):
        assert isinstance(data, bytes)
