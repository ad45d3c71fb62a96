"""Compiled kernels are run, so what lies in their folder is used only if it is whole and ours."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

# Compiles two small units, or takes them from the folder, and tells which it was.
SCRIPT = """
import json, warnings
import numpy as np
with warnings.catch_warnings(record=True) as warned:
    warnings.simplefilter("always")
    from soft_sim_ros.core.algebra import se3
    from soft_sim_ros.core.backend import disk
    value = se3.exp(np.arange(6) / 10).tolist()
    se3._stumpff(1.0)
units = (se3._exp, se3._stumpff)
print(json.dumps({
    "value": value,
    "folder": str(disk._FOLDER),
    "hits": [sum(unit.stats.cache_hits.values()) for unit in units],
    "warned": [str(one.message) for one in warned],
}))
"""


def run(root, **environment):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env=os.environ | {"NUMBA_CACHE_DIR": str(root)} | environment,
        capture_output=True,
        text=True,
        timeout=200,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """Give a folder with two compiled units, and what compiling them said."""
    root = tmp_path_factory.mktemp("cache") / "root"
    found = run(root)
    assert found["hits"] == [0, 0] and found["warned"] == []
    assert Path(found["folder"]).parent == root
    return root, found


@pytest.fixture
def cache(first, tmp_path):
    """Give a copy of that folder."""
    root, found = first
    copy = tmp_path / "root"
    subprocess.run(["cp", "-a", str(root), str(copy)], check=True)
    return copy, found["value"]


def files(root, suffix):
    found = sorted(root.glob(f"*/*/*{suffix}"))
    assert len(found) >= 2
    return found


def directory(path):
    path.unlink()
    path.mkdir()


def exchanged(path):
    """Put a whole file of another function there."""
    other = next(one for one in files(path.parents[2], path.suffix) if one.name != path.name)
    path.write_bytes(other.read_bytes())


def flipped(path):
    """Change one bit of what would be run, which still unpickles."""
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)


DAMAGES = {
    "truncated": lambda path: path.write_bytes(path.read_bytes()[:-7]),
    "empty": lambda path: path.write_bytes(b""),
    "garbage": lambda path: path.write_bytes(b"\x80\x04garbage" * 50),
    "one bit": flipped,
    "another's": exchanged,
    "directory": directory,
    "writable by others": lambda path: path.chmod(0o666),
    "pipe": lambda path: (path.unlink(), os.mkfifo(path)),
}


def test_damaged_files_are_compiled_again_and_mended(cache):
    root, value = cache
    damages = list(DAMAGES.items())
    for (one, damage), (other, more) in zip(damages, damages[::-1], strict=True):
        damage(files(root, ".nbi")[0])  # of the one function the index, of the other the code
        more(files(root, ".nbc")[-1])
        found = run(root)
        assert found["value"] == value and found["warned"] == [], (one, other)
        assert found["hits"] == [0, 0], (one, other)
    assert run(root)["hits"] == [1, 1], "mended"


def test_a_whole_cache_is_used(cache):
    root, value = cache
    found = run(root)
    assert (found["value"], found["hits"], found["warned"]) == (value, [1, 1], [])


@pytest.mark.parametrize(("part", "mode"), [("root", 0o777), ("folder", 0o775)])
def test_a_folder_that_others_can_write_to_is_not_used(cache, tmp_path, part, mode):
    root, value = cache
    folder = root if part == "root" else next(root.glob("kernels-*"))
    folder.chmod(mode)
    found = run(root, TMPDIR=str(tmp_path))
    assert found["value"] == value and found["hits"] == [0, 0]
    (warning,) = found["warned"]  # once, although two units are loaded
    assert f"{folder} can be written by others (chmod go-w" in warning
    private = Path(found["folder"])
    assert private.is_relative_to(tmp_path) and not private.is_relative_to(root)
    assert private.stat().st_mode & 0o077 == private.parent.stat().st_mode & 0o077 == 0
    assert run(root, TMPDIR=str(tmp_path))["hits"] == [1, 1], "the private one is kept"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a folder away")
@pytest.mark.parametrize("part", ["root", "private"])
def test_a_folder_of_another_user_is_not_used(cache, tmp_path, part):
    root, value = cache
    folder = next(root.glob("kernels-*"))
    os.chown(root if part == "root" else folder, 65534, 65534)
    if part == "private":  # somebody was there first
        (tmp_path / "soft_sim_ros-0").mkdir()
        os.chown(tmp_path / "soft_sim_ros-0", 65534, 65534)
    found = run(root, TMPDIR=str(tmp_path))
    assert found["value"] == value and found["hits"] == [0, 0]
    (warning,) = found["warned"]
    assert "belongs to another user (65534)" in warning
    assert Path(found["folder"]).stat().st_uid == 0
    assert list((tmp_path / "soft_sim_ros-0").glob("*")) == [] or part != "private"


def test_a_folder_that_cannot_be_made_costs_only_the_keeping(tmp_path):
    (tmp_path / "file").write_text("in the way")
    found = run(tmp_path / "file" / "root", TMPDIR=str(tmp_path))
    assert "Not a directory" in found["warned"][0] and len(found["value"]) == 4
