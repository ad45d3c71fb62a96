"""The launch file of the viewers and their layouts name what the node has."""

import json
import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest
import yaml

from soft_sim_ros.recording.topics import ALL, VIEWS

parameters = pytest.importorskip(
    "soft_sim_ros.node.parameters", reason="no ROS 2 in this environment"
)
ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "launch" / "view.launch.py"
TOPICS = {name.replace("~", "/soft_arm") for name, *_ in (*ALL.values(), *VIEWS.values())}
TOPICS = {name if name.startswith("/") else f"/{name}" for name in TOPICS}


@pytest.fixture
def entities(monkeypatch):
    """Run the launch file against stand-ins of the classes of ROS's launch."""
    contents = {
        "launch": {"LaunchDescription": list},
        "launch.actions": {
            "DeclareLaunchArgument": lambda name, **rest: SimpleNamespace(name=name, **rest)
        },
        "launch.conditions": {"IfCondition": lambda given: given},
        "launch.substitutions": {"LaunchConfiguration": lambda name: SimpleNamespace(name=name)},
        "launch_ros": {},
        "launch_ros.actions": {"Node": lambda **fields: SimpleNamespace(**fields)},
        "launch_ros.parameter_descriptions": {
            "ParameterValue": lambda value, value_type: (value.name, value_type)
        },
    }
    for name, attributes in contents.items():
        module = ModuleType(name)
        vars(module).update(attributes)
        monkeypatch.setitem(sys.modules, name, module)
    return runpy.run_path(str(FILE))["generate_launch_description"]()


def test_the_simulator_gets_parameters_it_has_with_their_types(entities):
    arguments = {e.name: e.default_value for e in entities if not hasattr(e, "package")}
    (node,) = [e for e in entities if getattr(e, "package", "") == "soft_sim_ros"]
    (given,) = node.parameters
    for parameter, (argument, kind) in given.items():
        assert type(parameters.ROWS[parameter].default) is kind
        parameters.ROWS[parameter].accept(
            arguments[argument] == "true" if kind is bool else kind(arguments[argument])
        )
    assert given["marker_rate"][0] in arguments and given["publish_tf"][0] in arguments


def test_rviz_starts_with_a_configuration_that_exists_and_looks_into_the_namespace(entities):
    (rviz,) = [e for e in entities if getattr(e, "package", "") == "rviz2"]
    assert Path(rviz.arguments[1]).is_file()
    assert {old for old, _ in rviz.remappings} <= TOPICS
    assert all(new[0].name == "namespace" for _, new in rviz.remappings)


def test_rviz_shows_topics_of_the_node_with_qualities_that_match():
    config = yaml.safe_load((ROOT / "viewers" / "view.rviz").read_text())
    displays = config["Visualization Manager"]["Displays"]
    topics = {d["Topic"]["Value"]: d["Topic"] for d in displays if "Topic" in d}
    assert set(topics) <= TOPICS
    for name, _, qos in VIEWS.values():
        found = topics[name.replace("~", "/soft_arm")]
        wanted = found["Durability Policy"].lower().replace(" ", "_")
        assert wanted == qos.durability
    frame = config["Visualization Manager"]["Global Options"]["Fixed Frame"]
    assert frame == parameters.ROWS["frame_id"].default


def test_foxglove_shows_topics_of_the_node():
    layout = json.loads((ROOT / "viewers" / "foxglove.json").read_text())
    panels = layout["configById"]
    assert set(panels["3D!arm"]["topics"]) <= TOPICS
    for panel in panels.values():
        for path in panel.get("paths", []):
            assert path["value"].partition(".")[0] in TOPICS
