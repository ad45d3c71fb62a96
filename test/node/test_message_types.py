"""A type name in a recording imports packages of messages, and nothing else."""

import sys

import pytest
from geometry_msgs.msg import PoseArray
from lifecycle_msgs.msg import State

from soft_sim_ros.node.message_types import installed_type


def test_types_of_installed_packages_are_found():
    assert installed_type("geometry_msgs/msg/PoseArray") is PoseArray
    assert installed_type("lifecycle_msgs/msg/State") is State  # not used here, but registered


@pytest.mark.parametrize(
    "name",
    ["trap/msg/Sprung", "trap.deep/msg/Sprung", "geometry_msgs/msg/Nothing", "os/msg/path", "trap",
     "geometry_msgs/srv/X", "../trap/msg/Sprung", "", "geometry_msgs/msg/_pose", "a/b/c/d"],
)  # fmt: skip
def test_no_other_module_is_imported(tmp_path, monkeypatch, name):
    for package in ("trap", "trap/msg", "trap/deep", "trap/deep/msg"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").write_text("Sprung = int\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert installed_type(name) is None
    assert not [module for module in sys.modules if module.split(".")[0] == "trap"]
