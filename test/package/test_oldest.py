"""`make test-oldest` runs with exactly the versions that setup.py allows at least."""

import importlib.util
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "tools")
    spec = importlib.util.spec_from_file_location("oldest_script", ROOT / "tools" / "oldest.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yield module
    sys.modules.pop("environment", None)


def test_everything_the_package_needs_is_taken_at_its_lower_bound(script):
    page = (ROOT / "setup.py").read_text()
    block = re.search(r"^REQUIRES = \[\n(.*?)^\]", page, re.MULTILINE | re.DOTALL)[1]
    declared = dict(re.findall(r'"([\w-]+)>=([\d.]+),<', block))
    assert {"numpy", "scipy", "numba", "llvmlite", "PyYAML", "matplotlib"} < set(declared)
    bounds = script.lower_bounds()
    assert {name: bounds[name] for name in declared} == declared


def test_only_the_tools_that_no_test_imports_are_left_out(script):
    page = (ROOT / "setup.py").read_text()
    block = re.search(r'^    "test": \[\n(.*?)^    \]', page, re.MULTILINE | re.DOTALL)[1]
    named = set(re.findall(r'"([\w-]+)>=', block))
    assert named - set(script.lower_bounds()) == set(script.NOT_NEEDED)


def test_an_environment_that_is_there_is_left_alone_until_a_bound_moves(
    script, monkeypatch, tmp_path
):
    commands = []
    monkeypatch.setattr(script, "version_of", lambda python: "3.10")

    def run(command, **options):
        commands.append(command)
        if "venv" in command:
            (tmp_path / "venv").mkdir()
            (tmp_path / "venv" / "pyvenv.cfg").touch()
        return script.subprocess.CompletedProcess(command, 0)

    monkeypatch.setattr(script.subprocess, "run", run)
    script.make(tmp_path / "venv", ["python3.10"])
    assert len(commands) == 2
    script.make(tmp_path / "venv", ["python3.10"])
    assert len(commands) == 2
    monkeypatch.setattr(script, "lower_bounds", lambda: {"numpy": "1.26.5"})
    script.make(tmp_path / "venv", ["python3.10"])
    assert len(commands) == 4
    assert (tmp_path / "venv" / "constraints.txt").read_text() == "numpy==1.26.5\n"


def test_a_python_that_the_oldest_numba_does_not_know_is_refused(script, monkeypatch, tmp_path):
    monkeypatch.setattr(script, "version_of", lambda python: "3.12")
    with pytest.raises(SystemExit, match=r"need Python 3\.10 or 3\.11"):
        script.make(tmp_path / "venv", ["python3"])


def test_a_folder_of_somebody_else_is_not_removed(script, monkeypatch, tmp_path):
    (tmp_path / "thesis.tex").touch()
    monkeypatch.setattr(script, "version_of", lambda python: "3.11")
    with pytest.raises(SystemExit, match="is not a virtual environment"):
        script.make(tmp_path, ["python3"])
    assert (tmp_path / "thesis.tex").exists()
