"""A rollout records what the node would, and applies commands exactly where it says."""

import json

import numpy as np

from soft_sim_ros import Simulation, load_scene, read_run
from soft_sim_ros.scene import parse_scene


def test_commands_act_from_the_step_boundary_they_are_recorded_at(recording, scene):
    run = read_run(recording)
    assert [entry.time_ns for entry in run.commands] == [100_000_000, 146_000_000, 200_000_000]
    simulation = Simulation(load_scene(scene))
    simulation.advance(50)
    simulation.set_efforts([0.05, 0.0])
    simulation.advance(23)
    simulation.set_efforts([0.05, -0.02])
    simulation.advance(27)
    simulation.set_efforts([0.0, 0.1])  # 0.5 N·m is beyond the limit
    simulation.advance(100)
    np.testing.assert_array_equal(run.strain_state.position[-1], simulation.q)
    np.testing.assert_array_equal(run.strain_state.velocity[-1], simulation.v)


def test_commands_do_not_time_out(scene, call, tmp_path):
    commands = tmp_path / "once.csv"
    commands.write_text("time,y\n0,0.05\n")
    call("rollout", scene, "--duration", 3, "--commands", commands, "--out", tmp_path / "out")
    assert read_run(tmp_path / "out").joint_states.effort[-1, 0] == 0.05


def test_states_are_recorded_at_the_rate_asked_for_and_at_the_end(scene, call, tmp_path):
    out = tmp_path / "out"
    call("rollout", scene, "--duration", 0.09, "--publish-rate", 50, "--poses", 7, "--out", out)
    run = read_run(out)
    assert run.backbone.time_ns.tolist() == [0, 20_000_000, 40_000_000, 60_000_000, 80_000_000,
                                             90_000_000]  # fmt: skip
    assert run.backbone.poses.shape == (6, 7, 7)
    for series in (run.joint_states, run.strain_state, run.energy, run.tip_pose):
        np.testing.assert_array_equal(series.time_ns, run.backbone.time_ns)


def test_the_recording_holds_its_scene_and_a_summary(recording, scene):
    assert read_run(recording).scene_text == scene.read_text()
    summary = json.loads((recording / "summary.json").read_text())
    assert summary["ended_by"] == "duration"
    assert summary["simulated_s"] == 0.4
    # 41 instants of 5 topics, and 3 commands
    assert summary["recording"]["recorded"] == 208
    assert summary["recording"]["dropped"] == 0


def test_a_diverging_run_ends_with_a_closed_recording_and_its_reason(scene, call, tmp_path, capsys):
    text = scene.read_text().replace("-0.1, 0.1", "-1.0e+9, 1.0e+9")
    scene.write_text(text)
    commands = tmp_path / "violent.csv"
    commands.write_text("time,y\n0.02,1e6\n")
    out = tmp_path / "out"
    code = call("rollout", scene, "--duration", 0.1, "--commands", commands, "--out", out)
    assert code == 1
    assert "error: at t = 0.02" in capsys.readouterr().err
    run = read_run(out)
    assert not run.torn
    assert run.events[-1][1].startswith("diverged: at t = 0.02")
    assert np.isfinite(run.backbone.poses).all()
    # the last state is that after the command: the step that failed had its effort
    assert run.joint_states.effort[-1, 0] == 1e6
    assert call("rerun", out) == 0
    assert "0 bits different" in capsys.readouterr().out


def test_a_second_run_does_not_touch_the_first(recording, scene, call, capsys):
    before = {file.name: file.read_bytes() for file in recording.iterdir()}
    assert call("rollout", scene, "--duration", 0.1, "--out", recording) == 2
    assert str(recording) in capsys.readouterr().err
    assert {file.name: file.read_bytes() for file in recording.iterdir()} == before


def test_a_rate_that_no_whole_number_of_steps_gives_is_said(scene, call, tmp_path, capsys):
    call("rollout", scene, "--duration", 0.02, "--publish-rate", 300, "--out", tmp_path / "out")
    assert "recorded 250 times per s, not 300" in capsys.readouterr().err
    call("rollout", scene, "--duration", 0.02, "--publish-rate", 125, "--out", tmp_path / "other")
    assert "warning" not in capsys.readouterr().err


def test_a_tolerance_is_met_by_what_the_recording_says(scene, call, tmp_path, capsys):
    text = scene.read_text()
    numerics = text.index("numerics:")
    scene.write_text(text[:numerics] + "numerics: {step: 0.002, tolerance: 1.0e-4}  # mine\n")
    commands = tmp_path / "commands.csv"
    commands.write_text("time,y,z\n0.1,0.05,0\n0.2,0,0.1\n")
    out = tmp_path / "out"
    duration = ("--duration", 0.4, "--commands", commands)
    assert call("rollout", scene, *duration, "--out", out) == 0
    assert "of the length, tolerance 0.0001" in capsys.readouterr().out
    accuracy = json.loads((out / "summary.json").read_text())["accuracy"]
    assert accuracy["tolerance"] == 1e-4
    run = read_run(out)
    basis = "{order: 6, elements: 2, nodes: 20}"
    finer = f"numerics: {{step: 2.0e-5, integrator: sdirk3, basis: {basis}}}\n"
    scene.write_text(text[:numerics] + finer)
    call("rollout", scene, *duration, "--out", tmp_path / "finer")
    exact = read_run(tmp_path / "finer").tip_pose.positions
    error = np.linalg.norm(run.tip_pose.positions - exact, axis=1).max() / 0.3
    assert 0.5 * error < accuracy["error_rel"] < 1e-4
    capsys.readouterr()
    # the recording names the choice, so the same bits come without a search
    chosen = parse_scene(run.scene_text).numerics
    assert chosen.tolerance == 1e-4 and not chosen.free and chosen.integrator == "adaptive"
    assert call("rerun", out) == 0
    assert "0 bits different" in capsys.readouterr().out


def test_a_tolerance_that_cannot_be_met_begins_no_recording(scene, call, tmp_path, capsys):
    text = scene.read_text().replace("step: 0.002", "tolerance: 1.0e-6")
    scene.write_text(text.replace("basis: {", "basis: {elements: 1, "))
    out = tmp_path / "out"
    assert call("rollout", scene, "--duration", 0.2, "--out", out) != 0
    error = capsys.readouterr().err
    assert "numerics.tolerance = 1e-06 is not met" in error and "bend_y 1" in error
    assert not out.exists()
