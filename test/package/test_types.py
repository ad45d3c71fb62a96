"""Whoever checks types sees those of the package, installed, as they are."""

import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

pytest.importorskip("mypy")
ROOT = Path(__file__).resolve().parents[2]

USER = """\
from soft_sim_ros import Simulation, load_scene, read_run
from soft_sim_ros.core.simulation.inputs import Inputs

scene = load_scene("soft_arm")
simulation = Simulation(scene)
reveal_type(scene)
reveal_type(simulation)
reveal_type(simulation.q)
reveal_type(simulation.ledger())
reveal_type(simulation.time)
reveal_type(Inputs(simulation, 0.0, 0.0).simulation)
reveal_type(read_run("run"))
simulation.advance("many")
from soft_sim_ros import Simulator
"""
ARRAY = "numpy.ndarray["
EXPECTED = {
    6: 'Scene"',
    7: 'Simulation"',
    8: ARRAY,
    9: ARRAY,
    10: 'float"',
    11: 'Simulation"',
    12: ".reader.",
    13: 'Argument 1 to "advance" of "Simulation" has incompatible type "str"',
    14: 'Module "soft_sim_ros" has no attribute "Simulator"',
}


def test_type_checkers_see_the_types_of_the_installed_package(tmp_path):
    built, empty = tmp_path / "built", tmp_path / "empty"
    command = [sys.executable, "setup.py", "-q", "build", "--build-base", str(tmp_path / "base")]
    subprocess.run([*command, "--build-lib", str(built)], cwd=ROOT, check=True)
    assert (built / "soft_sim_ros" / "py.typed").is_file()
    # an environment with the package in it, and what it needs
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(empty)], check=True)
    python = empty / "bin" / "python"
    version = "python{}.{}".format(*sys.version_info)
    packages = empty / "lib" / version / "site-packages"
    (packages / "built.pth").write_text(f"{built}\n{sysconfig.get_path('purelib')}\n")
    (tmp_path / "user.py").write_text(USER)
    (tmp_path / "mypy.ini").write_text("[mypy]\nignore_missing_imports = true\n")
    mypy = [sys.executable, "-m", "mypy", "--python-executable", str(python), "user.py"]
    told = subprocess.run(mypy, cwd=tmp_path, capture_output=True, text=True).stdout.splitlines()
    said = {int(line.split(":")[1]): line for line in told if line.startswith("user.py:")}
    assert said.keys() == EXPECTED.keys(), told
    for line, expected in EXPECTED.items():
        assert expected in said[line]
    assert not any(line.endswith('is "Any"') for line in said.values()), told
