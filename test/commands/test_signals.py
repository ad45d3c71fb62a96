"""Whatever ends a verb, what it was writing is closed; the exit code names the signal."""

import json
import os
import pty
import signal
import subprocess
import sys
import time

import pytest

from soft_sim_ros.endings import Ended, endings, undisturbed
from soft_sim_ros.recording.reader import read_run

pytestmark = pytest.mark.filterwarnings("error::soft_sim_ros.recording.reader.TornRecordingWarning")
ROLLOUT = (sys.executable, "-m", "soft_sim_ros", "rollout")
# what a shell in a terminal does: the terminal on stdin becomes that of the session
OWN_TERMINAL = """
import fcntl, os, sys, termios
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
os.execv(sys.argv[1], sys.argv[1:])
"""
LONG = ("--duration", "1e5", "--publish-rate", "20")


def wait_for_recording(process, out):
    deadline = time.monotonic() + 200.0
    while not (out / "metadata.yaml").exists():
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.01)


def closed(out, ended_by):
    run = read_run(out)  # a torn one warns, which is an error here
    summary = json.loads((out / "summary.json").read_text())
    assert summary["ended_by"] == ended_by
    assert summary["recording"]["recorded"] == sum(run.counts.values())
    assert summary["recording"]["complete"] and summary["recording"]["dropped"] == 0


@pytest.mark.parametrize(
    ("numbers", "after"),
    [
        ((signal.SIGTERM,), 0.5),
        ((signal.SIGHUP, signal.SIGTERM, signal.SIGHUP), 0.0),
        ((signal.SIGHUP, signal.SIGHUP), 0.5),
        ((signal.SIGINT, signal.SIGINT, signal.SIGTERM), 0.1),
    ],
    ids=["SIGTERM", "at the very start", "SIGHUP twice", "SIGINT twice"],
)
def test_every_ending_closes_the_recording(scene, start, tmp_path, numbers, after):
    process = start(*ROLLOUT, str(scene), *LONG, "--out", str(tmp_path / "out"))
    wait_for_recording(process, tmp_path / "out")
    time.sleep(after)
    for number in numbers:
        process.send_signal(number)
        time.sleep(0.003)
    said, _ = process.communicate(timeout=100)
    assert process.returncode == 128 + numbers[0], said
    assert "Traceback" not in said
    closed(tmp_path / "out", numbers[0].name)


def test_a_closed_terminal_closes_the_recording(scene, start, tmp_path):
    """As with a lost ssh: the terminal is gone, nothing can be written to it."""
    terminal, inside = pty.openpty()
    process = start(
        *(sys.executable, "-c", OWN_TERMINAL, *ROLLOUT, str(scene), *LONG),
        *("--out", str(tmp_path / "out")),
        stdin=inside, stdout=inside, stderr=inside,
    )  # fmt: skip
    os.close(inside)
    wait_for_recording(process, tmp_path / "out")
    time.sleep(0.5)
    os.close(terminal)
    assert process.wait(100) == 128 + signal.SIGHUP
    closed(tmp_path / "out", "SIGHUP")


def test_nohup_stays_deaf_to_a_closed_terminal(scene, start, tmp_path):
    out = tmp_path / "out"
    process = start(
        "sh", "-c", 'trap "" HUP; exec "$@"', "sh", *ROLLOUT, str(scene), *LONG, "--out", str(out)
    )
    wait_for_recording(process, out)
    process.send_signal(signal.SIGHUP)
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    assert process.wait(100) == 128 + signal.SIGTERM
    closed(out, "SIGTERM")


def test_a_signal_while_kernels_compile_ends_it_soon(scene, start, tmp_path):
    out = tmp_path / "out"
    process = start(
        "env", f"NUMBA_CACHE_DIR={tmp_path}", *ROLLOUT, str(scene), *LONG, "--out", str(out)
    )
    while not list(tmp_path.glob("kernels-*")):  # the first is kept, more are being compiled
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGTERM)
    said, _ = process.communicate(timeout=200)
    assert process.returncode == 128 + signal.SIGTERM, said
    assert (
        not out.exists() and "Traceback (most recent call last)" not in said.split("Exception")[0]
    )


def test_a_batch_keeps_what_is_done_when_its_terminal_is_closed(scene, start, tmp_path):
    sweep, out = tmp_path / "sweep.yaml", tmp_path / "out"
    sweep.write_text(
        f"scenes: {scene.name}\nduration: 1e5\nparameters:\n"
        "  materials.rubber.density: [900, 950]\n"
    )
    process = start(*ROLLOUT, "--sweep", str(sweep), "--jobs", "2", "--out", str(out))
    while len(list(out.glob("*/metadata.yaml"))) < 2:
        assert process.poll() is None, process.stdout.read()
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGHUP)
    said, _ = process.communicate(timeout=200)
    assert process.returncode == 128 + signal.SIGHUP, said
    for directory in out.glob("*/"):
        closed(directory, "interrupted")
    assert (out / "results.csv").exists()


@pytest.fixture
def tiny_disk(tmp_path):
    """Give a file system of 300 kB."""
    if os.geteuid() != 0:
        pytest.skip("only root may mount a small file system")
    folder = tmp_path / "tiny"
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", folder], check=True)
    yield folder
    subprocess.run(["umount", "-l", folder], check=True)


def test_a_full_disk_keeps_what_it_has_counts_the_rest_and_says_so(scene, call, tiny_disk, capsys):
    out = tiny_disk / "out"
    arguments = ("--duration", 8, "--publish-rate", 500, "--out", out)
    assert call("rollout", scene, *arguments) == 1
    told = capsys.readouterr().out
    with pytest.warns(UserWarning, match="was never closed"):
        run = read_run(out)
    kept, dropped = sum(run.counts.values()), 5 * 4001 - sum(run.counts.values())
    assert kept > 0 and f"{kept} messages recorded in" in told
    assert f"error: {dropped} messages lost:" in told and "No space left on device" in told
    assert "`recover` makes a clean one" in told


def test_a_signal_waits_for_what_must_not_be_torn():
    done = []
    with pytest.raises(Ended) as caught, endings():
        with undisturbed():
            for number in (signal.SIGHUP, signal.SIGTERM):
                os.kill(os.getpid(), number)
            done.append(1)
        done.append(2)
    assert done == [1] and caught.value.number == signal.SIGHUP
    assert signal.getsignal(signal.SIGHUP) == signal.SIG_DFL


def test_an_ending_that_python_drops_in_a_finaliser_comes_again():
    """Exceptions in ``__del__`` and in callbacks of C are dropped by Python."""
    program = """
import os, signal, time
from soft_sim_ros.endings import Ended, endings

class Finalised:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGTERM)
        for _ in range(1000):
            pass  # the signal is seen here

with endings():
    try:
        Finalised()
        time.sleep(20.0)
    except Ended as ending:
        print(f"ended by {ending}")
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("ended by SIGTERM\n", "")
