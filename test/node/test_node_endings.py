"""However a run ends: a closed recording, a summary, a last word and the right exit code."""

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from peer import FAULTY, PROGRAM, Program, simulator, wait_for
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String

from soft_sim_ros.recording.reader import read_run

SCENE = Path(__file__).with_name("arm.yaml")
pytestmark = pytest.mark.filterwarnings("error::soft_sim_ros.recording.reader.TornRecordingWarning")


def summary_of(record):
    return json.loads((record / "summary.json").read_text())


def faulty(monkeypatch, tmp_path, fault, after=0.2, **parameters):
    monkeypatch.setenv("FAULT", fault)
    monkeypatch.setenv("AFTER", str(after))
    return simulator(tmp_path, program=FAULTY, scene=SCENE, record=tmp_path / "run", **parameters)


@pytest.mark.parametrize(
    "signals",
    [(signal.SIGINT,), (signal.SIGTERM,), (signal.SIGINT, signal.SIGINT, signal.SIGTERM)],
    ids=["SIGINT", "SIGTERM", "two SIGINT and a SIGTERM"],
)
def test_a_signal_leaves_a_closed_recording_and_a_summary(tmp_path, signals):
    record = tmp_path / "run"
    program = simulator(tmp_path, scene=SCENE, record=record, publish_rate=100)
    time.sleep(1.0)
    for number in signals:
        program.send(number)
        time.sleep(0.005)
    assert program.wait() == 0, program.text
    run = read_run(record)
    assert not run.torn
    summary = summary_of(record)
    assert summary["ended_by"] == signals[0].name
    assert summary["recording"]["recorded"] == sum(run.counts.values())
    assert summary["recording"]["dropped"] == 0
    # State messages: one at the beginning and one every 10 ms since.
    assert len(run.backbone.time_ns) == int(summary["simulated_s"] * 100 + 1e-6) + 1
    assert summary["real_time_factor"] == pytest.approx(1.0, rel=0.1)
    assert summary["step_cost"]["steps"] == round(summary["simulated_s"] * 1000)
    assert summary["solver"]["steps"] >= summary["step_cost"]["steps"]
    assert summary["last_error"] is None
    last_line = program.text.strip().splitlines()[-1]
    assert f"ended by {signals[0].name} at t = " in last_line
    assert f"{sum(run.counts.values())} messages recorded" in last_line


def test_a_signal_during_the_start_ends_it_without_a_traceback(tmp_path):
    program = Program(tmp_path, PROGRAM, "--ros-args", "-p", f"scene:={SCENE}")
    program.wait_for_text("starting 'test_arm'", 60.0)
    program.send(signal.SIGTERM)
    assert program.wait() == 0, program.text
    assert "Traceback" not in program.text


def test_a_diverging_solver_holds_the_last_good_state_and_a_reset_goes_on(
    monkeypatch, tmp_path, peer
):
    program = faulty(monkeypatch, tmp_path, "diverge", after=1.0, start_paused="true")
    states = peer.listen(JointState, "joint_states", 1000)
    events = peer.listen(String, "soft_arm/events", 1000)
    diagnostics = peer.listen(DiagnosticArray, "/diagnostics")
    assert peer.pause(False).success
    wait_for(lambda: any(m.data.startswith("diverged: at t = 1 s") for m in events), "the event")
    program.wait_for_text("made to fail by the test")

    def status():
        return diagnostics[-1].status[0] if diagnostics else None

    wait_for(lambda: status() and status().level == DiagnosticStatus.ERROR, "an ERROR")
    assert "made to fail by the test" in status().message
    count = len(states)
    last = states[-1].header.stamp
    assert (last.sec, last.nanosec) == (1, 0)
    time.sleep(0.3)
    assert len(states) == count, "held, not run on"
    refused = peer.pause(False)
    assert not refused.success
    assert "~/reset" in refused.message
    assert not peer.trigger("soft_arm/step").success

    assert peer.trigger("soft_arm/reset").success
    wait_for(lambda: states[-1].header.stamp.nanosec > 200_000_000, "the arm to go on")
    wait_for(lambda: status().level != DiagnosticStatus.ERROR, "the error to be over")
    assert program.end() == 0, program.text
    told = [text for _, text in read_run(tmp_path / "run").events]
    assert told[0] == "resume"
    assert told[1].startswith("diverged: at t = 1 s: made to fail")
    assert told[2:] == ["reset", "resume"]
    assert "made to fail" in summary_of(tmp_path / "run")["last_error"]


def test_stopped_while_diverged_is_an_error_to_who_looks_at_the_exit_code(monkeypatch, tmp_path):
    program = faulty(monkeypatch, tmp_path, "diverge")
    program.wait_for_text("~/reset starts again")
    program.send(signal.SIGTERM)
    assert program.wait() == 3
    assert "SIGTERM after the solver gave up at t = 0.2 s" in program.text
    assert not read_run(tmp_path / "run").torn


def test_with_exit_on_error_a_diverging_solver_ends_the_node(monkeypatch, tmp_path):
    program = faulty(monkeypatch, tmp_path, "diverge", exit_on_error="true")
    assert program.wait() == 3
    run = read_run(tmp_path / "run")
    assert run.backbone.time_ns[-1] == 200_000_000
    assert "made to fail" in summary_of(tmp_path / "run")["ended_by"]


def test_an_error_nobody_thought_of_ends_the_node_instead_of_leaving_a_zombie(
    monkeypatch, tmp_path
):
    program = faulty(monkeypatch, tmp_path, "raise")
    assert program.wait() == 1
    assert "ZeroDivisionError: made to fail by the test" in program.text
    assert not read_run(tmp_path / "run").torn
    assert "ZeroDivisionError" in summary_of(tmp_path / "run")["last_error"]


def test_an_arm_that_is_too_slow_runs_slower_and_says_so(monkeypatch, tmp_path, peer):
    program = faulty(monkeypatch, tmp_path, "slow")
    diagnostics = peer.listen(DiagnosticArray, "/diagnostics")
    status = wait_for(
        lambda: next((m.status[0] for m in diagnostics if m.status[0].level == b"\x01"), None),
        "a WARN",
    )
    values = {entry.key: entry.value for entry in status.values}
    assert 0.1 < float(values["real-time factor"]) < 0.3
    assert int(values["overruns"]) > 50
    command = peer.talk(Float64MultiArray, "soft_arm/command")
    states = peer.listen(JointState, "joint_states")
    command.publish(Float64MultiArray(data=[0.1, 0.1]))
    begin = time.monotonic()
    wait_for(lambda: states and list(states[-1].effort) == [0.1, 0.1], "the command to be heard")
    assert time.monotonic() - begin < 1.0, "commands are not starved"
    assert program.end() == 0
    assert summary_of(tmp_path / "run")["overruns"] > 50


def test_an_existing_recording_is_not_overwritten(tmp_path):
    record = tmp_path / "run"
    first = simulator(tmp_path, scene=SCENE, record=record)
    assert first.end() == 0
    before = {path: path.read_bytes() for path in record.iterdir()}
    second = Program(
        tmp_path, PROGRAM, "--ros-args", "-p", f"scene:={SCENE}", "-p", f"record:={record}"
    )
    assert second.wait(60.0) == 2
    assert "already holds a recording" in second.text
    assert {path: path.read_bytes() for path in record.iterdir()} == before


@pytest.fixture
def tiny_disk(tmp_path):
    """Give a file system of 200 kB."""
    if os.geteuid() != 0:
        pytest.skip("only root may mount a small file system")
    folder = tmp_path / "tiny"
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=200k", "tmpfs", folder], check=True)
    yield folder
    subprocess.run(["umount", "-l", folder], check=True)


def test_a_full_disk_is_said_while_running_and_at_the_end_and_the_arm_lives_on(tmp_path, tiny_disk):
    program = simulator(tmp_path, scene=SCENE, record=tiny_disk / "run", publish_rate=200)
    program.wait_for_text("recording is in trouble", 30.0)
    assert program.process.poll() is None
    program.send(signal.SIGINT)
    assert program.wait(60.0) == 1, program.text
    last_line = program.text.strip().splitlines()[-1]
    assert "ERROR" in last_line and "recover" in last_line
