"""A node with several branches: a topic for each of them, recorded and simulated again."""

import json

import numpy as np
from branched import file_of
from geometry_msgs.msg import PoseArray, PoseStamped
from peer import simulator, wait_for
from visualization_msgs.msg import MarkerArray

from soft_sim_ros.experiments.resimulation import rerun
from soft_sim_ros.recording.decode import decode
from soft_sim_ros.recording.reader import read_run


def test_each_branch_has_its_topics_and_all_of_them_are_recorded(tmp_path, peer):
    record = tmp_path / "run"
    program = simulator(tmp_path, scene=file_of("ring"), record=record, poses=11)
    twigs = peer.listen(PoseArray, "soft_arm/backbone/twig")
    leaves = peer.listen(PoseStamped, "soft_arm/tip_pose/leaf")
    tips = peer.listen(PoseStamped, "soft_arm/tip_pose")
    markers = peer.listen(MarkerArray, "soft_arm/markers")
    wait_for(lambda: all(map(len, (twigs, leaves, tips, markers))), "poses and markers")
    rods = [marker for marker in markers[-1].markers if marker.ns == "rods"]
    assert len(rods) == 3 and len(twigs[-1].poses) == 11
    assert program.end() == 0, program.text
    run = read_run(record)
    expected = {f"/soft_arm/backbone/{name}" for name in ("stem", "twig")}
    expected |= {f"/soft_arm/tip_pose/{name}" for name in ("leaf", "twig", "ring")}
    assert expected <= run.counts.keys() and "/soft_arm/backbone" not in run.counts
    counts = {run.counts[topic] for topic in (*expected, "/soft_arm/tip_pose")}
    assert len(counts) == 1 and counts.pop() > 0
    assert rerun(run).identical
    summary = json.loads((record / "summary.json").read_text())
    assert summary["tips"] == ["leaf", "twig", "ring"]
    assert {f"/soft_arm/{key}" for key in summary["messages_sent"]} >= expected
    heard = leaves[-1].header.stamp
    time_ns = heard.sec * 1_000_000_000 + heard.nanosec
    index = run.tip_poses["leaf"].time_ns.tolist().index(time_ns)
    place = leaves[-1].pose.position
    assert (place.x, place.y, place.z) == tuple(run.tip_poses["leaf"].positions[index])
    np.testing.assert_array_equal(run.tip_pose.poses, run.tip_poses["ring"].poses)
    kinds = {message.topic: message for message in run.messages() if message.topic in expected}
    for message in kinds.values():
        assert decode(message.type, message.data).frame_id == "world"
