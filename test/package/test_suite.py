"""The suite itself: how its workers share it, and what its files may rely on."""

import ast
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parents[1]


@pytest.fixture
def suite(request):
    """Give the module test/conftest.py, as pytest has loaded it."""
    return request.config.pluginmanager.getplugin(str(TESTS / "conftest.py"))


@pytest.fixture
def domains(suite, monkeypatch):
    """Give the domains of a run with twelve workers."""

    def drawn():
        monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)
        monkeypatch.setenv("ROS_DOMAIN_ID", str(first := suite.domain()))
        found = [first]
        for worker in range(12):
            monkeypatch.setenv("PYTEST_XDIST_WORKER", f"gw{worker}")
            found.append(suite.domain())
        return found

    return drawn


def test_every_worker_has_a_domain_of_its_own(domains):
    for _ in range(50):
        found = domains()
        assert len(set(found)) == len(found)
        assert all(0 < domain <= 101 for domain in found)  # what every system has ports for


def test_programs_that_talk_over_dds_never_run_two_at_a_time(suite):
    chains = {suite._chain(f"test/{name}::test") for name in (
        "node/test_node_topics.py", "node/test_node_clock.py", "package/test_readme.py",
    )}  # fmt: skip
    assert len(chains) == 1
    assert suite._chain("test/core/test_plane.py::test[a]") not in chains


def test_the_tests_of_a_file_stay_in_one_worker(suite):
    one, other = (f"test/core/test_plane.py::test_{name}" for name in "ab")
    assert suite._chain(one) == suite._chain(other) != suite._chain("test/core/test_time.py::test")


def test_no_file_changes_the_module_path_or_imports_from_tests():
    """What is shared lies in modules of its own; pyproject.toml says where modules are."""
    found = []
    for file in sorted(TESTS.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            elif isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            bad = [name for name in names if name.rpartition(".")[2].startswith("test_")]
            if isinstance(node, ast.Attribute) and ast.unparse(node) == "sys.path":
                bad.append("sys.path")
            found += [f"{file.relative_to(TESTS)}:{node.lineno}: {name}" for name in bad]
    assert found == []
