"""``check`` prints the numbers of the scene, as computed by hand here."""

import math
import re
from importlib import import_module
from pathlib import Path

import pytest


@pytest.fixture
def printed(scene, call, capsys):
    assert call("check", scene) == 0
    return capsys.readouterr().out


def column(printed, name):
    lines = printed.splitlines()
    head = next(line for line in lines if line.startswith("section"))
    row = next(line for line in lines if line.startswith("reed/all"))
    names = re.split(r"\s{2,}", head)
    return float(re.split(r"\s{2,}", row)[names.index(name)])


def test_section_numbers(printed):
    inertia, area = math.pi * 0.01**4 / 4, math.pi * 0.01**2
    shear = 1e6 / 2.9
    assert column(printed, "EI_y N·m²") == pytest.approx(1e6 * inertia, rel=1e-3)
    assert column(printed, "GJ N·m²") == pytest.approx(shear * 2 * inertia, rel=1e-3)
    assert column(printed, "EA N") == pytest.approx(1e6 * area, rel=1e-3)
    assert column(printed, "mass kg") == pytest.approx(1000 * area * 0.3, rel=1e-3)
    assert column(printed, "slenderness") == pytest.approx(0.3 / 0.005, rel=1e-2)


def test_frequencies_size_and_step(printed):
    told = [line for line in printed.splitlines()[4:] if not line.startswith("warning")]
    lines = dict(re.split(r"\s{2,}", line, maxsplit=1) for line in told)
    assert lines["coordinates"] == "4"
    hertz = [float(f) for f in re.findall(r"[\d.]+(?=[, ])", lines["frequencies"])][:4]
    assert hertz == sorted(hertz) and hertz[0] > 0
    assert re.match(r"\d+ KiB", lines["memory"])
    assert lines["step"].startswith("0.002 s")
    assert 0 < float(lines["recommended step"].split()[0]) <= 1 / hertz[2] / 100


def test_a_basis_too_coarse_for_the_weight_of_the_arm_is_doubted(printed):
    # the reed hangs down by itself, and has polynomials of degree 1
    (line,) = (line for line in printed.splitlines() if line.startswith("warning"))
    assert "basis and nodes do not show this state" in line
    (told,) = (line for line in printed.splitlines() if line.startswith("error in space"))
    assert float(re.search(r"([\d.e-]+) at rest", told).group(1)) > 0.01


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        ("radius: 0.012", "radius: 12", "lengths are in m"),
        ("density: 1100.0", "density: 1.1", "densities are in kg/m³"),
        ("young_modulus: 1.0e+6", "young_modulus: 1.0", "moduli are in Pa"),
    ],
)
def test_numbers_that_look_like_another_unit_are_doubted(
    tmp_path, call, capsys, right, wrong, words
):
    text = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    scene = re.search(r"```yaml\n(name: reed.*?)```", text, re.DOTALL).group(1)
    good, bad = tmp_path / "good.yaml", tmp_path / "bad.yaml"
    good.write_text(scene)
    bad.write_text(scene.replace(right, wrong))
    assert right in scene
    assert call("check", good) == 0
    assert "warning" not in capsys.readouterr().out
    call("check", bad)
    assert words in capsys.readouterr().out


def test_the_internal_wrench_is_drawn(scene, call, capsys, tmp_path):
    assert call("check", scene, "--wrench", tmp_path / "wrench.png") == 0
    assert "wrench.png (in the equilibrium" in capsys.readouterr().out
    assert (tmp_path / "wrench.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(("step", "told"), [("0.002", False), ("0.2", True)])
def test_a_step_much_longer_than_recommended_is_doubted(tmp_path, call, capsys, step, told):
    text = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    scene = re.search(r"```yaml\n(name: reed.*?)```", text, re.DOTALL).group(1)
    path = tmp_path / "reed.yaml"
    path.write_text(scene.replace("step: 0.002", f"step: {step}"))
    rollout = ["rollout", path, "--duration=0.2", "--publish-rate=5", f"--out={tmp_path}/out"]
    for words in (["check", path], rollout):
        assert call(*words) == 0
        said = "".join(capsys.readouterr())
        assert (f"warning: numerics.step = {step} s is" in said) == told


def test_numerics_that_were_chosen_are_not_surveyed_again(capsys, monkeypatch):
    """The search has looked at statics and motion already, and knows what they are off by."""
    module = import_module("soft_sim_ros.commands.check")
    monkeypatch.setattr(module, "survey", lambda *_: pytest.fail("a second look"))
    assert module.main(["loaded_beam"]) == 0
    said = capsys.readouterr().out
    assert "numerics          chosen, none are written: " in said
    assert "error of the tip  " in said and "error in space" not in said


def test_limits_at_which_no_state_of_rest_is_found_are_told(printed, tmp_path, call, capsys):
    """No estimate is made for them, so "at the limits" would promise too much."""
    assert "not found" not in printed
    arm = (Path(__file__).parents[1] / "node" / "arm.yaml").read_text()
    absurd = re.sub(r"limits: \[[^\]]*\]", "limits: [-1.0e+20, 1.0e+20]", arm)
    assert absurd != arm
    (tmp_path / "absurd.yaml").write_text(absurd)
    assert call("check", tmp_path / "absurd.yaml") == 0
    line = next(s for s in capsys.readouterr().out.splitlines() if s.startswith("error in space"))
    assert re.search(r"at the limits of loads and actuators \(\d of these states .* found\)", line)
