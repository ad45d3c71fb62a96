"""Kernels compiled by several processes end up on disk, whatever becomes of the processes."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress

import pytest

from soft_sim_ros.core.backend import together

# Compiles three small units with an empty folder; argv: a Python interpreter for the helpers.
SCRIPT = """
import json, os, sys, warnings
import numpy as np
from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.backend import together
from soft_sim_ros.core.backend.jit import signature_of

os.sched_getaffinity = lambda _: {0, 1}
sys.executable = sys.argv[1]
names = []
together.listeners.append(names.append)
x, square, whole = np.zeros(6), np.zeros((4, 4)), np.zeros((6, 6))
calls = [(se3._exp, x, square), (se3._stumpff, 1.0), None, (se3._tangent, x, whole)]
with warnings.catch_warnings(record=True) as warned:
    warnings.simplefilter("always")
    together.compile_together(calls)
for unit, *arguments in filter(None, calls):
    unit(*arguments)
units = [(unit, signature_of(arguments)) for unit, *arguments in filter(None, calls)]
try:
    os.waitpid(-1, os.WNOHANG)
    left = True
except ChildProcessError:
    left = False
print(json.dumps({
    "here": [len(unit.overloads) for unit, _ in units],
    "hits": [sum(unit.stats.cache_hits.values()) for unit, _ in units],
    "on disk": [unit._cache.holds(types, unit.targetctx) for unit, types in units],
    "other types": units[0][0]._cache.holds(units[1][1], units[0][0].targetctx),
    "helped": names,
    "warned": [str(one.message) for one in warned],
    "children left": left,
    "same": se3.exp(np.arange(6) / 10).tolist(),
}))
"""


def compiled(folder, interpreter=sys.executable):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, interpreter],
        env=os.environ | {"NUMBA_CACHE_DIR": str(folder)},
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


def test_helpers_compile_a_part_and_leave_nothing_behind(tmp_path):
    first = compiled(tmp_path)
    assert first["on disk"] == [True, True, True] and not first["other types"]
    assert first["here"] == [1, 1, 1]
    # what was not loaded from disk was compiled here; a helper began with what it was given
    assert (sum(first["hits"]) > 0) == bool(first["helped"])
    assert first["warned"] == [] and not first["children left"]
    again = compiled(tmp_path)
    assert again["helped"] == [] and again["hits"] == [1, 1, 1]
    assert again["same"] == first["same"]


@pytest.mark.parametrize(
    ("interpreter", "warning"),
    [("/nowhere/python", "no other process"), ("/bin/true", "ended early")],
)
def test_without_helpers_everything_is_compiled_here(tmp_path, interpreter, warning):
    found = compiled(tmp_path, interpreter)
    assert found["on disk"] == [True, True, True] and found["helped"] == []
    assert len(found["warned"]) == 1 and warning in found["warned"][0]
    assert not found["children left"]


def test_ctrl_c_ends_the_helpers_too(tmp_path):
    """Interrupt the whole group while it compiles, as a terminal does."""
    code = """
import os, sys
os.sched_getaffinity = lambda _: {0, 1}
from soft_sim_ros.core.backend import together
together.listeners.append(lambda name: print(name, flush=True))
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import load_scene
Simulation(load_scene("soft_arm"))
"""
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline()  # a helper is at work
    os.killpg(process.pid, 2)
    _, told = process.communicate(timeout=120)
    assert "KeyboardInterrupt" in told and process.returncode != 0
    deadline = time.monotonic() + 10.0
    while time.monotonic() < deadline:
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)
    pytest.fail("a process is left in the group")


def test_an_interrupt_that_was_dropped_is_heeded_after_the_unit():
    """As numba's callbacks do with one that comes while they run."""
    ctrl_c = together._CtrlC()
    try:
        ctrl_c.heed()
        with suppress(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(1.0)
        with pytest.raises(KeyboardInterrupt):
            ctrl_c.heed()
    finally:
        ctrl_c.leave()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
