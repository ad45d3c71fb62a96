"""Every command, program and scene of the README works, and its tables are true.

Blocks run in the order of the page, in one scratch folder. A block that begins with
``# first terminal, until Ctrl-C`` runs beside the blocks for the ``# second terminal`` after it.
"""

import importlib.util
import json
import os
import re
import shutil
import signal
import sys
from pathlib import Path

import pytest

from soft_sim_ros import Simulation
from soft_sim_ros.scene import parse_scene

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "README.md").read_text()
BLOCKS = re.findall(r"^```(bash|python|yaml)\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
FIRST, SECOND, WORKSPACE = "# first terminal", "# second terminal", "# in the workspace"
STAMP = Path(sys.prefix) / "soft_sim_ros.stamp"


def made_by_make():
    """Whether `make env` has made this environment of what this very tree asks for now.

    The copies of the tree that tests make would otherwise turn it over to themselves.
    """
    spec = importlib.util.spec_from_file_location("environment", ROOT / "tools" / "environment.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    wanted = script.description(script.sourced_jazzy(), tests=True)
    return STAMP.is_file() and STAMP.read_text() == wanted


MADE_BY_MAKE = made_by_make()
START = 300.0  # s; the kernels may have to be compiled


@pytest.fixture
def scratch(tmp_path):
    """Folder that looks like this tree, but in which everything new stays apart from it."""
    folder = tmp_path / "tree"
    folder.mkdir()
    for entry in ROOT.iterdir():
        # The package itself is found as installed: a second path to it would compile it again.
        if entry.name not in {".git", ".venv", "runs", "build", "install", "log", "soft_sim_ros"}:
            (folder / entry.name).symlink_to(entry)
    (folder / ".venv").symlink_to(sys.prefix)
    return folder


@pytest.fixture
def shell(environment, tmp_path):
    """Environment of somebody who has sourced ROS and this package."""
    found = environment | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    prefixes = [os.environ.get("AMENT_PREFIX_PATH"), sys.prefix]
    found["AMENT_PREFIX_PATH"] = os.pathsep.join(filter(None, prefixes))
    if shutil.which("ros2") is None:
        stand_in = tmp_path / "bin" / "ros2"
        stand_in.parent.mkdir()
        stand_in.symlink_to(Path(__file__).with_name("ros2"))
        found["PATH"] = f"{stand_in.parent}:{found['PATH']}"
    return found


def finish(process, block):
    said, _ = process.communicate(timeout=START)
    assert process.returncode == 0, f"{block}\nended with {process.returncode}:\n{said}"
    assert "Traceback" not in said, said
    return said


def until_ready(process):
    said = ""
    for line in process.stdout:
        said += line
        if "ready: " in line:
            return
    raise AssertionError(f"the node ended before it was ready:\n{said}")


@pytest.mark.skipif(not MADE_BY_MAKE, reason="runs in the environment that `make env` makes")
@pytest.mark.slow
@pytest.mark.timeout(600)
def test_every_command_works(start, scratch, shell, tmp_path):
    pytest.importorskip("rclpy", reason="no ROS 2 in this environment")
    beside = None
    settings = {"cwd": scratch, "env": shell}
    for kind, block in BLOCKS:
        if kind == "yaml" or block.startswith(WORKSPACE):
            continue  # each has a test of its own below
        if beside is not None and not block.startswith(SECOND):
            beside.send_signal(signal.SIGINT)
            finish(beside, "first terminal")
            beside = None
        if block.strip() == "make test":
            block = "make -n test"  # these very tests
        if block.startswith(FIRST):
            command = next(line for line in block.splitlines() if not line.startswith("#"))
            beside = start("bash", "-c", f"exec {command}", **settings)
            until_ready(beside)
        elif kind == "bash":
            finish(start("bash", "-euo", "pipefail", "-c", block, **settings), block)
        else:
            finish(start(sys.executable, "-c", block, **settings), block)
    assert beside is None
    demo = json.loads((scratch / "runs" / "latest" / "summary.json").read_text())
    assert demo["simulated_s"] >= 10.0
    assert demo["rerun"]["different"] == 0
    assert demo["recording"]["dropped"] == 0
    assert demo["commands"]["refused"] == 0
    assert demo["replay"]["heard"] == demo["recorded_by_topic"]["/soft_arm/backbone"]
    assert demo["replay"]["in_order"]
    for name in ("motion.png", "report.html", "metadata.yaml"):
        assert (scratch / "runs" / "latest" / name).stat().st_size > 1000


@pytest.mark.parametrize("text", [block for kind, block in BLOCKS if kind == "yaml"])
def test_every_scene_is_valid_and_moves(text):
    simulation = Simulation(parse_scene(text, "README.md"))
    simulation.advance(10)


def rows(heading):
    """Cells of the table under this heading cell."""
    table = re.search(rf"^\| {heading} .*\n\|[-|]+\n((?:\|.*\n)+)", PAGE, re.MULTILINE)[1]
    return [[cell.strip(" `") for cell in line.split("|")[1:-1]] for line in table.splitlines()]


def test_the_table_of_parameters_is_the_nodes():
    parameters = pytest.importorskip(
        "soft_sim_ros.node.parameters", reason="no ROS 2 in this environment"
    )
    told = [(name, default) for name, default, _ in rows("parameter")]
    assert told == [(row.name, str(row.default)) for row in parameters.TABLE]


def test_the_tables_of_topics_are_the_nodes():
    from soft_sim_ros.recording.topics import EVENTS, INPUTS, OUTPUTS

    def short(table):
        return {(name, kind.replace("/msg/", "/")) for name, kind, _ in table.values()}

    told = {(name, kind) for name, kind, _ in rows("published")}
    own = {row for row in told if row[0] not in ("/clock", "/diagnostics")}
    assert own == short(OUTPUTS) | short(EVENTS)
    assert {(name, kind) for name, kind, _ in rows("subscribed")} == short(INPUTS)


def test_every_file_that_is_linked_exists():
    for target in re.findall(r"\]\(([^)#:]+)", PAGE):
        assert (ROOT / target).exists(), target


def test_every_packaged_scene_is_mentioned():
    from soft_sim_ros.scene import packaged_scenes

    for name in packaged_scenes():
        assert f"`{name}`" in PAGE
