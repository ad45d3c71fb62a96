"""A batch makes every run once, whatever becomes of some of them and however often it is begun."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from soft_sim_ros import Simulation, read_run
from soft_sim_ros.batch import read_sweep, run_batch
from soft_sim_ros.batch.workers import WorkerDied, in_processes
from soft_sim_ros.recording.recover import recover

E, L = "materials.rubber.young_modulus", "bodies.reed.sections.tip.length"
GRID = f"parameters:\n  {E}: [1e6, 2e6]\n  efforts.y: [0.0, 0.05]\n"


def call(*arguments):
    return import_module("soft_sim_ros.commands.rollout").main([str(a) for a in arguments])


@pytest.mark.slow
def test_runs_in_processes_are_those_made_here(sweep, tmp_path):
    runs = read_sweep(sweep(GRID))
    results = run_batch(runs, tmp_path / "out", jobs=2)
    assert [result["run"] for result in results] == [run.name for run in runs]
    for run, result in zip(runs, results, strict=True):
        assert result["outcome"] == "completed"
        simulation = Simulation(run.scene())
        simulation.set_efforts([float(run.parameters["efforts.y"])])
        simulation.advance(50)
        recorded = read_run(tmp_path / "out" / run.name)
        np.testing.assert_array_equal(recorded.strain_state.position[-1], simulation.q)
        np.testing.assert_array_equal(result["tip_m"], simulation.sampler(2).poses()[-1, :3])
    with open(tmp_path / "out" / "results.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["efforts.y"]) for row in rows] == [0.0, 0.05, 0.0, 0.05]
    assert [float(row["tip_z"]) for row in rows] == [result["tip_m"][2] for result in results]


def test_what_is_done_is_not_made_again_and_what_was_killed_is(sweep, tmp_path):
    runs, out = read_sweep(sweep(GRID)), tmp_path / "out"
    first = run_batch(runs[:3], out, jobs=1)
    stamp = (out / runs[0].name / "result.json").stat().st_mtime_ns
    (out / runs[1].name / "result.json").unlink()  # what a kill leaves: a recording, no result
    made = []
    results = run_batch(runs, out, jobs=1, progress=lambda d, t, r: r and made.append(r["run"]))
    assert made == [runs[1].name, runs[3].name]
    assert (out / runs[0].name / "result.json").stat().st_mtime_ns == stamp
    assert [r["tip_m"] for r in results[:3]] == [r["tip_m"] for r in first]
    assert read_run(out / f"{runs[1].name}.torn-1").joint_states.time_ns[-1] == 100_000_000


def test_failures_are_typed_outcomes_and_the_rest_goes_on(sweep, tmp_path):
    runs = read_sweep(sweep(f"parameters:\n  {L}: [0.1, -1.0]\n  {E}: [1e6, 1e1]\n"))
    results = run_batch(runs, tmp_path / "out", jobs=2)
    assert [result["outcome"] for result in results[2:]] == ["SceneError", "SceneError"]
    assert f"{L} = -1.0" in results[2]["reason"]
    assert results[0]["outcome"] == "completed"
    assert results[1]["outcome"] in ("completed", "Diverged")
    again = []
    run_batch(runs, tmp_path / "out", progress=lambda d, t, r: r and again.append(r))
    assert again == []  # the same scene would end the same way


def test_a_run_that_knows_it_is_inaccurate_says_so(sweep, tmp_path):
    text = "parameters:\n  numerics.step: [0.001, 0.05]\nmax_error: 0.02\n"
    fine, coarse = run_batch(read_sweep(sweep(text)), tmp_path / "out", jobs=1)
    assert fine["outcome"] == "completed"
    assert 0.0 < fine["error_rel"] < 0.02
    assert coarse["outcome"] == "Inaccurate"
    assert coarse["error_rel"] > 0.02


def test_a_process_that_dies_costs_its_own_task_only():
    tasks = ["__import__('os')._exit(7)", "-1 / 2", "-1 / 1", "1 / 0", "1 / 1"]
    answers = dict(in_processes(eval, [(task,) for task in tasks], 2))
    assert isinstance(answers[0], WorkerDied)
    assert "exit code 7" in str(answers[0])
    assert isinstance(answers[3], ZeroDivisionError)
    assert [answers[n] for n in (1, 2, 4)] == [-0.5, -1.0, 1.0]


def test_a_killed_batch_goes_on(sweep, tmp_path, environment, capsys):
    """SIGKILL to the batch, and to the run that it was making: as a power cut would."""
    file = sweep("parameters:\n  efforts.y: [0.0, 0.01, 0.02]\n")
    file.write_text(file.read_text().replace("0.1\n", "60.0\n", 1))
    out = tmp_path / "out"
    command = [sys.executable, "-m", "soft_sim_ros", "rollout", "--sweep", file, "--out", out]
    command += ["--jobs", "1"]
    process = subprocess.Popen(list(map(str, command)), env=environment, start_new_session=True)
    try:
        limit = time.monotonic() + 60
        while len(list(out.glob("reed-*/*.mcap"))) < 2 and time.monotonic() < limit:
            time.sleep(0.01)
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    done = [path.parent.name for path in out.glob("reed-*/result.json")]
    torn = [path.name for path in out.glob("reed-*") if path.name not in done]
    assert len(done) == 1 and len(torn) == 1
    assert call("--sweep", file, "--out", out, "--jobs", 2) == 0
    assert "3 completed; 1 of them made before" in capsys.readouterr().out
    recovered = recover(out / f"{torn[0]}.torn-1", tmp_path / "recovered")
    assert recovered is not None


def test_ctrl_c_closes_the_recording_and_writes_the_table(sweep, tmp_path, environment):
    file = sweep("parameters:\n  efforts.y: [0.0, 0.01]\n")
    file.write_text(file.read_text().replace("0.1\n", "1e5\n", 1))
    out = tmp_path / "out"
    command = [sys.executable, "-m", "soft_sim_ros", "rollout", "--sweep", file, "--out", out]
    process = subprocess.Popen(
        list(map(str, [*command, "--jobs", "1"])), env=environment, start_new_session=True
    )
    try:
        limit = time.monotonic() + 60
        while not list(out.glob("reed-*/*.mcap")) and time.monotonic() < limit:
            time.sleep(0.05)
        time.sleep(0.5)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
        assert process.wait(60) == 130
    finally:
        if process.poll() is None:
            process.kill()
    assert json.loads((out / "results.json").read_text())["runs"] == []
    (run,) = out.glob("reed-*")
    assert not read_run(run).torn
    assert json.loads((run / "summary.json").read_text())["ended_by"] == "interrupted"


def test_many_scenes_need_no_sweep(scene, tmp_path, capsys):
    other = tmp_path / "stiff.yaml"
    other.write_text(scene.read_text().replace("1.0e+6", "3.0e+6"))
    out = tmp_path / "out"
    assert call(scene, other, "--duration", 0.02, "--out", out, "--estimate") == 0
    assert "2 runs: 2 completed" in capsys.readouterr().out
    runs = json.loads((out / "results.json").read_text())["runs"]
    assert [run["run"].split("-")[0] for run in runs] == ["reed", "stiff"]
    assert all(run["error_rel"] > 0.0 for run in runs)


def test_dask_gives_what_processes_give(sweep, tmp_path):
    pytest.importorskip("distributed")
    runs = read_sweep(sweep(GRID + "  numerics.step: [0.002, -1]\n"))
    here = run_batch(runs, tmp_path / "here", jobs=1)
    there = run_batch(runs, tmp_path / "there", dask="local", jobs=2)
    for one, other in zip(here, there, strict=True):
        assert {**one, "wall_s": 0.0} == {**other, "wall_s": 0.0}


def test_without_dask_the_error_says_what_to_install(scene, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "distributed", None)
    code = call(scene, "--duration", 0.1, "--out", tmp_path / "out", "--dask", "local")
    assert code == 2
    assert "pip install 'soft_sim_ros[batch]'" in capsys.readouterr().err


_PARENT = """
import sys
from soft_sim_ros.batch.workers import in_processes
note = f"open({sys.argv[1]!r}, 'w').write(str(__import__('os').getpid()))"
task = f"[{note}, __import__('time').sleep(600)]"
if __name__ == "__main__":
    list(in_processes(eval, [(task,)], 1))
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks into /proc")
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_no_process_of_a_batch_outlives_it(tmp_path, environment, end):
    """Of a batch that is killed alone, without its children."""
    program, told = tmp_path / "parent.py", tmp_path / "pid"
    program.write_text(_PARENT)
    parent = subprocess.Popen([sys.executable, str(program), str(told)], env=environment)
    try:
        limit = time.monotonic() + 60
        while not (told.exists() and told.read_text()) and time.monotonic() < limit:
            time.sleep(0.05)
        child = Path("/proc", told.read_text())
        assert _runs(child)
    finally:
        parent.send_signal(end)
        parent.wait()
    limit = time.monotonic() + 20
    while _runs(child) and time.monotonic() < limit:
        time.sleep(0.05)
    assert not _runs(child)


def _runs(process):
    """Whether a process is there, and no zombie."""
    try:
        return (process / "stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except FileNotFoundError:
        return False
