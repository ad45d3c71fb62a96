"""A recovery that is killed at any moment can be begun again, and nothing is lost by it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from shutil import copytree

import pytest

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.bag import Bag, channel
from soft_sim_ros.recording.cdr import encode_string
from soft_sim_ros.recording.find import PENDING
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.recording.recover import recover
from soft_sim_ros.recording.topics import recorded_topics

# For each line "source, out, due" it forks a copy that recovers, and dies at its due-th change of
# the disk, before it or after it; answers with the number of changes, or with -1 of one that died.
# A process of its own, with one thread: copies of a process with many may wait for ever.
SERVER = """
import os, signal, sys
from soft_sim_ros.recording.recover import recover

def dying(change, count, due):
    def changed(*arguments, **options):
        count[0] += 1
        if count[0] == due:
            os.kill(os.getpid(), signal.SIGKILL)
        result = change(*arguments, **options)
        if count[0] == -due:
            os.kill(os.getpid(), signal.SIGKILL)
        return result
    return changed

def recovered(source, out, due):
    count = [0]
    for name in ("rename", "replace", "mkdir", "rmdir", "unlink", "pwrite", "fsync"):
        setattr(os, name, dying(getattr(os, name), count, due))
    try:
        recover(source, out)
    finally:
        return count[0]

for line in sys.stdin:
    source, out, due = line.rstrip("\\n").split("\\t")
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.write(writing, str(recovered(source, out, int(due))).encode())
        os._exit(0)
    os.close(writing)
    said = os.read(reading, 100).decode()
    os.close(reading)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    print(said if status == 0 else "-1" if status == -signal.SIGKILL else f"status {status}",
          flush=True)
"""


def rows(run):
    return [(m.time_ns, m.topic, m.data) for m in run.messages()]


@pytest.fixture
def torn(tmp_path, monkeypatch):
    """Give a torn recording of two files with a summary beside it, and what is whole in it."""
    directory, topics = tmp_path / "run", recorded_topics("/soft_arm")
    monkeypatch.setattr("soft_sim_ros.recording.bag.SPLIT_COMMITS", 3)
    scene = {"scene.yaml": b"name: torn"}
    bag = Bag(directory, [channel(t) for t in topics], metadata={"a": "b"}, attachments=scene)
    for index in range(4):
        bag.add(len(topics) - 1, index, encode_string(f"event {index}"))
        bag.commit()
    bag.abandon()
    monkeypatch.undo()
    assert len(list(directory.glob("*.mcap"))) == 2
    (directory / "summary.json").write_text('{"kept": true}')
    with pytest.warns(UserWarning, match="was never closed"):
        whole = rows(read_run(directory))
    assert len(whole) == 4
    return directory, whole


def all_that_was(folder: Path) -> set[bytes]:
    return {file.read_bytes() for file in folder.rglob("*.mcap")}


@pytest.fixture
def killed(start):
    """Recover in a process that dies at a change; give the number of changes, or -1 if it died."""
    server = start(sys.executable, "-c", SERVER, stdin=subprocess.PIPE, stderr=None)

    def killed(source: Path, out: Path, due: int) -> int:
        server.stdin.write(f"{source}\t{out}\t{due}\n")
        server.stdin.flush()
        return int(server.stdout.readline())

    yield killed
    server.stdin.close()
    assert server.wait(10) == 0


@pytest.mark.parametrize("where", ["in place", "elsewhere"])
def test_killed_at_any_change_of_the_disk_it_can_be_done_again(torn, tmp_path, killed, where):
    original, whole = torn
    untouched = all_that_was(original)
    due, kills = 0, 0
    while True:
        due = -due if due > 0 else 1 - due  # before and after every change
        folder = tmp_path / f"{where} {due}"
        source = Path(copytree(original, folder / "run"))
        out = source if where == "in place" else folder / "clean"
        made = killed(source, out, due)
        if 0 <= made < abs(due):
            break
        kills += made < 0
        # nothing pretends to be the recording while its files are on their way
        if (out / PENDING).exists():
            with pytest.raises(
                RecordingError, match=r"its recovery was cut short: `recover .*run|"
            ):
                read_run(out)
        try:
            recover(source, out)
        except RecordingError as error:
            assert "already holds a recording" in str(error)  # it had been done
            assert not (out / PENDING).exists() and where == "elsewhere"
        run = read_run(out)
        assert not run.torn and rows(run) == whole, due
        assert untouched <= all_that_was(folder), f"{due}: the originals are still there"
        left = {file.name for file in out.iterdir() if file.name.startswith(".")}
        assert left <= {f"{PENDING}.new"}, due
        assert (out / "summary.json").read_text() == '{"kept": true}'
    assert kills > 20


def test_recovering_a_whole_recording_in_place_changes_nothing(record):
    directory, written = record(steps=50)
    before = {file.name: file.read_bytes() for file in directory.iterdir()}
    result = recover(directory, directory)
    assert (result.messages, result.torn, result.backup) == (len(written), False, None)
    assert {file.name: file.read_bytes() for file in directory.iterdir()} == before


def test_one_of_several_files_is_not_recovered_in_place(torn):
    directory, _ = torn
    with pytest.raises(RecordingError, match="is one of several files: give the directory"):
        recover(directory / "run_0.mcap", directory)


@pytest.mark.parametrize(
    "plan",
    [
        b"{", b"[]", b"\xff", b"null", b"{}", b"[" * 100_000,
        {"originals": ["../run_0.mcap"], "clean": [], "backup": "torn", "result": {}},
        {"originals": [], "clean": ["/etc/passwd"], "backup": None, "result": {}},
        {"originals": ["run_0.mcap"], "clean": [], "backup": "../torn", "result": {}},
        {"originals": 1, "clean": [], "backup": None, "result": {}},
    ],
)  # fmt: skip
def test_a_plan_from_somebody_else_moves_nothing(record, plan):
    directory, _ = record("run", steps=3)
    if isinstance(plan, dict):
        keys = ("messages", "counts", "last_time", "torn", "damaged_chunks")
        plan["result"] = dict.fromkeys(keys, 0)
        plan = json.dumps(plan).encode()
    (directory / PENDING).write_bytes(plan)
    before = sorted(directory.rglob("*"))
    with pytest.raises(RecordingError, match="is no plan of a recovery"):
        recover(directory, directory)
    assert sorted(directory.rglob("*")) == before


def test_a_full_disk_leaves_the_original_and_no_rubbish(torn, tmp_path, monkeypatch):
    directory, _ = torn
    untouched = all_that_was(directory)

    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "pwrite", full)
        for out in (directory, tmp_path / "clean"):
            with pytest.raises(RecordingError, match="cannot be written: No space left"):
                recover(directory, out)
    assert all_that_was(tmp_path) == untouched and not (tmp_path / "clean").exists()
    assert recover(directory, directory).backup == directory / "torn"
