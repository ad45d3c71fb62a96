"""Pages, pictures, markers, frames and the URDF show every branch of a forest in its place."""

from __future__ import annotations

import json
import re
import sys
import xml.etree.ElementTree as Xml
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from branched import NAMES
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.report import picture, write_report
from soft_sim_ros.report.shapes import shapes_of
from soft_sim_ros.scene import parse_scene
from soft_sim_ros.viewing.frames import Frames
from soft_sim_ros.viewing.recorded import recorded_tubes
from soft_sim_ros.viewing.scenery import Scenery, plates
from soft_sim_ros.viewing.tube import around, rotations
from soft_sim_ros.viewing.urdf import PIECES, Urdf

RADII = {
    "two_arms": [0.02, 0.03], "palm": [0.008] * 3, "ring": [0.02, 0.015, 0.01],
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_tubes_of_a_recording_follow_their_own_backbones(scenes, recorded, name):
    shapes = shapes_of(read_run(recorded[name]))
    counts = {limb: p.stop - p.start for limb, p in zip(shapes.names, shapes.parts, strict=True)}
    tubes = recorded_tubes(scenes[name], counts, 1.0)
    rods = [tube for tube in tubes if tube.actuator is None]
    covered = sorted(i for tube in rods for i in tube.at)
    assert covered == list(range(shapes.poses.shape[1])), "each pose lies on one rod"
    for tube, radius in zip(rods, RADII[name], strict=True):
        assert sum(set(tube.at) <= set(range(p.start, p.stop)) for p in shapes.parts) == 1
        poses = shapes.poses[-1, list(tube.at)]
        corners = around(poses[:, :3], rotations(poses[:, 3:]), tube.rings)
        distance = np.linalg.norm(corners - poses[:, None, :3], axis=2)
        np.testing.assert_allclose(distance, radius, rtol=1e-9)


def test_the_page_plays_all_backbones_and_tells_of_all_tips(recorded, tmp_path):
    page = write_report(recorded["palm"], tmp_path / "page.html").read_text()
    meta = json.loads(re.search(r'id="view-meta">(.*?)</script>', page)[1])
    run = read_run(recorded["palm"])
    assert [trail[-3:] for trail in meta["trails"]] == [
        pytest.approx(series.positions[-1, -1].tolist(), abs=1e-5)
        for series in run.backbones.values()
    ]
    indices = [i for tube in meta["tubes"] for i in tube["at"]]
    assert sorted(set(indices)) == list(range(meta["poses"]))
    for name in ("index", "middle", "thumb"):
        assert f"<h2>Tip {name}</h2>" in page and f"<th>Tip {name} at the end</th>" in page
    assert picture(recorded["palm"], tmp_path / "motion.png").stat().st_size > 10_000


def test_a_page_of_lost_messages_shows_the_instants_that_all_backbones_have(recorded):
    run = read_run(recorded["two_arms"])
    left = run.backbones["left"]
    run.backbones["left"] = type(left)(left.time_ns[2:], left.frame_id, left.poses[2:])
    shapes = shapes_of(run)
    right = run.backbones["right"]
    np.testing.assert_array_equal(shapes.time_ns, right.time_ns[2:])
    np.testing.assert_array_equal(shapes.poses[:, shapes.parts[1]], right.poses[2:])


class Canvas:
    def __init__(self, points):
        self.pose, self.points = np.zeros(7), np.zeros((points, 3))
        self.colour, self.action = np.zeros(4, np.float32), np.zeros(1, np.int32)


@pytest.mark.parametrize("name", NAMES)
def test_markers_have_a_tube_for_each_rod_where_it_is(moved, name):
    simulation = moved[name]
    scenery = Scenery(simulation)
    canvases = [Canvas(part.shape.points) for part in scenery.parts]
    scenery.draw(canvases)
    tubes = [
        canvas.points
        for part, canvas in zip(scenery.parts, canvases, strict=True)
        if part.shape.group == "rods"
    ]
    rods = simulation.compiled.chain.rods
    for points, rod, radius in zip(tubes, rods.values(), RADII[name], strict=True):
        ends = Frames(simulation.compiled, simulation.q, [(rod.rod.name, 0.0)]).poses()[0, :3]
        nearest = np.linalg.norm(points - ends, axis=1).min()
        assert nearest == pytest.approx(radius, rel=1e-6), "its first ring is around its start"


HELD = """
name: held
materials: {soft: {young_modulus: 1.0e6, shear_modulus: 3.4e5, density: 1000.0}}
numerics: {basis: {order: {bend_y: 1}}, step: 1.0e-3}
bodies:
  - {rod: one, sections: &rod [{name: s, length: 0.2, material: soft,
     cross_section: {shape: circle, radius: 0.03}}]}
  - {rod: two, parent: {body: base, offset: {position: [0, 0.4, 0], rpy: [0, 0, 0.5]}},
     sections: *rod}
  - {rod: three, parent: {body: base, offset: {rpy: [0, 0, 0.0]}}, sections: *rod}
  - {joint: loose, kind: free, parent: base}
  - {rod: four, sections: *rod}
"""


def test_each_place_that_holds_an_arm_has_its_plate(moved):
    thick = 0.2 * 0.03
    found = [pose for _, pose in plates(moved["two_arms"])]
    expected = [[-thick, 0.0, 0.0], [-thick, 0.4, 0.0]]
    np.testing.assert_allclose([pose[:3] for pose in found], expected, atol=1e-12)
    assert len(plates(moved["palm"])) == len(plates(moved["ring"])) == 1
    first, second = plates(Simulation(parse_scene(HELD, "held.yaml")))
    assert (first[0].number, second[0].number) == (0, 1)
    axis = np.array([np.cos(0.5), np.sin(0.5), 0.0])
    np.testing.assert_allclose(first[1][:3], [-thick, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(second[1][:3], [0, 0.4, 0] - thick * axis, atol=1e-12)
    upright = Rotation.from_quat(second[1][3:]).apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(upright, axis, atol=1e-12)


def tree_of(simulation):
    return Xml.fromstring(Urdf(simulation.compiled).build())


def parents(tree):
    return {
        j.find("child").get("link"): j for j in tree.findall("joint") if j.find("child") is not None
    }


def pose_of(tree, link, positions):
    """Return the pose (4, 4) of a link in the root link."""
    above, pose = parents(tree), np.eye(4)
    while link in above:
        joint, step = above[link], np.eye(4)
        origin = {k: np.array(v.split(), float) for k, v in joint.find("origin").items()}
        step[:3, :3] = Rotation.from_euler("xyz", origin["rpy"]).as_matrix()
        step[:3, 3] = origin["xyz"]
        if joint.get("type") == "continuous":
            axis = np.array(joint.find("axis").get("xyz").split(), float)
            turn = Rotation.from_rotvec(positions.get(joint.get("name"), 0.0) * axis)
            step[:3, :3] = step[:3, :3] @ turn.as_matrix()
        pose, link = step @ pose, joint.find("parent").get("link")
    return pose


@pytest.mark.parametrize("name", NAMES)
def test_links_hang_on_their_true_parents(scenes, name):
    simulation = Simulation(scenes[name])
    tree = tree_of(simulation)
    links = [link.get("name") for link in tree.findall("link")]
    assert len(set(links)) == len(links)
    assert sorted([*parents(tree), "world"]) == sorted(links), "it is one tree"
    held = {link: joint.find("parent").get("link") for link, joint in parents(tree).items()}
    expected = {
        "two_arms": {"left_0": "shoulder", "other": "base_link", "right_0": "other"},
        "palm": {"palm": "wrist", "index_0": "palm", "middle_0": "palm", "thumb_0": "palm"},
        "ring": {
            "leaf_0": "stem_end",
            "twig_0": f"stem_{int(0.25 / 0.4 * PIECES)}",
            "ring": f"stem_{int(0.1 / 0.4 * PIECES)}",
        },
    }[name]
    assert {link: held[link] for link in expected} == expected
    assert held["tip_link"] == {"two_arms": "right_end", "palm": "thumb_end", "ring": "ring"}[name]


@pytest.mark.parametrize(
    ("name", "joint"), [("two_arms", "turn"), ("palm", "wrist"), ("ring", None)]
)
def test_a_joint_moves_what_hangs_on_it_and_nothing_else(scenes, name, joint):
    simulation = Simulation(scenes[name])
    tree = tree_of(simulation)
    q = np.zeros(simulation.n_coordinates)
    if joint:
        own = {"turn": "other", "wrist": "wrist"}[joint]
        q[simulation.coordinate_names.index(own)] = 0.7
    for rod in simulation.compiled.chain.rods.values():
        frames = Frames(simulation.compiled, q, [(rod.rod.name, rod.rod.length)])
        expected = frames.poses()[0]
        found = pose_of(tree, f"{rod.rod.name}_end", {joint: 0.7})
        np.testing.assert_allclose(found[:3, 3], expected[:3], atol=1e-7)
        turn = Rotation.from_quat(expected[3:]).as_matrix()
        np.testing.assert_allclose(found[:3, :3], turn, atol=1e-7)


def test_a_driven_joint_has_no_effort_and_no_interface(moved):
    tree = tree_of(moved["palm"])
    wrist = next(j for j in tree.findall("joint") if j.get("name") == "wrist")
    assert wrist.get("type") == "continuous" and wrist.find("limit").get("effort") == "0"
    controlled = [joint.get("name") for joint in tree.find("ros2_control").findall("joint")]
    assert controlled == ["bend_index", "bend_thumb"]


def test_every_tip_and_every_pose_has_a_frame(moved, monkeypatch):
    pytest.importorskip("rclpy")
    from soft_sim_ros.node.tip_frame import ArmFrames

    for module in ("tf2_msgs", "tf2_msgs.msg"):
        monkeypatch.setitem(sys.modules, module, ModuleType(module))
    sys.modules["tf2_msgs.msg"].TFMessage = SimpleNamespace
    heard = []
    publisher = SimpleNamespace(publish=heard.append, get_subscription_count=lambda: 1)
    node = SimpleNamespace(
        get_fully_qualified_name=lambda: "/arm", create_publisher=lambda *_, **__: publisher
    )
    simulation = moved["ring"]
    frames = ArmFrames(node, simulation.scene, "world", "ring", 3, lambda *_: None)
    frames.show(simulation)
    frames.send(0)
    found = {t.child_frame_id: t.transform.translation for t in heard[0].transforms}
    along = [f"arm/backbone/{name}_{i}" for name in ("stem", "twig") for i in range(3)]
    tips = [f"arm/tip/{name}" for name in ("leaf", "twig", "ring")]
    assert list(found) == ["arm/base", "arm/tip", "arm/ring", *tips, *along]
    assert found["arm/tip"] == found["arm/ring"] == found["arm/tip/ring"]
    assert found["arm/tip/leaf"] == found["arm/backbone/stem_2"]
    twig = simulation.sampler(3, "twig").poses()[1, :3]
    middle = found["arm/backbone/twig_1"]
    assert (middle.x, middle.y, middle.z) == tuple(twig)
