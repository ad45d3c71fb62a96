"""Every backbone and every tip of a forest is recorded, read, recovered and simulated again."""

from __future__ import annotations

import csv
import itertools
import json

import numpy as np
import pytest
from branched import NAMES

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.experiments.motions import Recorded
from soft_sim_ros.experiments.resimulation import rerun
from soft_sim_ros.recording import cdr
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.recording.recover import recover
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter
from soft_sim_ros.report import export_csv, export_npz
from soft_sim_ros.scene import load_scene
from soft_sim_ros.scene.limbs import CHAIN, Limbs, limbs_of

BACKBONES = {
    "two_arms": ["left", "right"], "palm": ["index", "middle", "thumb"], "ring": ["stem", "twig"],
}  # fmt: skip
TIPS = BACKBONES | {"ring": ["leaf", "twig", "ring"]}


@pytest.fixture(scope="module")
def runs(recorded):
    return {name: read_run(path) for name, path in recorded.items()}


@pytest.mark.parametrize("name", NAMES)
def test_each_limb_has_a_topic_of_its_own_and_the_tip_keeps_its_topic(runs, name):
    run = runs[name]
    found = {topic for topic in run.counts if "backbone" in topic or "tip_pose" in topic}
    expected = {f"/soft_arm/backbone/{limb}" for limb in BACKBONES[name]}
    expected |= {f"/soft_arm/tip_pose/{limb}" for limb in TIPS[name]}
    assert found == expected | {"/soft_arm/tip_pose"}
    assert {run.counts[topic] for topic in found} == {11}
    assert (list(run.backbones), list(run.tip_poses)) == (BACKBONES[name], TIPS[name])
    assert run.backbone is run.backbones[BACKBONES[name][-1]]
    np.testing.assert_array_equal(run.tip_pose.poses, run.tip_poses[TIPS[name][-1]].poses)


def test_the_summary_names_several_limbs_and_says_nothing_of_one(recorded):
    summary = json.loads((recorded["ring"] / "summary.json").read_text())
    assert (summary["backbones"], summary["tips"]) == (BACKBONES["ring"], TIPS["ring"])
    assert limbs_of(load_scene("soft_arm")).facts() == {}


def test_fingers_begin_where_the_turning_palm_holds_them(runs):
    run = runs["palm"]
    angle = 0.3 * np.sin(2.0 * run.backbone.time)
    for name, y in (("index", 0.03), ("middle", 0.0), ("thumb", -0.03)):
        expected = np.stack([np.full_like(angle, 0.05), y * np.cos(angle), y * np.sin(angle)], 1)
        np.testing.assert_allclose(run.backbones[name].positions[:, 0], expected, atol=1e-12)
    thumb, tip = run.backbones["thumb"], run.tip_poses["thumb"]
    np.testing.assert_allclose(thumb.positions[:, -1], tip.positions, atol=1e-14)
    lengths = np.linalg.norm(np.diff(thumb.positions, axis=1), axis=2).sum(axis=1)
    np.testing.assert_allclose(lengths, 0.12, rtol=5e-3)


def test_a_twig_begins_on_the_stem_and_the_stem_goes_on_in_the_leaf(runs):
    run = runs["ring"]
    stem, twig = run.backbones["stem"], run.backbones["twig"]
    np.testing.assert_allclose(twig.positions[:, 0], stem.positions[:, 25], atol=1e-13)  # 0.25 m
    np.testing.assert_allclose(run.tip_poses["ring"].positions, stem.positions[:, 10], atol=1e-13)
    np.testing.assert_allclose(run.tip_poses["leaf"].positions, stem.positions[:, -1], atol=1e-13)
    first, last = twig.positions[0, 0], twig.positions[0, -1]
    np.testing.assert_allclose(last - first, 0.2 * np.array([np.cos(0.8), np.sin(0.8), 0.0]))


@pytest.mark.parametrize("name", NAMES)
def test_a_forest_simulated_again_is_the_same_bit_by_bit(runs, name):
    found = rerun(runs[name])
    assert found.identical
    assert found.messages == sum(runs[name].counts.values()) - len(runs[name].commands)


def test_a_forest_is_recovered_whole(recorded, runs, tmp_path):
    recover(recorded["palm"], tmp_path / "again")
    again = read_run(tmp_path / "again")
    assert list(again.messages()) == list(runs["palm"].messages())
    assert list(again.backbones) == BACKBONES["palm"]


def test_each_limb_has_a_table_of_its_own(runs, tmp_path):
    run = runs["two_arms"]
    names = {path.stem for path in export_csv(run, tmp_path)}
    limbs = {f"{kind}_{limb}" for kind in ("backbone", "tip_pose") for limb in ("left", "right")}
    assert names == limbs | {"tip_pose", "joint_states", "strain_state", "energy", "inputs"}
    with (tmp_path / "tip_pose_left.csv").open() as stream:
        row = list(csv.reader(stream))[-1]
    assert [float(cell) for cell in row[1:]] == run.tip_poses["left"].poses[-1].tolist()
    arrays = np.load(export_npz(run, tmp_path / "all.npz"))
    np.testing.assert_array_equal(arrays["backbone_right_poses"], run.backbones["right"].poses)


@pytest.mark.parametrize(("topic", "name"), [*itertools.product(["backbone", "tip_pose"], NAMES)])
def test_a_measured_forest_is_predicted_where_it_was(runs, topic, name):
    measured = Recorded(runs[name], topic)
    predicted = measured.predict(measured.text, 5)
    np.testing.assert_array_equal(predicted, measured.measured[:5])


def write(directory, arms):
    """Record one message on every topic of poses of some arms: prefix → limbs."""
    topics = [
        topic
        for prefix, limbs in arms.items()
        for topic in recorded_topics(prefix, limbs)
        if "backbone" in topic.key or "tip_pose" in topic.key
    ]
    keyed = [type(t)(str(i), t.name, t.type, t.qos) for i, t in enumerate(topics)]
    with BagWriter(directory, keyed) as bag:
        for index, topic in enumerate(topics):
            poses = np.full((2, 7), float(index))
            if topic.key.startswith("backbone"):
                data = cdr.PoseArrayBuffer("world", 2).fill(0, poses)
            else:
                data = cdr.PoseStampedBuffer("world").fill(0, poses[0])
            bag.write(str(index), 0, data)
    return directory


@pytest.mark.parametrize("name", ["backbone", "tip_pose"])
def test_a_limb_may_have_the_name_of_a_topic(tmp_path, name):
    path = write(tmp_path / "run", {"/arm": Limbs((name, "other"), (name, "other"))})
    for run in (read_run(path), read_run(path, "/arm")):
        assert list(run.backbones) == list(run.tip_poses) == [name, "other"]


@pytest.mark.parametrize("name", ["/backbone", "/left/tip_pose"])
def test_a_node_may_have_the_name_of_a_topic(tmp_path, name):
    path = write(tmp_path / "run", {name: CHAIN})
    for run in (read_run(path), read_run(path, name)):
        assert list(run.backbones) == list(run.tip_poses) == [""]
        assert len(run.backbone) == len(run.tip_pose) == 1


def test_of_several_arms_the_node_says_which_whether_chains_or_forests(tmp_path):
    forest = Limbs(("a", "b"), ("a", "b"))
    path = write(tmp_path / "run", {"/one": CHAIN, "/two": forest, "/three": forest})
    with pytest.raises(RecordingError, match=r"several arms \(/one/backbone, /two/backbone/a, "):
        read_run(path)
    assert list(read_run(path, "/one").backbones) == [""]
    for node, first in (("/two", 2), ("/three", 7)):
        run = read_run(path, node)
        assert {name: series.poses[0, 0, 0] for name, series in run.backbones.items()} == {
            "a": first,
            "b": first + 1,
        }


def test_the_last_limb_stands_in_where_only_some_were_recorded(tmp_path):
    only = Limbs(("a", "b"), ("a", "b"))
    path = write(tmp_path / "run", {"/one": only})
    run = read_run(path)
    assert run.backbone is run.backbones["b"]
    assert run.tip_pose.poses[0, 0] == 2.0, "the topic of the tip itself"
