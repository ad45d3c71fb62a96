"""What happens to the files of a node that records: lost terminals, deleted and moved files."""

import json
import shutil
import signal
import time
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from peer import simulator, wait_for
from std_msgs.msg import String

from soft_sim_ros.recording.reader import read_run

SCENE = Path(__file__).with_name("arm.yaml")


def test_a_closed_terminal_leaves_a_closed_recording(tmp_path):
    program = simulator(tmp_path, scene=SCENE, record=tmp_path / "run")
    for number in (signal.SIGHUP, signal.SIGHUP, signal.SIGTERM):
        program.send(number)
        time.sleep(0.005)
    assert program.wait(60.0) == 0, program.text
    run = read_run(tmp_path / "run")
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert not run.torn and summary["ended_by"] == "SIGHUP"
    assert summary["recording"]["recorded"] == sum(run.counts.values())


@pytest.mark.parametrize("loss", ["deleted", "moved", "its directory deleted"])
def test_a_lost_file_is_noticed_within_a_second(tmp_path, peer, loss):
    record = tmp_path / "run"
    # paused: nothing is published meanwhile that could look at the recording
    program = simulator(tmp_path, scene=SCENE, record=record, start_paused="true")
    events = peer.listen(String, "soft_arm/events", 100)
    diagnostics = peer.listen(DiagnosticArray, "/diagnostics")
    assert peer.trigger("soft_arm/step").success
    time.sleep(0.5)
    begin = time.monotonic()
    if loss == "deleted":
        (record / "run_0.mcap").unlink()
    elif loss == "moved":
        (record / "run_0.mcap").rename(tmp_path / "elsewhere.mcap")
    else:
        shutil.rmtree(record)
    said = "was moved away" if loss == "moved" else "was deleted"
    status = wait_for(
        lambda: next((m.status[0] for m in diagnostics if said in m.status[0].message), None),
        "diagnostics",
    )
    lost = wait_for(lambda: [e.data for e in events if "recording_lost" in e.data], "the event")
    wait_for(lambda: said in program.text, "the log")
    assert time.monotonic() - begin < 1.0
    assert len(lost) == 1 and said in lost[0]
    values = {entry.key: entry.value for entry in status.values}
    assert status.level == b"\x02" and values["recording"] == "false"
    assert (values["recorded messages"] == "0") == (loss != "moved")
    assert peer.trigger("soft_arm/step").success  # the arm lives on; what it does is counted
    assert program.end() == 1
    last = program.text.strip().splitlines()[-1]
    if loss == "moved":  # what it holds is whole
        run = read_run(tmp_path / "elsewhere.mcap")
        assert not run.torn and f"{sum(run.counts.values())} messages recorded" in last
    else:
        assert "0 messages recorded" in last and "recover" not in last
        assert not list(tmp_path.rglob("*.mcap"))
