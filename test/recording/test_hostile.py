"""What a recording says about itself is not trusted: typed errors or right data, within bounds."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import zstandard
from mcap import records
from mcap.data_stream import RecordBuilder

from soft_sim_ros.errors import RecordingError, SoftSimError
from soft_sim_ros.recording import claims
from soft_sim_ros.recording.bag import Bag, channel
from soft_sim_ros.recording.cdr import JointStateBuffer, PoseArrayBuffer, encode_string
from soft_sim_ros.recording.metadata import Channel
from soft_sim_ros.recording.reader import TornRecordingWarning, read_run
from soft_sim_ros.recording.recover import recover
from soft_sim_ros.recording.scan import MAGIC
from soft_sim_ros.recording.topics import Qos, recorded_topics
from soft_sim_ros.report import export_csv, numbers, picture, plots, write_report

TOPICS = recorded_topics("/soft_arm")
NAMES = ["$\\frac{$", "\x1b[31mred\x07", "two\nlines", "x" * 5000, "<b>&amp;"]
BOMB = "a: &a [x, x]\n" + "".join(
    f"{chr(97 + i)}: &{chr(97 + i)} [*{chr(96 + i)}, *{chr(96 + i)}]\n" for i in range(1, 26)
)


def write(directory: Path, poses=None, names=(), attachments=None, qos=None, metadata=None) -> Path:
    """Write a recording of three states whose every claim can be chosen."""
    channels = [channel(topic) for topic in TOPICS]
    if qos is not None:
        channels = [
            Channel(c.topic, c.type, c.schema, {"offered_qos_profiles": qos}) for c in channels
        ]
    bag = Bag(directory, channels, metadata=metadata or {}, attachments=attachments or {})
    keys = [topic.key for topic in TOPICS]
    for index in range(3):
        values = np.zeros((4, 7)) if poses is None else poses
        data = PoseArrayBuffer("world", 4).fill(index, values)
        bag.add(keys.index("backbone"), index * 1_000_000, data)
        state = JointStateBuffer(list(names)).fill(index, *[np.ones(len(names))] * 3)
        bag.add(keys.index("joint_states"), index * 1_000_000, state)
    bag.add(keys.index("events"), 2_000_000, encode_string("$\\bad{\x1b[2J: \x00"))
    bag.close()
    return directory


@pytest.mark.parametrize(
    "qos",
    ["a: b", "[1, 2]", "[", "\x00", "5", "- [", BOMB, "x" * 2_000_000, "[" * 50_000,
     "- {depth: -5, reliability: 7, durability: {}, history: unknown}",
     "- {depth: 1000000000000, reliability: best, history: keep_some}"],
)  # fmt: skip
def test_qualities_of_service_that_are_none_are_the_default(tmp_path, qos):
    run = read_run(write(tmp_path / "run", qos=qos))
    assert {c.qos for c in run.channels} == {Qos()}
    clean = recover(tmp_path / "run", tmp_path / "clean")
    assert clean.messages == 7
    assert read_run(clean.directory).channels == run.channels


def test_words_that_are_no_text_are_an_error_where_they_are_asked_for(tmp_path):
    scene = b"name: \xff\xfe"
    run = read_run(write(tmp_path / "run", attachments={"scene.yaml": scene}))
    assert len(run.backbone) == 3
    with pytest.raises(RecordingError, match=r"scene.yaml that is no text \(byte 6\)"):
        run.scene_text  # noqa: B018
    with pytest.raises(RecordingError, match="no text"):
        write_report(tmp_path / "run")
    clean = recover(tmp_path / "run", tmp_path / "clean")
    assert read_run(clean.directory).attachments["scene.yaml"] == scene


@pytest.mark.parametrize("late", [2**63, 2**64 - 1])
def test_a_time_that_is_none_costs_one_message(tmp_path, late):
    bag = Bag(tmp_path / "run", [channel(t) for t in TOPICS], metadata={}, attachments={})
    for time_ns in (5, late, 2**63 - 1):
        bag.add(len(TOPICS) - 1, time_ns, encode_string(str(time_ns)))
    bag.close()
    with pytest.warns(TornRecordingWarning, match="1 of its parts cannot be read; read 2 mess"):
        run = read_run(tmp_path / "run")
    assert run.events == [(5, "5"), (2**63 - 1, str(2**63 - 1))]
    clean = recover(tmp_path / "run", tmp_path / "clean")
    assert clean.messages == 2 and clean.damaged_chunks == 1
    assert read_run(clean.directory).events == run.events


@pytest.mark.parametrize(
    ("key", "said"),
    [("poses", "many"), ("poses", "1000000000"), ("poses", "2.5"), ("poses", "1"), ("poses", ""),
     ("poses", "nan"), ("poses", "9" * 5000), ("command_timeout", "-1"), ("command_ramp", "inf"),
     ("command_timeout", "\x1b[2J")],
)  # fmt: skip
def test_facts_that_are_none_are_named(key, said):
    good = dict(node="/a", poses="51", frame_id="w", command_timeout="1", command_ramp="0.5")
    assert claims.facts("run", good) == claims.Facts("/a", 51, "w", 1.0, 0.5)
    with pytest.raises(RecordingError, match=f"run: says {key} = .*: expected a") as caught:
        claims.facts("run", good | {key: said})
    assert str(caught.value).isprintable() and len(str(caught.value)) < 200


@pytest.mark.parametrize(
    "poses", [np.nan, np.inf, 1e300, -1e308, [[np.nan] * 7] * 2 + [[0.5] * 7] * 2]
)
def test_numbers_that_are_none_are_read_as_they_are_and_said(tmp_path, poses):
    directory = write(tmp_path / "run", poses=poses, names=["a"])
    run = read_run(directory)
    np.testing.assert_array_equal(run.backbone.poses[0], np.broadcast_to(poses, (4, 7)))
    page = write_report(directory).read_text()
    finite = np.isfinite(poses).all()
    assert ("3 of the recorded states hold numbers that are not finite" in page) == (not finite)
    with pytest.raises(RecordingError, match="no backbone in it has finite positions"):
        picture(run, tmp_path / "picture.png")


def test_names_from_outside_cannot_draw_or_rewrite_anything(tmp_path):
    scene = b'name: "$\\\\sqrt{ \\x1b[31m"\n'
    machine = '{"processor": "\\u001b[2J", "cores": 5, "kernel": {"a": []}, "recorded": []}'
    attachments = {"scene.yaml": scene, "machine.json": machine.encode()}
    directory = write(tmp_path / "run", names=NAMES, attachments=attachments)
    (directory / "summary.json").write_text('{"ended_by": "\\u001b[31m", "solver": {"\\u0007": 1}}')
    page = write_report(directory).read_text()
    assert page.replace("\n", "").isprintable() and len(page) < 2_000_000
    run = read_run(directory)
    assert list(run.joint_states.name) == NAMES
    assert len(export_csv(run, tmp_path / "tables")) >= 2


@pytest.mark.parametrize(
    "text",
    ["[]", "5", "{", "\xff", "[" * 100_000, '"text"', "null"],
)
def test_summaries_and_machines_that_are_none_are_typed_errors(tmp_path, text):
    data = text.encode("latin-1")
    directory = write(tmp_path / "run", attachments={"machine.json": data})
    with pytest.raises(RecordingError, match=r"holds a machine.json that is"):
        write_report(directory)
    other = write(tmp_path / "other")
    (other / "summary.json").write_bytes(data)
    with pytest.raises(RecordingError, match=r"summary.json: is"):
        write_report(other)


@pytest.mark.parametrize("value", ["null", "[]", "5", '"a"', "{}", "[5]", "1e999", '{"a": null}'])
def test_entries_of_a_summary_that_are_of_another_kind_are_left_out(tmp_path, value):
    directory = write(tmp_path / "run", names=["a"])
    keys = ("real_time_factor", "overruns", "ended_by", "last_error", "recording", "step_cost",
            "solver", "accuracy", "estimate")  # fmt: skip
    parts = [f'"{key}": {value}' for key in keys]
    inner = ("dropped", "histogram", "p50_us", "worst_us", "tolerance", "error_rel")
    entries = ", ".join(f'"{key}": {value}' for key in inner)
    bins = f'{{"from_us": {value}, "to_us": 1, "steps": 1}}'
    nested = f'"step_cost": {{{entries}}}, "recording": {{{entries}}}, "accuracy": {{{entries}}}'
    run = read_run(directory)
    for text in (", ".join(parts), nested, f'"step_cost": {{"histogram": [{bins}]}}'):
        (directory / "summary.json").write_text("{" + text + "}")
        summary = numbers.read_summary(directory)
        rows = numbers.speed_rows(summary) + numbers.accuracy_rows(run, summary)
        assert all(isinstance(word, str) for row in rows for word in row)
        plots.timing(run, summary)


# -- bombs ---------------------------------------------------------------------------------------


def framed(*parts: records.McapRecord) -> bytes:
    builder = RecordBuilder()
    for part in parts:
        part.write(builder)
    return builder.end()


def zeros(count: int) -> bytes:
    """Compress so many bytes of nothing without having them."""
    compressor = zstandard.ZstdCompressor(level=1).compressobj(size=count)
    piece = bytes(1 << 24)
    parts = [compressor.compress(piece[: min(len(piece), count - at)])
             for at in range(0, count, len(piece))]  # fmt: skip
    return b"".join(parts) + compressor.flush()


def bomb(path: Path, *chunks: tuple[bytes, int]) -> Path:
    body = [records.Header("ros2", "bomb")]
    for data, size in chunks:
        body.append(records.Chunk("zstd", data, 0, 0, 0, size))
    path.write_bytes(MAGIC + framed(*body))
    assert path.stat().st_size < 200_000
    return path


CHILD = """
import resource, sys, warnings
resource.setrlimit(resource.RLIMIT_AS, (3 << 29, 3 << 29))
from soft_sim_ros.errors import SoftSimError
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.recording.recover import recover
warnings.simplefilter("ignore")
for path in sys.argv[1:]:
    for use in (read_run, lambda path: recover(path, path + ".clean")):
        try:
            print(use(path))
        except SoftSimError as error:
            print(error)
used = resource.getrusage(resource.RUSAGE_SELF)
# not ru_maxrss, which begins with that of the process that started this one
(peak,) = (line for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(int(peak.split()[1]) << 10, used.ru_utime)
"""


def test_a_few_kilobytes_that_unpack_to_gigabytes_are_refused_within_bounds(tmp_path):
    message = framed(records.Message(1, 0, b"", 0, 0))
    first = framed(
        records.Schema(1, b"string data", "ros2msg", "std_msgs/msg/String"),
        records.Channel(1, "/soft_arm/events", "cdr", {}, 1),
    )
    flood = zstandard.compress(first + message * 1_500_000)
    size = len(first) + 1_500_000 * len(message)
    large = zeros(1 << 29)
    bombs = [
        bomb(tmp_path / "large.mcap", (large, 1 << 29)),
        bomb(tmp_path / "lying.mcap", (large, 1 << 62)),
        bomb(tmp_path / "flood.mcap", (flood, size)),
    ]
    done = subprocess.run(
        [sys.executable, "-c", CHILD, *map(str, bombs)],
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=200,
    )
    assert done.returncode == 0, done.stderr
    *told, used = done.stdout.splitlines()
    peak, seconds = used.split()  # bytes, and s of computing
    assert len(told) == 6 and all("unpacks to more than 128 MiB" in line for line in told), told
    assert float(seconds) < 2 * 3 * 10.0 / 2 and int(peak) < 1 << 30


# -- every kind of damage ------------------------------------------------------------------------


def contents(run):
    series = (run.backbone, run.tip_pose, run.joint_states, run.strain_state, run.energy)
    arrays = [value.tobytes() for one in series for value in vars(one).values()
              if isinstance(value, np.ndarray)]  # fmt: skip
    claims.machine(run.path, run.attachments)
    rows = [(m.time_ns, m.topic, m.type, m.qos, m.data) for m in run.messages()]
    return rows, arrays, run.inputs, run.scene_text, run.metadata, run.attachments, run.channels


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Change a recording in one of many ways."""
    changed = bytearray(data)
    at = int(rng.integers(len(data)))
    if rng.random() < 0.5 and len(data) > 30_000:  # where what describes the rest stands
        at = int(rng.choice([rng.integers(0, 30_000), len(data) - rng.integers(1, 5_000)]))
    at = min(at, len(data) - 9)
    kind = rng.integers(5)
    if kind == 0:
        changed[at] ^= 1 << int(rng.integers(8))
    elif kind == 1:
        changed[at] = int(rng.integers(256))
    elif kind == 2:
        changed[at : at + 8] = int(rng.integers(2**63)).to_bytes(8, "little")
    elif kind == 3:
        changed[at : at + 8] = b"\xff" * 8
    else:
        del changed[at : at + int(rng.integers(1, 9))]
    return bytes(changed)


def test_damage_anywhere_is_a_typed_error_or_said_or_without_consequence(record, tmp_path):
    directory, _ = record("run", steps=120)
    (file,) = directory.glob("*.mcap")
    data, right = file.read_bytes(), contents(read_run(directory))
    rng = np.random.default_rng(9)
    fates = {"said": 0, "harmless": 0}
    for number in range(250):
        file.write_bytes(damaged(data, rng))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                found = contents(read_run(directory))
            except SoftSimError:
                fates["said"] += 1
            else:
                said = any(issubclass(w.category, TornRecordingWarning) for w in caught)
                assert said or found == right, number
                fates["said" if said else "harmless"] += 1
            if number % 10 == 0:
                try:
                    clean = recover(directory, tmp_path / f"clean {number}")
                    assert not read_run(clean.directory).torn
                except SoftSimError:
                    pass
    assert min(fates.values()) > 5, fates


def test_messages_with_any_bytes_in_them_are_a_typed_error_or_what_they_say(record, tmp_path):
    directory, _ = record("run", steps=3)
    original = read_run(directory)
    topics = [one.topic for one in original.channels]
    rng = np.random.default_rng(4)
    refused = 0
    for number in range(60):
        bag = Bag(tmp_path / f"{number}", original.channels, metadata={}, attachments={})
        for message in original.messages():
            data = message.data if rng.random() < 0.7 else damaged(message.data, rng)
            bag.add(topics.index(message.topic), message.time_ns, data)
        bag.close()
        run = read_run(tmp_path / f"{number}")
        for ask in ("backbone", "tip_pose", "joint_states", "strain_state", "energy", "inputs"):
            try:
                getattr(run, ask)
            except SoftSimError:
                refused += 1
    assert 20 < refused < 300
