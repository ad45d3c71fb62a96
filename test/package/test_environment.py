"""The script behind ``make env`` refuses politely, and does nothing twice."""

import importlib.util
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "tools" / "environment.py"
Version = namedtuple("Version", "major minor micro")


@pytest.fixture
def script(monkeypatch):
    spec = importlib.util.spec_from_file_location("environment_script", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.delenv("ROS_DISTRO", raising=False)
    return module


@pytest.fixture
def bare(script, monkeypatch):
    """Make environments without pip, which takes most of the time; one test makes a whole one."""

    def create(venv, jazzy):
        command = [sys.executable, "-m", "venv", "--without-pip", str(venv)]
        subprocess.run(command, check=True)

    monkeypatch.setattr(script, "create", create)


@pytest.mark.parametrize("version", [(3, 9, 2), (3, 14, 0)])
def test_another_python_is_refused(script, monkeypatch, version):
    monkeypatch.setattr(script.sys, "version_info", version)
    with pytest.raises(script.Refused, match=r"needed is 3\.10 to 3\.13"):
        script.check_machine(jazzy=False)


def test_another_processor_needs_a_jazzy_of_its_own(script, monkeypatch):
    monkeypatch.setattr(script.platform, "machine", lambda: "aarch64")
    with pytest.raises(script.Refused, match="Install ROS 2 Jazzy, source it"):
        script.check_machine(jazzy=False)
    script.check_machine(jazzy=True)


def test_missing_venv_is_told_with_what_to_install(script, monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        script.importlib.util, "find_spec", lambda name: None if name == "ensurepip" else find(name)
    )
    with pytest.raises(script.Refused, match=r"sudo apt install python3\.\d+-venv"):
        script.check_machine(jazzy=False)


def test_another_distribution_is_refused(script, monkeypatch):
    monkeypatch.setenv("ROS_DISTRO", "humble")
    with pytest.raises(script.Refused, match="ROS 2 'humble' is sourced"):
        script.sourced_jazzy()


def test_no_ros_sourced_means_ros_from_pypi(script):
    assert script.sourced_jazzy() is False


def test_a_jazzy_that_this_python_cannot_import_is_refused(script, monkeypatch, tmp_path):
    (tmp_path / "rclpy.py").write_text("raise ImportError('made for another Python')")
    monkeypatch.setenv("ROS_DISTRO", "jazzy")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(script.Refused, match="made for another Python"):
        script.sourced_jazzy()


def test_a_sourced_jazzy_is_stood_upon(script, monkeypatch, tmp_path):
    (tmp_path / "rclpy.py").touch()
    monkeypatch.setenv("ROS_DISTRO", "jazzy")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    installed = []
    monkeypatch.setattr(script, "install", lambda venv, jazzy, tests: installed.append(jazzy))
    script.make(tmp_path / "venv")
    config = (tmp_path / "venv" / "pyvenv.cfg").read_text()
    assert "include-system-site-packages = true" in config
    assert installed == [True]


def test_a_second_call_does_nothing_and_a_change_of_requirements_something(
    script, bare, monkeypatch, tmp_path
):
    installed = []
    monkeypatch.setattr(script, "install", lambda venv, jazzy, tests: installed.append(venv))
    venv = tmp_path / "with space"
    script.make(venv)
    script.make(venv)
    assert installed == [venv]
    inside = (venv / "pyvenv.cfg").stat().st_ino
    describe = script.description
    monkeypatch.setattr(script, "description", lambda *of, **more: describe(*of, **more) + "more\n")
    script.make(venv)
    assert installed == [venv, venv]
    assert (venv / "pyvenv.cfg").stat().st_ino == inside


def test_what_tests_need_is_added_once_and_is_enough_for_running(
    script, bare, monkeypatch, tmp_path
):
    installed = []
    monkeypatch.setattr(script, "install", lambda venv, jazzy, tests: installed.append(tests))
    for tests in (False, False, True, False, True):
        script.make(tmp_path / "venv", tests)
    assert installed == [False, True]


def test_running_installs_no_package_that_only_tests_need(script, monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(script, "pip", lambda venv, *what: asked.extend(what))
    monkeypatch.setattr(script.subprocess, "Popen", lambda *of, **more: Version(0, 0, 0))
    monkeypatch.setattr(Version, "wait", lambda self: 0, raising=False)
    script.install(tmp_path, False, False)
    assert asked == ["--editable", str(script.ROOT), *script.ros_packages()]
    assert all(name.startswith("ros-") for name in script.ros_packages())


def test_an_installation_that_was_cut_short_is_taken_up_again(script, bare, monkeypatch, tmp_path):
    installed = []

    def install(venv, jazzy, tests):
        installed.append(venv)
        if len(installed) == 1:
            raise script.Refused("pip ended")

    monkeypatch.setattr(script, "install", install)
    with pytest.raises(script.Refused):
        script.make(tmp_path / "venv")
    script.make(tmp_path / "venv")
    assert len(installed) == 2


def test_a_folder_of_somebody_else_is_not_touched(tmp_path):
    precious = tmp_path / "venv" / "thesis.tex"
    precious.parent.mkdir()
    precious.touch()
    done = subprocess.run([sys.executable, SCRIPT, precious.parent], capture_output=True, text=True)
    assert done.returncode == 1
    assert "is not a virtual environment" in done.stderr
    assert precious.exists()
