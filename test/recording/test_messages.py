"""The definitions kept in the package are those of the installed ROS 2 message packages."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest

from soft_sim_ros.recording import messages


def share() -> Path | None:
    """Find the installed message definitions, in a ROS installation or in this environment."""
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    for prefix in filter(None, prefixes):
        if (Path(prefix) / "share/std_msgs/msg/String.msg").exists():
            return Path(prefix) / "share"
    return None


SHARE = share()
needs_ros = pytest.mark.skipif(SHARE is None, reason="no ROS message packages are installed")


@needs_ros
@pytest.mark.parametrize("name", sorted(messages.DEFINITIONS))
def test_definition_has_the_fields_of_the_installed_one(name: str) -> None:
    installed = (SHARE / f"{name}.msg").read_text()
    assert messages.fields(messages.DEFINITIONS[name]) == messages.fields(installed)


@needs_ros
@pytest.mark.parametrize("name", sorted(messages.TYPE_HASHES))
def test_type_hash_is_the_installed_one(name: str) -> None:
    hashes = json.loads((SHARE / f"{name}.json").read_text())["type_hashes"]
    installed = {entry["type_name"]: entry["hash_string"] for entry in hashes}
    assert messages.TYPE_HASHES[name] == installed[name]


@pytest.mark.parametrize("name", sorted(messages.TYPE_HASHES))
def test_schema_explains_itself_to_an_independent_parser(name: str) -> None:
    from rosbags.typesys import get_types_from_msg

    text = messages.schema(name)
    found = get_types_from_msg(text, name)
    # the parser takes every part of the schema; a definition left out would be missing here
    assert set(found) == {name, *messages.dependencies(name)}


def test_every_dependency_is_written_once() -> None:
    text = messages.schema("geometry_msgs/msg/PoseArray")
    assert text.count("MSG: geometry_msgs/Point\n") == 1
    assert text.count("=" * 80 + "\n") == 5
