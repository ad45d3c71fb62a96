"""An installed package is found the way ``ros2 run`` and ``ros2 launch`` find it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from soft_sim_ros import paths
from soft_sim_ros.commands import VERBS

index = pytest.importorskip("ament_index_python.packages", reason="no ROS 2 in this environment")


@pytest.fixture(scope="module")
def prefix() -> Path:
    """Prefix that this package is installed in: a workspace's, or this environment's."""
    before = os.environ.get("AMENT_PREFIX_PATH")
    os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join(filter(None, (before, sys.prefix)))
    try:
        return Path(index.get_package_prefix("soft_sim_ros"))
    except index.PackageNotFoundError:
        pytest.skip("the package is not installed: call `make env` or `colcon build`")
    finally:
        if before is None:
            del os.environ["AMENT_PREFIX_PATH"]
        else:
            os.environ["AMENT_PREFIX_PATH"] = before


@pytest.mark.parametrize("verb", VERBS)
def test_executable_says_what_it_does(prefix, verb, tmp_path):
    program = prefix / "lib" / "soft_sim_ros" / verb
    assert os.access(program, os.X_OK)
    done = subprocess.run([program, "--help"], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "usage: " in done.stdout


def test_data_files_are_there(prefix):
    share = prefix / "share" / "soft_sim_ros"
    assert (share / "package.xml").is_file()
    assert (share / "launch" / "simulate.launch.py").is_file()
    assert (share / "launch" / "view.launch.py").is_file()
    assert (share / "viewers" / "view.rviz").is_file()
    assert (share / "config" / "soft_arm.yaml").is_file()


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Make a prefix with the package's code in it, and let the code think it lies there."""
    code = tmp_path / "lib" / "python3" / "site-packages" / "soft_sim_ros"
    code.mkdir(parents=True)
    monkeypatch.setattr(paths, "__file__", str(code / "paths.py"))
    monkeypatch.setattr(paths.sys, "prefix", "/nonexistent")
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    return tmp_path


def config_of(prefix: Path) -> Path:
    config = prefix / "share" / "soft_sim_ros" / "config"
    config.mkdir(parents=True)
    return config


def test_config_of_the_prefix_around_the_code_comes_first(installed, tmp_path_factory, monkeypatch):
    expected, other = config_of(installed), tmp_path_factory.mktemp("other")
    config_of(other)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(other))
    assert paths.config_directory() == expected


def test_config_is_found_through_the_ament_prefix_path(installed, tmp_path_factory, monkeypatch):
    other = tmp_path_factory.mktemp("other")
    expected = config_of(other)
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nonexistent{os.pathsep}{other}")
    assert paths.config_directory() == expected


def test_missing_config_says_where_it_was_looked_for(installed):
    with pytest.raises(FileNotFoundError, match="lib/python3/share/soft_sim_ros/config"):
        paths.config_directory()
