"""Parameters of the arm that made a recording are found again from it, noise and all."""

import json

import numpy as np
import pytest

from soft_sim_ros import read_run
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter
from soft_sim_ros.scene.edit import number_at

pytestmark = pytest.mark.slow
SCENE = """\
name: reed
gravity: [0, 0, -9.81]
materials:
  rubber: {young_modulus: 5.0e+6, poisson_ratio: 0.45, density: 1000, viscosity: 1.0e+4}  # truth
bodies:
  - rod: reed
    strains: [bend_y, bend_z]
    sections:
      - {name: all, length: 0.3, material: rubber, cross_section: {shape: circle, radius: 0.01}}
actuators:
  - {moment: y, rod: reed, section: all, strain: bend_y, limits: [-0.1, 0.1]}
  - {moment: z, rod: reed, section: all, strain: bend_z, limits: [-0.1, 0.1]}
numerics:
  step: 0.004
  basis: {order: {bend_y: 1, bend_z: 1}}
"""
TRUTH = {
    "materials.rubber.young_modulus": 5e6,
    "materials.rubber.viscosity": 1e4,
    "materials.rubber.density": 1000.0,
}
GUESSES = {
    "materials.rubber.young_modulus": 3e6,
    "materials.rubber.viscosity": 2.5e4,
    "materials.rubber.density": 1300.0,
}


def asked(guesses):
    return [word for path, guess in guesses.items() for word in ("--parameter", f"{path}={guess}")]


@pytest.fixture
def scene(tmp_path):
    file = tmp_path / "reed.yaml"
    file.write_text(SCENE)
    return file


@pytest.fixture
def long(scene, call, tmp_path):
    """Record a second in which the reed falls, and is bent by known moments."""
    commands = tmp_path / "long.csv"
    commands.write_text("time,y,z\n0,0.05,0\n0.3,0,0.05\n0.6,-0.1,-0.05\n0.8,0.05,0\n")
    directory = tmp_path / "long"
    options = ("--commands", commands, "--publish-rate", 50, "--poses", 5, "--out", directory)
    assert call("rollout", scene, "--duration", 1, *options) == 0
    return directory


def with_noise(recording, directory, size):
    """Copy a recording, with noise of ``size`` m on the positions of the backbone."""
    run = read_run(recording)
    topics = recorded_topics("/soft_arm")
    keys = {topic.name: topic.key for topic in topics}
    rng = np.random.default_rng(5)
    with BagWriter(directory, topics, metadata=run.metadata, attachments=run.attachments) as writer:
        for message in run.messages():
            data = message.data
            if message.topic.endswith("backbone"):
                poses = np.frombuffer(data[-5 * 56 :]).reshape(5, 7).copy()
                poses[:, :3] += size * rng.normal(size=(5, 3))
                data = data[: -5 * 56] + poses.tobytes()
            writer.write(keys[message.topic], message.time_ns, data)
    return directory


def test_stiffness_damping_and_density_come_back_within_their_intervals(
    long, call, capsys, tmp_path
):
    noisy = with_noise(long, tmp_path / "noisy", 1e-3)
    out, results = tmp_path / "fitted.yaml", tmp_path / "fit.json"
    options = (*asked(GUESSES), "--confidence", 0.99, "--out", out, "--json", results)
    assert call("identify", noisy, *options) == 0
    found = json.loads(results.read_text())
    # what is left is the noise
    assert found["rms_m"] == pytest.approx(1e-3, rel=0.1)
    for path, truth in TRUTH.items():
        low, high = found["parameters"][path]["interval"]
        assert low <= truth <= high
        assert high / low < 1.1
        assert number_at(out.read_text(), "out", path) == found["parameters"][path]["value"]
    assert found["unknown"] == []
    told = capsys.readouterr().out
    assert "99 %" in told and "warning" not in told
    assert "&" not in out.read_text() and "{name: all, length: 0.3" in out.read_text()


def test_a_motion_under_weight_alone_does_not_tell_stiffness_from_density(
    scene, call, capsys, tmp_path
):
    """E, η and ρ times the same factor make the same motion: only their ratios can be known."""
    recording, results = tmp_path / "fall", tmp_path / "fit.json"
    options = ("--duration", 1, "--publish-rate", 50, "--poses", 5, "--out", recording)
    assert call("rollout", scene, *options) == 0
    guesses = dict(GUESSES, **{"materials.rubber.density": 1000.0})
    noisy = with_noise(recording, tmp_path / "noisy", 1e-4)
    assert call("identify", noisy, *asked(guesses), "--json", results) == 0
    found = json.loads(results.read_text())
    (direction,) = found["unknown"]
    np.testing.assert_allclose(np.abs(direction), 3**-0.5, atol=0.02)
    assert len(set(np.sign(direction))) == 1
    assert "warning: cannot be told apart along" in capsys.readouterr().out
    values = {path: found["parameters"][path]["value"] for path in TRUTH}
    ratio = values["materials.rubber.young_modulus"] / values["materials.rubber.density"]
    assert ratio == pytest.approx(5000.0, rel=0.01)
    assert all(found["parameters"][path]["interval"] == [0.0, None] for path in TRUTH)


@pytest.mark.parametrize("kind", ["tip.csv", "backbone.csv", "arrays.npz"])
def test_tables_of_a_motion_do_as_well(long, scene, call, tmp_path, kind):
    assert call("report", long, "--csv", tmp_path / "csv", "--npz", tmp_path / "arrays.npz") == 0
    motion = {
        "tip.csv": tmp_path / "csv" / "tip_pose.csv",
        "backbone.csv": tmp_path / "csv" / "backbone.csv",
        "arrays.npz": tmp_path / "arrays.npz",
    }[kind]
    if kind == "tip.csv":  # a camera that misses something, at times that are no steps
        lines = motion.read_text().splitlines()
        lines[20] = lines[20].split(",")[0] + ",,,,,,,"
        motion.write_text("\n".join(lines) + "\n")
    results = tmp_path / "fit.json"
    tables = ("--scene", scene, "--motion", motion, "--commands", tmp_path / "long.csv")
    guesses = {path: GUESSES[path] for path in list(GUESSES)[:1]}
    assert call("identify", *tables, *asked(guesses), "--json", results) == 0
    found = json.loads(results.read_text())
    for path in guesses:
        assert found["parameters"][path]["value"] == pytest.approx(TRUTH[path], rel=1e-4)
    poses = 1 if kind == "tip.csv" else 5
    assert found["observations"] == 3 * (51 * poses - (kind == "tip.csv"))


def test_tables_between_steps_are_met_on_straight_lines(long, scene, call, tmp_path):
    run = read_run(long)
    time = np.linspace(0.0123, 0.9, 70)
    tip = np.array(
        [np.interp(time, run.tip_pose.time, run.tip_pose.positions[:, i]) for i in range(3)]
    )
    motion = tmp_path / "camera.csv"
    rows = ["time,x,y,z"] + [",".join(map(repr, row)) for row in np.vstack([time, tip]).T.tolist()]
    motion.write_text("\n".join(rows) + "\n")
    results = tmp_path / "fit.json"
    tables = ("--scene", scene, "--motion", motion, "--commands", tmp_path / "long.csv")
    stiffness = "materials.rubber.young_modulus"
    options = ("--parameter", f"{stiffness}=4e6", "--json", results)
    assert call("identify", *tables, *options) == 0
    found = json.loads(results.read_text())["parameters"][stiffness]
    assert found["value"] == pytest.approx(5e6, rel=5e-3)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--parameter", "materials.rubber.mass"], "'mass' is not among"),
        (["--parameter", "materials.rubber.density=heavy"], "expected PATH or PATH=NUMBER"),
        (["--parameter", "gravity[0]"], "cannot be fitted from 0: give another first guess"),
        (["--parameter", "materials.rubber.poisson_ratio=0.7"], "expected a number in (-1, 0.5]"),
    ],
)
def test_bad_parameters_are_refused(recording, call, capsys, words, told):
    assert call("identify", recording, *words) in (1, 2)
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ("t,x,y,z\n", "header 't,x,y,z': expected time,x,y,z"),
        ("time,x,y,z\n0,1,2,3\n0,1,2,3\n", ":3: time = 0 s: expected a time above 0 s"),
        ("time,x,y,z\n0,1,2,?\n", ":2: '?': expected a finite number"),
        ("time,x,y,z\n0,1\n", ":2: 2 values: expected at least 4"),
    ],
)
def test_bad_tables_are_refused(scene, call, capsys, tmp_path, table, told):
    motion = tmp_path / "motion.csv"
    motion.write_text(table)
    words = ("--scene", scene, "--motion", motion, "--parameter", "materials.rubber.density")
    assert call("identify", *words) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize("words", [[], ["--scene", "x"], ["run", "--motion", "x.csv"]])
def test_a_recording_or_tables_are_needed_not_both(call, words):
    with pytest.raises(SystemExit) as end:
        call("identify", *words, "--parameter", "gravity[2]")
    assert end.value.code == 2
