"""The package says the same about itself everywhere, and what it needs is all declared."""

import ast
import re
import sys
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

import pytest

import soft_sim_ros
from soft_sim_ros.commands import VERBS

ROOT = Path(__file__).resolve().parents[2]
MANIFEST = ElementTree.parse(ROOT / "package.xml").getroot()
# rosdep's key, where it is not python3-<module>: the readers' package brings these along
KEYS = {"mcap": "mcap-ros2-support", "lz4": "mcap-ros2-support", "zstandard": "mcap-ros2-support"}
ON_PYPI = {"yaml": "PyYAML"}
PART_OF = {"mpl_toolkits": "matplotlib"}
# Served where they are there; a plain installation does without.
OPTIONAL = {"tf2_msgs", "simulation_interfaces", "cosseratbench"}


def literals() -> dict[str, object]:
    """Constants of setup.py, read without running it."""
    found = {}
    for node in ast.parse((ROOT / "setup.py").read_text()).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            try:
                found[node.targets[0].id] = ast.literal_eval(node.value)
            except ValueError:
                continue
    return found


def imported_modules() -> set[str]:
    """Top-level modules that the package imports and that come from elsewhere."""
    names: set[str] = set()
    for file in [*ROOT.glob("soft_sim_ros/**/*.py"), *ROOT.glob("launch/*.py")]:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                names |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                names.add(str(node.module).partition(".")[0])
    names = {PART_OF.get(name, name) for name in names}
    return names - set(sys.stdlib_module_names) - {"soft_sim_ros"} - OPTIONAL


def dependencies(*tags: str) -> set[str]:
    return {str(element.text) for tag in tags for element in MANIFEST.iter(tag)}


def test_manifest_is_one_that_colcon_takes_for_an_ament_python_package():
    assert MANIFEST.get("format") == "3"
    assert MANIFEST.findtext("name") == "soft_sim_ros"
    assert MANIFEST.findtext("export/build_type") == "ament_python"
    # colcon silently gives up on a manifest whose address it cannot parse.
    address = MANIFEST.find("maintainer").get("email")
    assert re.fullmatch(r"[-a-zA-Z0-9_%+]+(\.[-a-zA-Z0-9_%+]+)*@[-a-zA-Z0-9%]+(\.\w{2,})+", address)
    assert (ROOT / "resource" / "soft_sim_ros").is_file()
    assert (ROOT / MANIFEST.find("license").get("file")).is_file()


def test_version_is_the_same_everywhere():
    version = soft_sim_ros.__version__
    assert MANIFEST.findtext("version") == version
    assert re.search(r'version="([^"]+)"', (ROOT / "setup.py").read_text())[1] == version
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert cited[1] == version
    newest = re.search(r"^(\d+\.\d+\.\d+) \(", (ROOT / "CHANGELOG.rst").read_text(), re.MULTILINE)
    assert newest[1] == version


@pytest.mark.parametrize("module", sorted(imported_modules()))
def test_every_imported_module_is_declared(module):
    declared = dependencies("depend", "exec_depend")
    assert declared & {KEYS.get(module, module), f"python3-{module}"}
    if (ROOT / "setup.py").read_text().count(f'"{ON_PYPI.get(module, module)}>='):
        return
    # What is not on PyPI by that name must be part of ROS.
    assert module in dependencies("exec_depend")


def test_every_requirement_has_a_lower_and_an_upper_bound():
    constants = literals()
    every = [*constants["REQUIRES"], *(r for extra in constants["EXTRAS"].values() for r in extra)]
    for requirement in every:
        assert re.fullmatch(r"[\w\[\]-]+>=[\d.]+,<[\d.]+", requirement), requirement


def test_the_executables_are_the_verbs():
    assert set(literals()["VERBS"]) == set(VERBS)
    for verb in VERBS:
        assert callable(import_module(f"soft_sim_ros.commands.{verb}").main)
