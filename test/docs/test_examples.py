"""The examples of these pages run as they stand there, in their order, each page in a folder."""

import re
import shlex
import subprocess
from pathlib import Path

import pytest

from soft_sim_ros.__main__ import main

DOCS = Path(__file__).parents[2] / "docs"
PAGES = (
    "contact",
    "sensors",
    "forest",
    "fluid",
    "state",
    "statics",
    "linearisation",
    "inverse_kinematics",
    "identification",
    "accuracy",
)
RUN = "ros2 run soft_sim_ros "


def blocks(page):
    text = (DOCS / f"{page}.md").read_text()
    return re.findall(r"^```(\w+)\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", PAGES)
def test_every_example_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for number, (kind, block) in enumerate(blocks(page), 1):
        if kind == "yaml":  # a file that says its name first
            Path(re.match(r"# (\S+)\n", block)[1]).write_text(block)
        elif kind == "python":
            exec(compile(block, f"{page}.md, example {number}", "exec"), names)
        else:
            for line in block.replace("\\\n", " ").splitlines():
                if line.startswith(RUN):
                    assert main(shlex.split(line.removeprefix(RUN))) == 0, line
                else:
                    subprocess.run(["bash", "-c", line], check=True)


@pytest.mark.parametrize("page", PAGES)
def test_every_file_that_is_linked_or_named_exists(page):
    text = (DOCS / f"{page}.md").read_text()
    for target in re.findall(r"\]\(([^)#:]+)", text):
        assert (DOCS / target).exists(), target
    for target in re.findall(r"`((?:test|core)/[\w/]+\.py)`", text):
        root = DOCS.parent if target.startswith("test") else DOCS.parent / "soft_sim_ros"
        assert (root / target).exists(), target
