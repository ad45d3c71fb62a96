"""Ctrl-C: state, time and ledger change together or not at all, and soon."""

import os
import signal
import threading
import time

import numpy as np
import pytest
from scenes import rod_document, scene_of

from soft_sim_ros.core.analysis.continuation import follow
from soft_sim_ros.core.analysis.load_path import tip_wrench
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs

SOON = 0.1  # s of this process
TIMES = 24


def scene():
    document = rod_document(
        strains=["bend_y", "bend_z"], order=2, gravity=(0, 1.0, -9.0), material={"viscosity": 300.0}
    )
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.0, 0.02]}]
    return scene_of(document)


@pytest.fixture(scope="module")
def arms():
    return Simulation(scene()), Simulation(scene())


def interrupted(after, work):
    """Do work again and again until a real SIGINT, after some s; return s until it was heeded.

    They are seconds of this process: what other processes take does not count.
    """
    sent = 0.0

    def send():
        nonlocal sent
        time.sleep(after)
        sent = time.process_time()
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=send)
    try:
        thread.start()
        while True:
            work()
    except KeyboardInterrupt:
        heeded = time.process_time()
    thread.join()
    return heeded - sent


def bits(simulation):
    """Return everything that can be read off."""
    parts = (simulation.q, simulation.v, simulation.ledger(), *simulation.ports())
    return (*(part.tobytes() for part in parts), simulation.time_ns)


def delays():
    return np.random.default_rng(4).uniform(0.0, 0.03, TIMES)


def test_an_interrupt_in_one_long_call_is_heeded_at_once_and_leaves_whole_steps(arms):
    arm, other = arms
    index = arm.step_index
    for after in delays():
        assert interrupted(after, lambda: arm.advance(10**9)) < SOON
        other.advance(arm.step_index - other.step_index)
        assert bits(arm) == bits(other)
    assert arm.step_index > index


def test_an_interrupt_among_short_calls_leaves_whole_steps(arms):
    arm, other = arms
    for after in delays():
        interrupted(after, lambda: arm.advance(1))
        other.advance(arm.step_index - other.step_index)
        assert bits(arm) == bits(other)


def test_inputs_go_on_after_an_interrupt_as_if_there_was_none(arms):
    arm, other = arms
    for simulation in arms:
        simulation.reset()
    one, two = (Inputs(simulation, 0.01, 0.5) for simulation in arms)
    for i, after in enumerate(delays()):
        for inputs in (one, two):
            inputs.command([1.0 + i])  # ramps for a while, after its timeout
        interrupted(after, lambda: one.advance(100))
        two.advance(arm.step_index - other.step_index)
        for inputs in (one, two):
            inputs.update()  # the next step's efforts may be held already, or not yet
        assert bits(arm) == bits(other)


def test_a_state_is_set_wholly_or_not_at_all(arms):
    arm, other = arms
    rng = np.random.default_rng(5)
    states = [0.1 * rng.normal(size=(2, arm.n_coordinates)) / arm.model.weight for _ in range(2)]

    def all_of(simulation):
        return bits(simulation)[:-1]

    def work():
        arm.set_state(*states[0])
        arm.reset()
        arm.set_state(*states[1])

    expected = {}
    other.reset()
    for i, state in enumerate(states):
        other.set_state(*state)
        expected[i] = all_of(other)
    other.reset()
    expected["start"] = all_of(other)
    arm.reset()
    for after in delays():
        interrupted(0.1 * after, work)
        assert all_of(arm) in expected.values()


def test_a_search_for_equilibria_can_be_interrupted_and_repeated(arms):
    dynamics = arms[0].dynamics
    wrench = np.array([0.0, 0.0, 0.0, 0.0, 0.3, 0.4])
    path = tip_wrench(dynamics, wrench)

    def branch():
        return follow(dynamics, path, np.zeros(dynamics.n), within=(0.0, 2.0), steps=20)

    expected = equilibrium(dynamics, tip=wrench), branch().q.tobytes()
    for after in delays()[:8]:
        for search in (lambda: equilibrium(dynamics, tip=wrench), branch):
            assert interrupted(after, search) < SOON
    assert equilibrium(dynamics, tip=wrench).tobytes() == expected[0].tobytes()
    assert branch().q.tobytes() == expected[1]
