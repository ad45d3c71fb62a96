"""The benchmarks of real time and of the node measure what they say."""

import importlib

import numpy as np
import pytest

BUSY = "import time\nprint('ready', flush=True)\nt = time.process_time()\n"
BUSY += "while time.process_time() < t + {}: pass\nprint('over', flush=True)\ntime.sleep(60)"


def module(name):
    return importlib.import_module(f"benchmarks.{name}")


def test_errors_fall_with_the_step_and_steps_are_counted(monkeypatch):
    realtime = module("realtime")
    given = next(one for one in realtime.INPUTS if one.hold == 10)
    refined = realtime.arm(
        integrator=realtime.REFINED_METHOD, step=realtime.STEP / realtime.REFINED
    )
    torques = realtime.program(given, refined, 0.1)
    _, reference = realtime.whole(refined, torques, given.hold, realtime.REFINED)
    row = realtime.measured("sdirk2", given, 0.1, reference)
    assert 2.0 <= row["evaluations_per_step"] < 12.0
    assert row["refused"] == 0 and row["times_real_time"] > 0.0
    finer = realtime.arm(integrator="sdirk2", step=realtime.STEP / 2)
    _, tips = realtime.whole(finer, torques, given.hold, 2)
    error = np.linalg.norm(tips - reference, axis=1).max() / finer.length
    assert 0.0 < error < 0.6 * row["error_rel"]
    assert len(realtime.table([row]).splitlines()) == 3


def test_the_cpu_time_of_a_process_is_read_by_thread_too():
    processes = module("node.processes")
    with processes.process(["-c", BUSY.format(0.5)], 1) as one:
        one.wait_for("ready")
        before = one.cpu()
        one.wait_for("over")
        assert one.cpu() - before == pytest.approx(0.5, abs=0.1)
        assert one.threads()["main"] == pytest.approx(one.cpu(), abs=0.05)
    assert one.popen.returncode is not None


def test_a_program_that_ends_too_early_is_told_with_what_it_said():
    processes = module("node.processes")
    command = ["-c", "print('no such thing')"]
    with (
        processes.process(command, 1) as one,
        pytest.raises(RuntimeError, match="no such thing"),
    ):
        one.wait_for("ready")


def test_the_parts_of_a_step_are_found_in_its_times():
    work = np.array([[2, 0], [3, 0], [4, 1], [7, 2]] * 6, dtype=float)
    cpu = 4.0 + work @ [12.0, 115.0] + np.repeat([30.0, 0.0, 5.0, 1.0, 2.0, 9.0], 4)
    found = module("realtime").parts(cpu, work)
    assert list(found.values()) == pytest.approx([4.0, 12.0, 115.0])
