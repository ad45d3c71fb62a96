"""The launch file hands its arguments to the node under the names and types that the node knows."""

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

parameters = pytest.importorskip(
    "soft_sim_ros.node.parameters", reason="no ROS 2 in this environment"
)
FILE = Path(__file__).resolve().parents[2] / "launch" / "simulate.launch.py"


def stand_in(**attributes):
    return SimpleNamespace(**attributes)


class Configuration:
    """Stand-in of LaunchConfiguration: performed in a mapping of names to texts."""

    def __init__(self, name):
        self.name = name

    def perform(self, context):
        return context[self.name]


@pytest.fixture
def description(monkeypatch):
    """Run the launch file against stand-ins of the classes of ROS's launch."""
    contents = {
        "launch": {"LaunchDescription": lambda entities: stand_in(entities=entities)},
        "launch.actions": {
            "DeclareLaunchArgument": lambda name, **rest: stand_in(
                kind="argument", name=name, **rest
            ),
            "OpaqueFunction": lambda function: function,
        },
        "launch.substitutions": {"LaunchConfiguration": Configuration},
        "launch_ros": {},
        "launch_ros.actions": {"Node": lambda **fields: stand_in(kind="node", **fields)},
        "launch_ros.parameter_descriptions": {
            "ParameterValue": lambda value, value_type: (value, value_type)
        },
    }
    for name, attributes in contents.items():
        module = ModuleType(name)
        vars(module).update(attributes)
        monkeypatch.setitem(sys.modules, name, module)
    return runpy.run_path(str(FILE))["generate_launch_description"]()


def launched(description, **given):
    """Give the node that is started with these arguments."""
    *arguments, function = description.entities
    context = {argument.name: argument.default_value for argument in arguments}
    assert set(given) <= set(context)
    (node,) = function(context | given)
    return node


def test_it_starts_the_node_by_its_name(description):
    from soft_sim_ros.node.simulate import NAME

    node = launched(description)
    assert (node.package, node.executable, node.name) == ("soft_sim_ros", "simulate", NAME)
    assert node.namespace.name == "namespace"
    assert node.parameters == [], "the node's own defaults"


def test_every_parameter_is_an_argument_of_the_same_name_and_type(description):
    *arguments, _ = description.entities
    told = {argument.name: argument.description for argument in arguments}
    assert told.pop("namespace") and told.pop("params_file") and told.pop("use_sim_time")
    assert told == {row.name: row.description for row in parameters.TABLE}
    texts = {row.name: str(row.default or "x").lower() for row in parameters.TABLE}
    (given,) = launched(description, use_sim_time="true", **texts).parameters
    assert given.pop("use_sim_time") == ("true", bool)
    for name, (text, kind) in given.items():
        assert text == texts[name]
        assert type(parameters.ROWS[name].default) is kind
    assert set(given) == set(texts)


def test_what_is_given_counts_more_than_the_file_of_parameters(description):
    node = launched(description, params_file="/tmp/own.yaml", publish_rate="50")
    # of several the last one counts
    assert node.parameters == ["/tmp/own.yaml", {"publish_rate": ("50", float)}]


def test_the_real_launch_takes_the_file():
    launch = pytest.importorskip("launch", reason="ROS's launch is not installed")
    pytest.importorskip("launch_ros", reason="ROS's launch is not installed")
    from launch.launch_description_sources import PythonLaunchDescriptionSource

    source = PythonLaunchDescriptionSource(str(FILE))
    found = source.get_launch_description(launch.LaunchContext())
    names = {argument.name for argument in found.get_launch_arguments()}
    assert {"namespace", "params_file", "scene", "real_time_factor", "record"} <= names
