"""``colcon build`` makes of this tree what ``ros2 run`` needs, plain and with symlinks."""

import os
import re
import shutil
import sys
from pathlib import Path

import pytest

from soft_sim_ros.commands import VERBS

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ("LICENSE", "package.xml", "setup.py", "setup.cfg", "resource", "config", "launch",
           "viewers", "soft_sim_ros")  # fmt: skip


@pytest.fixture
def workspace(tmp_path):
    source = tmp_path / "ws" / "src" / "soft_sim_ros"
    source.mkdir(parents=True)
    ignore = shutil.ignore_patterns("__pycache__")
    for name in SOURCES:
        entry = ROOT / name
        if entry.is_dir():
            shutil.copytree(entry, source / name, ignore=ignore)
        else:
            shutil.copy2(entry, source / name)
    return tmp_path / "ws"


@pytest.fixture
def run(start, workspace):
    pytest.importorskip("colcon_core", reason="colcon is not installed")
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    environment |= {"PATH": path}

    def run_in(folder, command):
        process = start("bash", "-ec", command, cwd=folder, env=environment)
        said, _ = process.communicate(timeout=100)
        assert process.returncode == 0, said
        return said

    return run_in


def readme_build() -> str:
    """Give the block of the README that builds in a workspace."""
    page = (ROOT / "README.md").read_text()
    return re.search(r"^```bash\n# in the workspace\n(.*?)^```", page, re.MULTILINE | re.DOTALL)[1]


def test_it_is_taken_for_an_ament_python_package(run, workspace):
    assert "(ros.ament_python)" in run(workspace, "colcon list")


@pytest.mark.parametrize("option", ["", " --symlink-install"])
def test_the_workspace_has_executables_scenes_and_code(run, workspace, tmp_path, option):
    build = readme_build().replace("colcon build", f"colcon build{option}")
    run(workspace, build)
    prefix = workspace / "install" / "soft_sim_ros"
    programs = {path.name for path in (prefix / "lib" / "soft_sim_ros").iterdir()}
    assert programs >= set(VERBS)
    assert (prefix / "share" / "soft_sim_ros" / "launch" / "simulate.launch.py").exists()
    said = run(
        tmp_path,
        f'source "{workspace}/install/setup.bash"; '
        f'"{prefix}/lib/soft_sim_ros/check" --help; '
        "python3 -c \"import soft_sim_ros as s; print(s.__file__, s.load_scene('soft_arm').file)\"",
    )
    assert said.startswith("usage: check")
    assert said.splitlines()[-1].count(str(workspace)) == 2
