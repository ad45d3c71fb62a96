"""Whatever happens to the process, what was written stays readable and can be made clean."""

from __future__ import annotations

import time
import warnings
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.reader import TornRecordingWarning, read_run
from soft_sim_ros.recording.recover import recover
from soft_sim_ros.recording.scan import MAGIC, scan

WRITER = """
import sys, time
import numpy as np
from soft_sim_ros.recording.cdr import PoseArrayBuffer, encode_floats
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter

directory, close = sys.argv[1], sys.argv[2] == "leave"
scene = {"scene.yaml": b"name: killed"}
bag = BagWriter(directory, recorded_topics("/soft_arm"), attachments=scene)
buffer = PoseArrayBuffer("world", 51)
rng = np.random.default_rng(0)
print("ready", flush=True)
started = time.monotonic_ns()
index = 0
while not close or index < 50:
    # time of day in place of simulation time: it tells how much a kill has cost
    now = time.monotonic_ns() - started
    bag.write("backbone", now, buffer.fill(index, rng.random((51, 7))))
    bag.write("command", now, encode_floats([index]))
    print(now, flush=True)
    index += 1
    time.sleep(0.002)
"""


@pytest.mark.parametrize("lifetime", [0.4, 0.93, 1.61, 2.2])
def test_sigkill_costs_at_most_the_last_second(child, tmp_path: Path, lifetime: float) -> None:
    process = child(WRITER, tmp_path / "killed", "stay")
    assert process.stdout.readline() == "ready\n"
    time.sleep(lifetime)
    process.kill()
    last_written = int(process.communicate()[0].splitlines()[-1])

    with pytest.warns(TornRecordingWarning, match="was never closed; read .* messages, the last"):
        run = read_run(tmp_path / "killed")
    assert run.torn and run.scene_text == "name: killed"
    assert last_written - run.backbone.time_ns[-1] < 1_000_000_000
    # no message in between is missing: the commands count themselves
    assert [int(c.message.data[0]) for c in run.commands] == list(range(len(run.commands)))
    assert len(run.backbone) - len(run.commands) in (0, 1)

    clean = recover(tmp_path / "killed")
    assert clean.directory == tmp_path / "killed_recovered" and clean.torn
    with Reader(clean.directory) as reader:
        rows = [(time, c.topic, bytes(data)) for c, time, data in reader.messages()]
    assert rows == [(m.time_ns, m.topic, m.data) for m in run.messages()]
    assert clean.messages == len(rows) and clean.last_time == run.end


def test_leaving_without_close_closes(child, tmp_path: Path) -> None:
    process = child(WRITER, tmp_path / "left", "leave")
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, "")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = read_run(tmp_path / "left")
    assert len(run.backbone) == len(run.commands) == 50


def test_a_file_cut_anywhere_gives_a_whole_beginning(record, tmp_path: Path) -> None:
    directory, written = record("cut", 300)
    whole = (directory / "cut_0.mcap").read_bytes()
    torn = tmp_path / "torn_0.mcap"

    @settings(max_examples=60)
    @given(st.integers(0, len(whole) - 1), st.binary(max_size=40))
    def cut(at: int, tail: bytes) -> None:
        torn.write_bytes(whole[:at] + tail)
        if at < len(MAGIC):  # nothing, or nothing that could be told from another file
            try:
                assert scan(torn).messages == []
            except RecordingError as error:
                assert "is not an MCAP file" in str(error)
            return
        found = scan(torn)
        rows = [(time_ns, found.channels[i].topic, bytes(d)) for time_ns, i, d in found.messages]
        assert rows == written[: len(rows)]
        assert found.torn or rows == written

    cut()


def test_a_damaged_chunk_costs_only_itself(record, tmp_path: Path) -> None:
    directory, written = record(steps=3000)
    file = directory / "swing_0.mcap"
    data = bytearray(file.read_bytes())
    with file.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    chunk = chunks[len(chunks) // 2]
    middle = chunk.chunk_start_offset + chunk.chunk_length // 2
    data[middle : middle + 64] = bytes(64)
    file.write_bytes(data)
    with pytest.warns(TornRecordingWarning, match="is damaged and 1 of its parts cannot be read"):
        run = read_run(directory)
    kept = [(m.time_ns, m.topic, m.data) for m in run.messages()]
    assert len(written) - 1500 < len(kept) < len(written)
    assert kept[-1] == written[-1] and set(kept) < set(written)


def test_recovery_keeps_schemas_qualities_attachments_and_other_files(record) -> None:
    directory, written = record(steps=2000)
    original = read_run(directory)
    file = directory / "swing_0.mcap"
    file.write_bytes(file.read_bytes()[: int(file.stat().st_size * 0.8)] + b"garbage" * 100)
    (directory / "metadata.yaml").unlink()
    (directory / "summary.json").write_text('{"kept": true}')
    clean = recover(directory)
    run = read_run(clean.directory)
    assert not run.torn and 0 < clean.messages < len(written)
    assert run.channels == original.channels
    assert run.attachments == original.attachments and run.metadata == original.metadata
    assert (clean.directory / "summary.json").read_text() == '{"kept": true}'
    with Reader(clean.directory) as reader:
        assert reader.message_count == clean.messages
    assert scan(directory).torn  # the original is as it was


def test_recovery_in_place_keeps_a_backup(record) -> None:
    directory, written = record(steps=2000)
    file = directory / "swing_0.mcap"
    torn = file.read_bytes()[: file.stat().st_size // 2]
    file.write_bytes(torn)
    clean = recover(directory, directory)
    assert clean.backup == directory / "torn"
    assert (clean.backup / "swing_0.mcap").read_bytes() == torn
    run = read_run(directory)
    assert not run.torn
    kept = [(m.time_ns, m.topic, m.data) for m in run.messages()]
    assert kept and kept == written[: len(kept)]
    with Reader(directory) as reader:
        assert reader.message_count == len(kept)


def test_recovery_refuses_to_overwrite(record, tmp_path: Path) -> None:
    directory, _ = record(steps=2)
    recover(directory)
    with pytest.raises(RecordingError, match="already holds a recording"):
        recover(directory)


def test_a_recording_killed_before_its_first_message_is_empty_but_recognised(
    child, tmp_path: Path
) -> None:
    code = WRITER.replace("started = ", "time.sleep(60)\nstarted = ")
    process = child(code, tmp_path / "early", "stay")
    assert process.stdout.readline() == "ready\n"
    process.kill()
    process.wait()
    with pytest.warns(TornRecordingWarning, match="read 0 messages"):
        run = read_run(tmp_path / "early")
    assert run.scene_text == "name: killed"
    assert run.backbone.poses.shape == (0, 0, 7) and run.joint_states.name == ()
    assert (tmp_path / "early" / "metadata.yaml").exists()
