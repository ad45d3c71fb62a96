"""The example of a lock-step co-simulation computes what one program computes alone."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from peer import ROOT, Program

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.scene import load_scene

FILE = ROOT / "examples" / "co_simulation.py"
SCENE = Path(__file__).with_name("arm.yaml")


def test_two_programs_in_lock_step_compute_what_one_does(tmp_path):
    example = runpy.run_path(str(FILE))
    period = example["PERIOD_NS"]
    simulation = Simulation(load_scene(SCENE))
    inputs, motors = Inputs(simulation, 1.0, 0.5), example["Motors"](2)
    largest = 0.0
    for time_ns in range(0, 2_000_000_001, period):
        inputs.advance((time_ns - simulation.time_ns) // simulation.step_ns)
        position, velocity, _ = simulation.ports()
        largest = max(largest, abs(position[0]))
        motors.step(time_ns * 1e-9, position, velocity)
        inputs.take(inputs.effort_order(motors.torque))
    assert largest > 0.05
    program = Program(tmp_path, (str(FILE),), "--seconds", "2", "--scene", str(SCENE))
    assert program.wait(300.0) == 0, program.text
    found = re.search(r"(\d+) rounds in .*joint 0: ([\d.]+) rad", program.text)
    assert found, program.text
    assert int(found[1]) == 201
    # a torque taken up one round later moves the largest angle by more than the last digit
    assert float(found[2]) == pytest.approx(largest, abs=6e-5)
    assert "Traceback" not in program.text


def test_the_motors_of_the_example_have_the_lag_they_say():
    example = runpy.run_path(str(FILE))
    motors = example["Motors"](1)
    for _ in range(5):  # 50 ms, one time constant
        motors.step(0.0, np.array([-1.0]), np.array([0.0]))
    assert motors.torque[0] == pytest.approx(example["STIFFNESS"] * (1.0 - np.exp(-1.0)))
