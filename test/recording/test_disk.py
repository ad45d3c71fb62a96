"""A slow or full disk costs messages, which are counted, and nothing else."""

from __future__ import annotations

import errno
import os
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from soft_sim_ros.recording.cdr import PoseArrayBuffer
from soft_sim_ros.recording.mcap_file import Stage
from soft_sim_ros.recording.reader import TornRecordingWarning, read_run
from soft_sim_ros.recording.recover import recover
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter

TOPICS = recorded_topics("/soft_arm")


class Source:
    """Gives incompressible messages of about 3 kB and remembers which were taken."""

    def __init__(self) -> None:
        self._buffer = PoseArrayBuffer("world", 51)
        self._rng = np.random.default_rng(3)
        self._time_ns = 0
        self.taken: list[int] = []
        self.refused = 0
        self.worst = 0.0

    def put(self, bag: BagWriter) -> bool:
        self._time_ns += 1_000_000
        data = self._buffer.fill(self._time_ns, self._rng.random((51, 7)))
        before = time.perf_counter()
        taken = bag.write("backbone", self._time_ns, data)
        self.worst = max(self.worst, time.perf_counter() - before)
        if taken:
            self.taken.append(self._time_ns)
        else:
            self.refused += 1
        return taken


def wait_until(condition, timeout: float = 20.0) -> None:
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, "it did not happen in time"
        time.sleep(0.01)


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """Give a file system of 2 MB."""
    if os.geteuid() != 0:
        pytest.skip("mounting a small file system needs root; the quota test stands in for it")
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", str(disk)]
    done = subprocess.run(mount, capture_output=True, text=True)
    if done.returncode != 0:
        pytest.skip(f"no file system can be mounted here: {done.stderr.strip()}")
    yield disk
    subprocess.run(["umount", "--lazy", str(disk)], check=True)


def test_a_disk_that_is_full_for_a_while_loses_only_what_does_not_fit(small_disk: Path) -> None:
    filler = small_disk / "filler"
    filler.write_bytes(bytes(1_200_000))
    source = Source()
    bag = BagWriter(small_disk / "run", TOPICS, limit_bytes=300_000)
    while not bag.failing:
        source.put(bag)
        time.sleep(0.001)
    while source.refused < 50:
        source.put(bag)
    assert bag.dropped == source.refused and bag.queued_bytes <= 300_000
    assert "No space left on device" in bag.error
    with pytest.warns(TornRecordingWarning):
        during = read_run(small_disk / "run")
    assert len(during.backbone) == bag.written > 0

    filler.unlink()
    # the disk works again before all that waited for it has gone there: room comes after that
    wait_until(lambda: not bag.failing and bag.queued_bytes == 0)
    for _ in range(20):
        assert source.put(bag)
    bag.close()
    assert bag.written == len(source.taken) and bag.dropped == source.refused
    with Reader(small_disk / "run") as reader:  # whole, with no gap where the disk was full
        assert [stamp for _, stamp, _ in reader.messages()] == source.taken


def test_a_disk_that_stays_full_leaves_a_whole_beginning(small_disk: Path, tmp_path: Path) -> None:
    (small_disk / "filler").write_bytes(bytes(1_000_000))
    source = Source()
    bag = BagWriter(small_disk / "run", TOPICS, limit_bytes=300_000)
    while source.refused < 50:
        source.put(bag)
        time.sleep(0.0005)
    bag.close()
    assert bag.written + bag.dropped == len(source.taken) + source.refused
    assert bag.dropped_by_topic == {"/soft_arm/backbone": bag.dropped}
    with pytest.warns(TornRecordingWarning):
        run = read_run(small_disk / "run")
    assert run.backbone.time_ns.tolist() == source.taken[: bag.written]
    clean = recover(small_disk / "run", tmp_path / "clean")
    with Reader(clean.directory) as reader:
        assert reader.message_count == bag.written > 0


QUOTA = """
import resource, sys, time
import numpy as np
from soft_sim_ros.recording.cdr import PoseArrayBuffer
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter

resource.setrlimit(resource.RLIMIT_FSIZE, (700_000, 700_000))
bag = BagWriter(sys.argv[1], recorded_topics("/soft_arm"), limit_bytes=200_000)
buffer, rng = PoseArrayBuffer("world", 51), np.random.default_rng(0)
for index in range(1500):
    bag.write("backbone", index, buffer.fill(index, rng.random((51, 7))))
    time.sleep(0.0003)
bag.close()
print(bag.written, bag.dropped, bag.error)
"""


def test_a_quota_is_survived(child, tmp_path: Path) -> None:
    process = child(QUOTA, tmp_path / "run")
    output, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, "")
    written, dropped, error = output.split(maxsplit=2)
    assert int(written) + int(dropped) == 1500 and int(dropped) > 100
    assert "File too large" in error
    with pytest.warns(TornRecordingWarning):
        run = read_run(tmp_path / "run")
    assert run.backbone.time_ns.tolist() == list(range(int(written)))
    assert int(written) > 100


def test_a_slow_disk_does_not_slow_the_writer_down(tmp_path: Path, monkeypatch) -> None:
    commit = Stage.commit

    def slow(stage: Stage) -> None:
        time.sleep(0.3)
        commit(stage)

    source = Source()
    bag = BagWriter(tmp_path / "run", TOPICS, limit_bytes=500_000)
    monkeypatch.setattr(Stage, "commit", slow)
    fullest = 0
    for _ in range(1000):
        source.put(bag)
        fullest = max(fullest, bag.queued_bytes)
        time.sleep(0.0005)
    assert source.worst < 0.15, "write waited for the disk"
    assert source.refused > 0 and fullest <= 500_000
    monkeypatch.setattr(Stage, "commit", commit)
    bag.close()
    assert bag.error is None
    assert (bag.written, bag.dropped) == (len(source.taken), source.refused)
    assert read_run(tmp_path / "run").backbone.time_ns.tolist() == source.taken


def test_a_disk_that_fails_half_way_through_a_write_leaves_no_trace(
    tmp_path: Path, monkeypatch
) -> None:
    whole = os.pwrite
    failures = iter([True, True, True])

    def half(file: int, data: memoryview, offset: int) -> int:
        if len(data) > 1000 and next(failures, False):
            whole(file, data[: len(data) // 2], offset)
            raise OSError(errno.EIO, "Input/output error")
        return whole(file, data, offset)

    source = Source()
    bag = BagWriter(tmp_path / "run", TOPICS)
    monkeypatch.setattr(os, "pwrite", half)
    for _ in range(300):
        assert source.put(bag)
    wait_until(lambda: bag.error is not None and not bag.failing)
    bag.close()
    assert "Input/output error" in bag.error and bag.dropped == 0
    with Reader(tmp_path / "run") as reader:
        assert [stamp for _, stamp, _ in reader.messages()] == source.taken


def test_a_fault_inside_is_reported_and_everything_after_it_counted(
    tmp_path: Path, monkeypatch
) -> None:
    source = Source()
    bag = BagWriter(tmp_path / "run", TOPICS)

    def broken(*_: object) -> None:
        raise RuntimeError("the compressor broke")

    monkeypatch.setattr("lz4.frame.compress", broken)
    for _ in range(200):
        source.put(bag)
    wait_until(lambda: bag.error is not None)
    wait_until(lambda: not source.put(bag))
    bag.close()
    assert "the compressor broke" in bag.error
    assert bag.written == 0 and bag.dropped == len(source.taken) + source.refused


def test_writing_after_close_is_counted(tmp_path: Path) -> None:
    source = Source()
    bag = BagWriter(tmp_path / "run", TOPICS)
    assert source.put(bag)
    bag.close()
    bag.close()
    assert not source.put(bag)
    assert (bag.written, bag.dropped) == (1, 1)


def test_a_run_faster_than_the_disk_can_wait_for_it(tmp_path: Path) -> None:
    source = Source()
    bag = BagWriter(tmp_path / "run", TOPICS, limit_bytes=100_000)
    for _ in range(2000):
        assert bag.wait_for_room()
        assert source.put(bag)
    bag.close()
    assert (bag.written, bag.dropped) == (2000, 0)


def test_closing_tries_a_failing_disk_again(tmp_path: Path, monkeypatch) -> None:
    source, whole, failures = Source(), os.pwrite, iter([True] * 4)
    bag = BagWriter(tmp_path / "run", TOPICS)
    for _ in range(300):
        assert source.put(bag)

    def failing(*given: object) -> int:
        if next(failures, False):
            raise OSError(errno.EIO, "Input/output error")
        return whole(*given)

    monkeypatch.setattr(os, "pwrite", failing)
    bag.close()
    assert bag.complete and "Input/output error" in bag.error
    assert (bag.written, bag.dropped) == (300, 0)
    assert read_run(tmp_path / "run").backbone.time_ns.tolist() == source.taken
