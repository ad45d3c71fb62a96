"""Parameter files of a whole stack: what is for others is passed over, what is misspelt is not."""

import pytest
from peer import PROGRAM, Program, simulator
from rclpy.node import Node

from soft_sim_ros.node.parameter_files import shared_names
from soft_sim_ros.node.parameters import ParameterError, declare, strangers
from soft_sim_ros.node.quality import check_overrides

PUBLISHED, SUBSCRIBED = ["~/backbone", "joint_states"], ["~/command"]


@pytest.fixture
def read(tmp_path, context):
    nodes = []

    def read(text, *words, node="/soft_arm"):
        file = tmp_path / "parameters.yaml"
        file.write_text(text)
        args = ["--ros-args", "--params-file", str(file), *words]
        namespace, _, name = node.rpartition("/")
        nodes.append(
            Node(
                name,
                namespace=namespace,
                context=context,
                cli_args=args,
                use_global_arguments=False,
            )
        )
        shared = shared_names(args, node)
        others = strangers(nodes[-1], shared)
        settings = declare(nodes[-1], others, shared)
        return settings, others + check_overrides(nodes[-1], PUBLISHED, SUBSCRIBED, shared)

    yield read
    for one in nodes:
        one.destroy_node()


def entry(node, *lines):
    inner = "".join(f"    {line}\n" for line in lines)
    return f"{node}:\n  ros__parameters:\n{inner}"


@pytest.mark.parametrize("pattern", ["/**", "/*"])
@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("robot_description: <robot/>", "robot_description"),
        ("update_rate: 100", "update_rate"),
        ("publish_frequency: 20.0", "publish_frequency"),
        ("arm_controller: {joints: [a, b]}", "arm_controller.joints"),
        *(
            (
                f"qos_overrides: {{{topic}: {{{kind}: {{depth: 5}}}}}}",
                f"qos_overrides.{topic}.{kind}.depth",
            )
            for topic, kind in (
                ("/tf", "publisher"),
                ("/parameter_events", "publisher"),
                ("/joint_states", "subscription"),
                ("/left/joint_states", "publisher"),
            )
        ),
    ],
)
def test_what_is_for_other_nodes_of_a_stack_is_passed_over(read, pattern, line, name):
    settings, others = read(entry(pattern, line, "poses: 9"))
    assert settings.poses == 9
    assert others == [name]


@pytest.mark.parametrize(
    ("line", "nearest"),
    [
        ("pose: 9", "poses"),
        ("Poses: 9", "poses"),
        ("recrod: /tmp/x", "record"),
        ("publish_rte: 10.0", "publish_rate"),
        ("use_simtime: true", "use_sim_time"),
        ("qos_overrides: {/soft_arm/backbon: {publisher: {depth: 5}}}", "/soft_arm/backbone"),
        ("qos_overrides: {/joint_state: {publisher: {depth: 5}}}", "/joint_states"),
        ("qos_overrides: {/joint_states: {publisher: {dept: 5}}}", "publisher.depth"),
        ("qos_overrides: {/tf: {publsher: {depth: 5}}}", ""),
    ],
)
def test_a_misspelt_name_of_ours_is_refused_in_a_shared_file_too(read, line, nearest):
    with pytest.raises(ParameterError, match=f"unknown parameter.*{nearest}"):
        read(entry("/**", line))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (entry("soft_arm", "robot_description: x"), ()),
        (entry("/**", "poses: 9"), ("-p", "robot_description:=x")),
        (entry("/**", "robot_description: x") + entry("soft_arm", "robot_description: y"), ()),
    ],
)
def test_what_is_said_to_this_node_by_name_must_be_known(read, text, words):
    with pytest.raises(ParameterError, match="unknown parameter 'robot_description'"):
        read(text, *words)


@pytest.mark.parametrize(
    ("text", "words", "publishes", "time"),
    [
        (entry("/**", "poses: 9"), (), True, "own"),
        (entry("/**", "use_sim_time: true"), (), True, "own"),
        (entry("/**", "use_sim_time: true", "publish_clock: false"), (), False, "lock_step"),
        (entry("/**", "use_sim_time: true"), ("-p", "use_sim_time:=true"), False, "lock_step"),
        (entry("soft_arm", "use_sim_time: true"), (), False, "lock_step"),
        (
            entry("soft_arm", "use_sim_time: true", "follow_clock: resampled"),
            (),
            False,
            "resampled",
        ),
        (entry("soft_arm", "use_sim_time: true", "publish_clock: true"), (), True, "own"),
        (entry("soft_arm", "publish_clock: false"), (), False, "own"),
        (entry("soft_arm", "follow_clock: resampled"), (), True, "own"),
    ],
)
def test_who_is_told_to_use_simulated_time_follows_unless_he_publishes_it(
    read, text, words, publishes, time
):
    settings, _ = read(text, *words)
    assert (settings.publish_clock, settings.time) == (publishes, time)


def test_a_way_to_follow_that_there_is_not_is_refused(read):
    with pytest.raises(ParameterError, match=r"follow_clock.*expected lock_step or resampled"):
        read(entry("soft_arm", "follow_clock: lockstep"))


def test_the_node_starts_with_a_shared_file_and_says_once_what_it_passes_over(tmp_path):
    file = tmp_path / "shared.yaml"
    file.write_text(
        entry(
            "/**",
            "use_sim_time: true",
            "robot_description: <robot name='x'/>",
            "qos_overrides: {/tf: {publisher: {depth: 5}}}",
        )
    )
    program = simulator(tmp_path, "--params-file", str(file), start_paused="true")
    said = "passed over, since not for this node: 'robot_description'"
    assert program.text.count(said) == 1
    assert program.end() == 0, program.text


def test_the_node_does_not_start_with_a_misspelt_name_in_a_shared_file(tmp_path):
    file = tmp_path / "shared.yaml"
    file.write_text(entry("/**", "recrod: /tmp/x", "robot_description: x"))
    program = Program(tmp_path, PROGRAM, "--ros-args", "--params-file", str(file))
    assert program.wait(240.0) == 2
    assert "unknown parameter 'recrod'" in program.text and "'record'" in program.text
    assert "unknown parameter 'robot" not in program.text
