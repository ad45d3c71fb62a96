"""What ``linearise`` writes is a linear system that scipy reads, about the equilibrium it says."""

import json

import numpy as np
import pytest
from scipy import signal
from scipy.io import loadmat

from soft_sim_ros.core.analysis.linearisation import linearise
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import load_scene


@pytest.fixture
def expected(scene):
    dynamics = Dynamics(load_scene(scene))
    efforts = np.array([0.05, 0.0])
    return linearise(dynamics, equilibrium(dynamics, efforts=efforts), efforts)


def read(path):
    if path.suffix == ".npz":
        return dict(np.load(path))
    if path.suffix == ".json":
        return json.loads(path.read_text())
    content = loadmat(path, squeeze_me=True)
    return {k: v for k, v in content.items() if not k.startswith("__")}


@pytest.mark.parametrize("suffix", [".npz", ".mat", ".json"])
def test_every_format_holds_the_same_system(scene, call, tmp_path, expected, suffix):
    file = tmp_path / "new" / f"reed{suffix}"
    assert call("linearise", scene, "--effort", "y=0.05", "--out", file) == 0
    content = read(file)
    for name in ("A", "B", "C", "D", "q", "efforts", "output"):
        np.testing.assert_allclose(content[name], getattr(expected, name), atol=1e-9, rtol=1e-9)
    for name in ("states", "inputs", "outputs"):
        assert tuple(map(str, content[name])) == getattr(expected, name)
    system = signal.StateSpace(*(np.array(content[name]) for name in "ABCD"))
    assert (np.linalg.eigvals(system.A).real < 0.0).all()


def test_python_control_takes_it(scene, call, tmp_path, expected):
    control = pytest.importorskip("control", reason="python-control is not installed")
    assert np.allclose(control.ss(*expected.matrices).dcgain(), expected.static_gain())


def test_a_sampled_system_says_its_step(scene, call, capsys, tmp_path, expected):
    file = tmp_path / "reed.npz"
    options = ("--effort", "y=0.05", "--sample", "0.01", "--out", file)
    assert call("linearise", scene, *options) == 0
    content = read(file)
    assert content["step"] == 0.01
    np.testing.assert_allclose(content["A"], expected.discrete(0.01).A, atol=1e-9)
    told = capsys.readouterr().out
    assert "sampled every 0.01 s" in told and "damping ratio" in told


def test_a_wrench_along_the_tip_is_another_input(scene, call, tmp_path):
    systems = []
    for frame in ("world", "tip"):
        file = tmp_path / f"{frame}.npz"
        options = ("--effort", "y=0.1", "--wrench-frame", frame, "--out", file)
        assert call("linearise", scene, *options) == 0
        systems.append(read(file))
    world, along = systems
    np.testing.assert_allclose(world["A"], along["A"])
    assert not np.allclose(world["B"][:, 2:], along["B"][:, 2:])


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--effort", "x=1"], "unknown actuator 'x': expected some of y, z"),
        (["--effort", "y=much"], "'y=much': expected NAME=NUMBER"),
        (["--effort", "y=3"], "beyond the limits: y = 3 cut to 0.1"),
    ],
)
def test_bad_efforts_are_refused(scene, call, capsys, options, told):
    assert call("linearise", scene, *options) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize("options", [["--sample", "0"], ["--out", "reed.txt"]])
def test_bad_options_are_refused(scene, call, options):
    with pytest.raises(SystemExit) as end:
        call("linearise", scene, *options)
    assert end.value.code == 2


def test_a_joint_that_is_only_held_is_said_to_drift(call, capsys):
    assert call("linearise", "flexible_manipulator") == 0
    assert "warning: joints held" in capsys.readouterr().out


def test_a_maxwell_branch_is_said_to_be_left_out(scene, call, capsys):
    text = scene.read_text().replace("viscosity: 1000", "maxwell: {ratio: 0.5, time: 0.1}")
    scene.write_text(text)
    assert call("linearise", scene) == 0
    assert "warning: Maxwell branches are left out" in capsys.readouterr().out
