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


@pytest.fixture
def description(monkeypatch):
    """Run the launch file against stand-ins of the classes of ROS's launch."""
    contents = {
        "launch": {"LaunchDescription": lambda entities: stand_in(entities=entities)},
        "launch.actions": {
            "DeclareLaunchArgument": lambda name, **rest: stand_in(
                kind="argument", name=name, **rest
            )
        },
        "launch.substitutions": {"LaunchConfiguration": lambda name: stand_in(name=name)},
        "launch_ros": {},
        "launch_ros.actions": {"Node": lambda **fields: stand_in(kind="node", **fields)},
        "launch_ros.parameter_descriptions": {
            "ParameterValue": lambda value, value_type: (value.name, value_type)
        },
    }
    for name, attributes in contents.items():
        module = ModuleType(name)
        vars(module).update(attributes)
        monkeypatch.setitem(sys.modules, name, module)
    return runpy.run_path(str(FILE))["generate_launch_description"]()


def test_it_starts_the_node_by_its_name(description):
    from soft_sim_ros.node.simulate import NAME

    node = description.entities[-1]
    assert (node.package, node.executable, node.name) == ("soft_sim_ros", "simulate", NAME)
    assert node.namespace.name == "namespace"


def test_every_argument_is_declared_and_has_the_nodes_default_and_type(description):
    *arguments, node = description.entities
    defaults = {argument.name: argument.default_value for argument in arguments}
    assert defaults.pop("namespace") == ""
    (given,) = node.parameters
    assert {argument for argument, _ in given.values()} == set(defaults)
    for parameter, (argument, kind) in given.items():
        row = parameters.ROWS[parameter]
        assert type(row.default) is kind
        default = defaults[argument]
        assert (default == "true" if kind is bool else kind(default)) == row.default


def test_the_real_launch_takes_the_file():
    launch = pytest.importorskip("launch", reason="ROS's launch is not installed")
    pytest.importorskip("launch_ros", reason="ROS's launch is not installed")
    from launch.launch_description_sources import PythonLaunchDescriptionSource

    source = PythonLaunchDescriptionSource(str(FILE))
    found = source.get_launch_description(launch.LaunchContext())
    names = {argument.name for argument in found.get_launch_arguments()}
    assert {"namespace", "scene", "rate", "record"} <= names
