"""Verbs end with an exit code and one line, never with a traceback."""

import signal
import sys
import time

import pytest


@pytest.mark.parametrize("verb", ["recover", "report", "rerun"])
def test_a_missing_recording_is_bad_input(verb, call, capsys, tmp_path):
    assert call(verb, tmp_path / "nowhere") == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and str(tmp_path / "nowhere") in error
    assert len(error.strip().splitlines()) == 1


def test_a_bad_scene_is_bad_input_with_its_place(scene, call, capsys):
    scene.write_text(scene.read_text().replace("radius: 0.01", "radius: -0.01"))
    assert call("check", scene) == 2
    error = capsys.readouterr().err
    assert "bodies[0].sections[0].cross_section.radius" in error and "-0.01" in error


def test_an_unreadable_file_is_bad_input(scene, call, capsys, tmp_path):
    out = tmp_path / "out"
    code = call(
        "rollout", scene, "--duration", 1, "--commands", tmp_path / "none.csv", "--out", out
    )
    assert code == 2
    assert capsys.readouterr().err == f"error: {tmp_path}/none.csv: No such file or directory\n"
    assert not out.exists()


@pytest.mark.parametrize(
    ("option", "value"), [("--duration", "0"), ("--poses", "1"), ("--publish-rate", "nan")]
)
def test_bad_numbers_are_refused_by_the_command_line(scene, call, capsys, tmp_path, option, value):
    arguments = {"--duration": "1", "--out": str(tmp_path / "out"), option: value}
    with pytest.raises(SystemExit) as caught:
        call("rollout", scene, *(word for item in arguments.items() for word in item))
    assert caught.value.code == 2
    assert option in capsys.readouterr().err


def test_ctrl_c_closes_the_recording(scene, start, tmp_path, call):
    out = tmp_path / "out"
    process = start(
        sys.executable, "-m", "soft_sim_ros", "rollout", str(scene), "--duration", "1e6",
        "--publish-rate", "20", "--out", str(out),
    )  # fmt: skip
    while not (out.is_dir() and any(out.glob("*.mcap"))):
        assert process.poll() is None, process.stdout.read()
        time.sleep(0.05)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted" in said and "Traceback" not in said
    assert call("rerun", out) == 0


def test_a_reader_that_leaves_early_is_no_error(start, scene):
    command = f'"{sys.executable}" -m soft_sim_ros check "{scene}" | head -1'
    said, _ = start("bash", "-c", command).communicate(timeout=60)
    assert said.endswith("valid\n") and "Traceback" not in said and "Error" not in said


def test_an_unknown_verb_names_the_known_ones(cli):
    done = cli("simulat")
    assert done.returncode == 2
    assert "'simulate'" in done.stderr
