"""Files from outside cost at most ten seconds and a gigabyte, whatever they are, and say why."""

import os
import subprocess
import sys
import time
import zipfile
from io import BytesIO

import numpy as np
import pytest
from numpy.lib import format as npy

from soft_sim_ros import files
from soft_sim_ros.batch.programme import ProgrammeError, read_programme
from soft_sim_ros.errors import SceneError, UnfitFile
from soft_sim_ros.files import read_npz
from soft_sim_ros.scene import document, parse_scene
from soft_sim_ros.scene.document import MOST_ENTRIES, MOST_TEXT, Document

GIGABYTE, TEN_SECONDS = 1 << 30, 10.0
CHILD = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
from pathlib import Path
from soft_sim_ros.batch.programme import read_programme
from soft_sim_ros.batch.sweep import read_sweep
from soft_sim_ros.experiments.motions import read_motion
from soft_sim_ros.errors import SoftSimError
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.scene import load_scene

path = Path(sys.argv[1])
for read in (
    load_scene, lambda path: read_programme(path, ["a"], [0.0]), read_sweep, read_motion, read_run
):
    try:
        read(path)
    except SoftSimError as error:
        print(f"{type(error).__name__}: {error}")
    else:
        print("read")
used = resource.getrusage(resource.RUSAGE_SELF)
# not ru_maxrss, which begins with that of the process that started this one
(peak,) = (line for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(int(peak.split()[1]) << 10, used.ru_utime + used.ru_stime)
"""


def bounded(path):
    """Read a file as everything it could be, with two gigabytes of addresses; give what is said."""
    done = subprocess.run(
        [sys.executable, "-c", CHILD, str(path)],
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=200,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    *said, used = done.stdout.splitlines()
    peak, seconds = used.split()  # bytes, and s of computing: of a busy machine it gets but a part
    assert float(seconds) < TEN_SECONDS and int(peak) < GIGABYTE
    return said


@pytest.fixture(params=["device", "pipe", "directory", "100 MB"])
def odd(request, tmp_path):
    """Give a thing that is no file of a scene, and what should be said of it."""
    path = tmp_path / "odd"
    if request.param == "device":
        return "/dev/zero", "a device"
    if request.param == "pipe":
        os.mkfifo(path)
        return path, "a pipe"
    if request.param == "directory":
        path.mkdir()
        return path, "a directory"
    path.write_bytes(b"time,a\n" + b"0.5,0.25\n" * 11_111_111)
    return path, "has 100000006 bytes"


def test_what_is_no_file_or_too_large_is_refused_by_its_kind(odd):
    path, said = odd
    *told, recording = bounded(path)
    assert len(told) == 4 and all(said in line and str(path) in line for line in told), told
    assert recording.startswith("RecordingError: ")


def aliases(count, depth):
    """Return ``count`` aliases at every level, which stand for count**depth words."""
    lines = ["a0: &a0 [" + ", ".join(["x"] * count) + "]"]
    for level in range(1, depth):
        again = ", ".join([f"*a{level - 1}"] * count)
        lines.append(f"a{level}: &a{level} [{again}]")
    return "\n".join(lines) + "\n"


def merges(count, depth):
    lines = ["m0: &m0 {density: 1}"]
    for level in range(1, depth):
        lines.append(f"m{level}: &m{level}")
        lines += [f"  <<: *m{level - 1}"] * count
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (aliases(30, 8), "aliases and merges that stand for"),
        (merges(26, 9), "aliases and merges that stand for"),
        ("materials:\n" + "".join(f"  {line}\n" for line in merges(26, 12).splitlines()), "stand"),
        ("a: &a {b: *a}\n", "stands for something that holds it"),
        ("a: &a [*a]\n", "stands for something that holds it"),
        ("a: &a {<<: *a}\n", "stands for something that holds it"),
        ("[" * 10_000, "nested too deeply"),
        ("# " + "x" * MOST_TEXT, f"at most {MOST_TEXT} characters"),
    ],
    ids=["aliases", "merges", "below", "self", "self in list", "self merged", "deep", "long"],
)  # fmt: skip
def test_bombs_are_refused_at_once(text, said):
    begin = time.process_time()
    with pytest.raises(SceneError, match=said):
        parse_scene(text, "bomb.yaml")
    assert time.process_time() - begin < TEN_SECONDS


def test_aliases_and_merges_that_stand_for_little_mean_what_they_did():
    text = "m: &m {density: 1, viscosity: 2}\nn: {<<: *m, density: 3}\no: [*m, *m, *m]\n"
    assert Document.parse(text, "fine.yaml").root is not None


def test_the_most_that_may_be_written_is_read_in_time(monkeypatch):
    entries = 6_001  # of the many that may be: it is the ratio that counts
    text = "\n".join(f"k{i}: [0, 1, 2, 3]" for i in range(1_000))
    monkeypatch.setattr(document, "MOST_ENTRIES", entries)
    begin = time.process_time()
    Document.parse(text, "large.yaml")
    assert (time.process_time() - begin) * MOST_ENTRIES / entries < TEN_SECONDS
    with pytest.raises(SceneError, match=f"large.yaml:1001: .*more than {entries} entries"):
        Document.parse(text + "\nmore: 1", "large.yaml")


def npz(path, **members):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return path


def header(shape):
    stream = BytesIO()
    npy.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return stream.getvalue()


def test_arrays_that_unpack_to_too_much_or_promise_it_are_refused(tmp_path, monkeypatch):
    with pytest.raises(UnfitFile, match="promises 80000000000 bytes"):
        read_npz(npz(tmp_path / "a.npz", x=header((10**10,)) + bytes(80)))
    monkeypatch.setattr(files, "MOST_ARRAYS", 1_000_000)
    packed = npz(tmp_path / "b.npz", x=header((250_000,)) + bytes(2_000_000))
    assert packed.stat().st_size < 10_000
    with pytest.raises(UnfitFile, match=r"unpacks to 20001.. bytes: expected at most 1000000"):
        read_npz(packed)
    for content in (b"", b"PK\x03\x04", b"x" * 100):
        (tmp_path / "c.npz").write_bytes(content)
        with pytest.raises(UnfitFile, match=r"is no .npz file"):
            read_npz(tmp_path / "c.npz")
    np.savez_compressed(tmp_path / "d.npz", x=np.arange(3.0))
    assert read_npz(tmp_path / "d.npz")["x"].tolist() == [0.0, 1.0, 2.0]


def test_a_table_that_is_no_table_is_refused(tmp_path):
    path = tmp_path / "commands.csv"
    for content in (b"time,a\n0,\xff\xfe\n", b"time,a\n" + b"9" * 200_000 + b",1\n", b'time,a\n"0'):
        path.write_bytes(content)
        with pytest.raises((UnfitFile, ProgrammeError), match=r"commands.csv.*expected"):
            read_programme(path, ["a"], [0.0])
