"""The public interface is what ``soft_sim_ros.__all__`` lists: it imports, is typed, documented."""

import ast
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import soft_sim_ros

ROOT = Path(__file__).resolve().parents[2]
PUBLIC = sorted(set(soft_sim_ros.__all__) - {"__version__"})
REFERENCE = (ROOT / "docs" / "api.md").read_text()


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_imports_and_its_parameters_are_typed(name):
    found = getattr(soft_sim_ros, name)
    assert inspect.isclass(found) or inspect.isfunction(found)
    if inspect.isfunction(found):
        signature = inspect.signature(found)
        assert signature.return_annotation is not inspect.Signature.empty
        for parameter in signature.parameters.values():
            assert parameter.annotation is not inspect.Parameter.empty, parameter


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_has_a_docstring_of_numpydoc_that_explains_its_parameters(name):
    found = getattr(soft_sim_ros, name)
    text = inspect.getdoc(found) or ""
    assert text.partition("\n")[0].endswith("."), text
    if inspect.isfunction(found):
        for parameter in inspect.signature(found).parameters:
            assert re.search(rf"\b{parameter}\b", text), f"{name} says nothing of {parameter}"


@pytest.mark.parametrize("name", PUBLIC)
def test_the_reference_lists_every_public_name(name):
    kind = "class" if inspect.isclass(getattr(soft_sim_ros, name)) else "function"
    home = soft_sim_ros._HOME[name]
    assert f".. auto{kind}:: {home}.{name}\n" in REFERENCE


def test_the_reference_lists_nothing_else():
    listed = re.findall(r"^\.\. auto\w+:: (\S+)$", REFERENCE, re.MULTILINE)
    assert sorted(listed) == sorted(f"{home}.{name}" for name, home in soft_sim_ros._HOME.items())


def test_type_checkers_are_told_the_same_homes():
    tree = ast.parse(Path(soft_sim_ros.__file__).read_text())
    told = {
        alias.name: node.module
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("soft_sim_ros.")
        for alias in node.names
    }
    assert told == {**soft_sim_ros._HOME, "__version__": "soft_sim_ros.version"}


def test_importing_the_package_loads_nothing_else():
    code = "import sys, soft_sim_ros; print(*{'numpy', 'numba', 'scipy', 'yaml'} & {*sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
