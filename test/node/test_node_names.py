"""What topics are called: after the node, after the scene, or remapped; and what is recorded."""

from pathlib import Path

import pytest
from peer import Program, simulator, wait_for
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from soft_sim_ros.experiments.resimulation import Rerun
from soft_sim_ros.node.reading import without_node_name
from soft_sim_ros.recording.reader import read_run

SCENE = Path(__file__).with_name("arm.yaml")


def test_topics_carry_the_scenes_name_and_a_replay_the_names_they_were_heard_under(tmp_path, peer):
    file = tmp_path / "parameters.yaml"
    file.write_text("soft_arm:\n  ros__parameters: {poses: 5, name_from: scene}\n")
    rules = ("-r", "joint_states:=/cell/states", "-r", "~/command:=/cell/torques")
    # the name that a launch file gives its node does not stand in the way
    rules += ("-r", "__node:=soft_arm", "--params-file", str(file))
    program = simulator(tmp_path, *rules, scene=SCENE, record=tmp_path / "run")
    states = peer.listen(JointState, "/cell/states")
    command = peer.talk(Float64MultiArray, "/cell/torques")
    wait_for(lambda: states, "states under the given name")
    assert "test_arm" in peer.node.get_node_names()
    assert "soft_arm" not in peer.node.get_node_names()
    command.publish(Float64MultiArray(data=[0.1, 0.2]))
    wait_for(lambda: list(states[-1].effort) == [0.1, 0.2], "the command")
    assert peer.pause(True, "test_arm").success
    assert program.end() == 0, program.text
    assert "nothing of it is used" not in program.text

    run = read_run(tmp_path / "run")
    assert run.metadata["node"] == "/test_arm" and run.metadata["poses"] == "5"
    assert run.backbone.poses.shape[1] == 5
    # a recording has the topics' own names, so that everything finds them
    assert {"/test_arm/backbone", "/joint_states", "/test_arm/command"} <= set(run.counts)
    assert len(run.commands) == 1
    assert Rerun(run).compare().identical

    states.clear()
    program = Program(
        tmp_path,
        ("-m", "soft_sim_ros"),
        "replay",
        str(tmp_path / "run"),
        "--with-commands",
        "--rate",
        "5",
        "--wait-for",
        "/joint_states",
        "/test_arm/command",
    )
    torques = peer.listen(Float64MultiArray, "/cell/torques")
    assert program.wait() == 0, program.text
    wait_for(lambda: len(states) == run.counts["/joint_states"], "the replayed states")
    wait_for(lambda: torques, "the replayed command")
    assert list(torques[0].data) == [0.1, 0.2]
    assert "/joint_states, as /cell/states" in program.text


@pytest.mark.parametrize(
    ("words", "left"),
    [
        ("--ros-args -r __node:=a -p x:=1", "--ros-args -p x:=1"),
        ("--ros-args --remap soft_arm:__node:=a -r __ns:=/b", "--ros-args -r __ns:=/b"),
        ("--ros-args -p name:=__node", "--ros-args -p name:=__node"),
    ],
)
def test_rules_for_the_nodes_name_are_taken_out_of_a_command_line(words, left):
    assert without_node_name(words.split()) == left.split()
