"""Parameters: one table, typed, bounded, and nothing unknown gets in."""

import time

import pytest
from peer import PROGRAM, ROOT, Program
from rcl_interfaces.msg import ParameterType
from rclpy.node import Node
from rclpy.parameter import Parameter

from soft_sim_ros.node.parameter_files import passed_over
from soft_sim_ros.node.parameters import TABLE, ParameterError, declare, on_change


@pytest.fixture
def node_with(context):
    nodes = []

    def make(*parameters):
        words = [word for parameter in parameters for word in ("-p", parameter)]
        nodes.append(
            Node(
                f"parameters_{time.monotonic_ns()}",
                context=context,
                cli_args=["--ros-args", *words],
                use_global_arguments=False,
            )
        )
        return nodes[-1]

    yield make
    for node in nodes:
        node.destroy_node()


def test_without_overrides_every_parameter_has_its_default(node_with):
    settings = declare(node_with())
    assert vars(settings) == {row.name: row.default for row in TABLE}


def test_every_parameter_is_described_and_bounded_and_read_only_unless_live(node_with):
    node = node_with()
    declare(node)
    for row in TABLE:
        descriptor = node.describe_parameter(row.name)
        assert descriptor.description == row.description
        assert descriptor.read_only != row.live
        if descriptor.type == ParameterType.PARAMETER_DOUBLE:
            assert descriptor.floating_point_range[0].to_value == row.high
        if descriptor.type == ParameterType.PARAMETER_INTEGER:
            assert descriptor.integer_range[0].to_value == row.high


@pytest.mark.parametrize(
    ("override", "name", "nearest"),
    [
        ("publish_rte:=10.0", "publish_rte", "publish_rate"),
        ("realtime_factor:=1.0", "realtime_factor", "real_time_factor"),
        ("comand_timeout:=1.0", "comand_timeout", "command_timeout"),
    ],
)
def test_an_unknown_override_is_refused_by_name_with_the_nearest_known_one(
    node_with, override, name, nearest
):
    with pytest.raises(ParameterError, match=f"{name!r}.*{nearest!r}"):
        declare(node_with(override))


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("publish_rate:=fast", "publish_rate = 'fast': expected a number"),
        ("publish_rate:=0.0", "publish_rate = 0.0: expected 0.1 to 10000"),
        ("real_time_factor:=.nan", "real_time_factor = nan: expected 0 to 1000"),
        ("command_timeout:=-1", "command_timeout = -1.0: expected 0 to"),
        ("poses:=1", "poses = 1: expected 2 to 10000"),
        ("poses:=20.0", "poses = 20.0: expected an integer"),
        ("publish_clock:=1", "publish_clock = 1: expected a boolean"),
        ("frame_id:=tip", "frame_id = 'tip'"),
    ],
)
def test_an_unusable_value_is_refused_with_what_is_expected(node_with, override, message):
    with pytest.raises(ParameterError) as caught:
        declare(node_with(override))
    assert message in str(caught.value)


def test_all_faults_are_said_at_once(node_with):
    with pytest.raises(ParameterError) as caught:
        declare(node_with("poses:=1", "pose:=1", "publish_rate:=0.0"))
    assert len(caught.value.lines) == 3


def test_a_whole_number_is_a_number(node_with):
    settings = declare(node_with("publish_rate:=250"))
    assert settings.publish_rate == 250.0
    assert isinstance(settings.publish_rate, float)


def test_live_parameters_change_and_others_do_not(node_with):
    node = node_with()
    declare(node)
    heard = []
    on_change(node, lambda name, value: heard.append((name, value)))
    (accepted,) = node.set_parameters([Parameter("real_time_factor", value=2.5)])
    assert accepted.successful
    (refused,) = node.set_parameters([Parameter("publish_rate", value=50.0)])
    assert not refused.successful
    assert "read-only" in refused.reason
    (nan,) = node.set_parameters([Parameter("real_time_factor", value=float("nan"))])
    assert not nan.successful
    assert heard == [("real_time_factor", 2.5)]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--ros-args", "-p", "recrod:=/tmp/x"), "unknown parameter 'recrod'"),
        (("--ros-args", "-p", "scene:=no_such_arm"), "no_such_arm"),
        (
            ("--ros-args", "-p", "qos_overrides./soft_arm/backbon.publisher.depth:=5"),
            "unknown parameter 'qos_overrides./soft_arm/backbon.publisher.depth'",
        ),
        (("scene.yaml",), "unrecognized arguments: scene.yaml"),
        (("--ros-args", "-p", "poses:=[1, 2.5]"), "cannot start"),
    ],
)
def test_the_node_does_not_start_with_what_it_does_not_understand(tmp_path, arguments, message):
    program = Program(tmp_path, PROGRAM, *arguments)
    assert program.wait(240.0) == 2
    assert message in program.text
    assert "Traceback" not in program.text


def test_the_manual_has_the_table_of_the_parameters():
    written = {}
    for line in (ROOT / "docs" / "ros.md").read_text().splitlines():
        cells = [cell.strip().replace("`", "").replace("'", "") for cell in line.split("|")]
        if len(cells) == 6 and cells[1] in {row.name for row in TABLE}:
            written[cells[1]] = tuple(cells[2:5])
    assert written == {
        row.name: (
            str(row.default).lower() if row.default != "" else "empty",
            "live" if row.live else "",
            row.description.replace("'", ""),
        )
        for row in TABLE
    }


@pytest.mark.parametrize("words", [["scene:=tendon_arm"], ["--ros-args", "scene:=tendon_arm"]])
def test_a_parameter_without_its_flag_is_refused(words, capsys):
    from soft_sim_ros.node.simulate import main

    assert main(words) == 2
    assert "-p scene:=tendon_arm" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "node", "told"),
    [
        ("soft_arm: {ros__parameters: {poses: 9}}", "/soft_arm", False),
        ("/soft_arm: {ros__parameters: {poses: 9}}", "/soft_arm", False),
        ("/**: {ros__parameters: {poses: 9}}", "/left/soft_arm", False),
        ("/*/soft_arm: {ros__parameters: {poses: 9}}", "/left/soft_arm", False),
        ("left: {soft_arm: {ros__parameters: {poses: 9}}}", "/left/soft_arm", False),
        ("{}", "/soft_arm", False),
        ("soft_arm: {ros__parameters: {}}\nother: {ros__parameters: {}}", "/soft_arm", False),
        ("softarm: {ros__parameters: {poses: 9}}", "/soft_arm", True),
        ("soft_arm: {ros__parameters: {poses: 9}}", "/left/soft_arm", True),
        ("/*: {ros__parameters: {poses: 9}}", "/left/soft_arm", True),
    ],
)
def test_a_file_with_parameters_for_other_nodes_only_is_told(tmp_path, context, text, node, told):
    file = tmp_path / "parameters.yaml"
    file.write_text(text)
    words = ["--ros-args", "-r", f"__node:={node.split('/')[-1]}", "--params-file", str(file)]
    lines = list(passed_over(words, node))
    assert len(lines) == told
    if told:
        assert str(file) in lines[0] and node in lines[0]
    # what ROS itself makes of it
    namespace, name = node.rsplit("/", 1)
    made = Node(
        name, namespace=namespace, context=context, cli_args=words, use_global_arguments=False
    )
    used = "poses" in made._parameter_overrides
    made.destroy_node()
    assert used == ("poses" in text and not told)


def test_the_node_says_that_a_parameter_file_is_for_another_name(tmp_path):
    file = tmp_path / "parameters.yaml"
    file.write_text("arm: {ros__parameters: {poses: 9}}\n")
    words = ("--ros-args", "-p", "scene:=no_such_arm", "--params-file", str(file))
    program = Program(tmp_path, PROGRAM, *words)
    assert program.wait(240.0) == 2
    assert f"{file} has parameters for /arm, but this node is /soft_arm" in program.text
