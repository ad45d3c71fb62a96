"""Workflows, Dockerfile and pre-commit name what exists, and nothing of anybody's own machine."""

import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
WORKFLOWS = sorted(ROOT.glob(".github/workflows/*.yml"))
NAMES = (
    *("Dockerfile", ".pre-commit-config.yaml", "CITATION.cff", "CONTRIBUTING.md", "Makefile"),
    "docker/entrypoint.sh",
)
FILES = [*WORKFLOWS, *(ROOT / name for name in NAMES)]
TARGETS = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))


def test_there_are_workflows_for_lint_tests_and_docs():
    assert {file.stem for file in WORKFLOWS} >= {"lint", "tests", "docs"}


@pytest.mark.parametrize("file", WORKFLOWS, ids=lambda file: file.stem)
def test_workflows_are_valid_and_call_targets_that_exist(file):
    workflow = yaml.safe_load(file.read_text())
    for job in workflow["jobs"].values():
        assert "runs-on" in job
        for step in job["steps"]:
            assert ("uses" in step) != ("run" in step)
            assert "@" in step.get("uses", "@")
            for target in re.findall(r"\bmake ([\w-]+)", step.get("run", "")):
                assert target in TARGETS


def test_tests_run_on_every_python_that_the_package_takes():
    workflow = yaml.safe_load((ROOT / ".github/workflows/tests.yml").read_text())
    assert workflow["jobs"]["tests"]["strategy"]["matrix"]["python"] == [
        f"3.{minor}" for minor in range(10, 14)
    ]
    assert workflow["jobs"]["jazzy"]["container"] == "ros:jazzy"
    assert any("colcon build" in step.get("run", "") for step in workflow["jobs"]["jazzy"]["steps"])


def test_targets_and_files_that_are_named_to_contributors_exist():
    page = (ROOT / "CONTRIBUTING.md").read_text()
    for target in re.findall(r"`make ([\w-]+)`", page):
        assert target in TARGETS
    for name in re.findall(r"^COPY (?!\.)(\S+)", (ROOT / "Dockerfile").read_text(), re.MULTILINE):
        assert (ROOT / name).exists()


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_nothing_of_anybodys_machine_is_in_them(file):
    text = file.read_text()
    assert not re.search(r"/home/|/Users/|/work/|/root/|localhost:\d|index-url|/tmp/", text)
