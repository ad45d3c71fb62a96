"""Every kind of actuator: exact tangents, work conjugacy, the coupled Newton system, the ledger."""

import numpy as np
import pytest
from differences import central_difference
from rigged import COMMANDS, LENGTHS, rigged_document
from scenes import random_state, rod_document, scene_of

from soft_sim_ros.core.recursion.elimination import factor, new_system, solve
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.core.simulation.simulation import LEDGER


@pytest.fixture(scope="module")
def dynamics():
    return Dynamics(scene_of(rigged_document()))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("which", [0, 1])
def test_tangents_are_difference_quotients_of_the_residual(dynamics, seed, which):
    state = list(random_state(dynamics, seed))
    exact = dynamics.tangents(*state, efforts=COMMANDS, time=1.0)[which]

    def residual(x):
        moved = [*state]
        moved[which] = x
        return dynamics.inverse_dynamics(*moved, efforts=COMMANDS, time=1.0)

    size = 1e-4 / np.maximum(dynamics.model.weight, 1e-3)
    quotient = central_difference(residual, state[which], size)
    scale = np.sqrt(np.outer(*2 * [np.abs(np.diag(exact)) + 1e-12]))
    assert np.max(np.abs(exact - quotient) / (scale + np.abs(exact))) < 2e-6
    tensions = dynamics.port_efforts(*state[:2], COMMANDS)[LENGTHS]
    assert tensions[0] > 1.0 and tensions[1] > 1.0 and tensions[2] == 0.0


@pytest.mark.parametrize("seed", range(2))
def test_at_rest_the_forces_are_efforts_times_the_gradient_of_positions(dynamics, seed):
    """At rest nothing slips, so this holds for tendons with friction, too."""
    q, _, _ = random_state(dynamics, seed)
    zero = np.zeros(dynamics.n)
    size = 1e-4 / np.maximum(dynamics.model.weight, 1e-3)
    slack = np.zeros_like(COMMANDS)
    slack[LENGTHS] = -1.0
    rest = dynamics.inverse_dynamics(q, zero, zero, efforts=slack)
    for i in range(dynamics.actuators):
        command = slack.copy()
        command[i] = COMMANDS[i]
        force = rest - dynamics.inverse_dynamics(q, zero, zero, efforts=command)
        effort = dynamics.port_efforts(q, zero, command)[i]
        gradient = central_difference(lambda x, i=i: dynamics.ports(x, zero)[0][[i]], q, size)[0]
        tolerance = 1e-8 * np.abs(force).max()
        np.testing.assert_allclose(force, effort * gradient, atol=tolerance)
        assert (effort == 0.0) == (dynamics.compiled.scene.actuators[i].name == "slack")


def test_velocities_are_rates_of_positions(dynamics):
    q, v, _ = random_state(dynamics, 5)
    h = 1e-6
    ahead, behind = dynamics.ports(q + h * v, v)[0], dynamics.ports(q - h * v, v)[0]
    np.testing.assert_allclose(dynamics.ports(q, v)[1], (ahead - behind) / (2 * h), rtol=1e-6)


@pytest.mark.parametrize("alpha", [(1e-6, 1e-3, 1.0), (1e-2, 0.1, 1.0), (1.0, 0.0, 0.0)])
def test_elimination_with_tied_blocks_agrees_with_dense_algebra(dynamics, alpha):
    q, v, a = random_state(dynamics, 2)
    dynamics.residual(q, 0.1 * v, 0.1 * a, dynamics.forcing(COMMANDS))
    matrix = dynamics.last_tangent(alpha)
    system = new_system(dynamics.model)
    assert len(system.left) > 8
    tangent(dynamics.model, dynamics._data, alpha, system)
    assert factor(dynamics.model, system)
    known = np.random.default_rng(1).normal(size=dynamics.n) / dynamics.model.weight
    found = matrix @ known
    solve(dynamics.model, system, found)
    error = np.abs((found - known) * dynamics.model.weight).max()
    assert error < 1e-12 * np.linalg.cond(matrix / np.outer(*2 * [dynamics.model.weight])) + 1e-9


def test_friction_only_takes_power_from_a_tendon_whatever_the_motion(dynamics):
    """What arrives in the arm is T ẏ minus a loss ≥ 0; without friction it is T ẏ."""
    names = [actuator.name for actuator in dynamics.compiled.scene.actuators]
    zero = np.zeros(dynamics.n)
    slack = np.zeros_like(COMMANDS)
    slack[LENGTHS] = -1.0
    for seed in range(20):
        q, v, _ = random_state(dynamics, seed)
        rest = dynamics.inverse_dynamics(q, v, zero, efforts=slack)
        for name, loses in (("rubbing", True), ("table", True), ("straight", False)):
            command = slack.copy()
            command[names.index(name)] = 4.0
            arriving = (rest - dynamics.inverse_dynamics(q, v, zero, efforts=command)) @ v
            spent = 4.0 * dynamics.ports(q, v)[1][names.index(name)]
            size = 1e-10 * np.abs(rest * v).sum()
            assert arriving < spent + size
            assert (spent - arriving > 1e-3 * abs(spent)) == loses


@pytest.mark.parametrize(
    ("integrator", "share"),
    [("sdirk2", 0.01), ("sdirk4", 0.01), ("implicit_midpoint", 1e-3), ("generalized_alpha", 0.03)],
)
def test_all_work_is_in_the_ledger(integrator, share):
    numerics = {"basis": {"order": 1}, "integrator": integrator, "step": 0.001}
    simulation = Simulation(scene_of(rigged_document() | {"numerics": numerics}))
    rng = np.random.default_rng(2)
    high = np.array([0.1, 0.2, 5.0, 3.0, 0.01, 5.0, 0.01, 4.0, 0.01, 3e4])
    for _ in range(10):
        simulation.set_efforts(rng.uniform(0, high))
        simulation.advance(40)
    ledger = dict(zip(LEDGER, simulation.ledger(), strict=True))
    assert abs(ledger["actuator_work"]) > 0.01 and ledger["dissipated"] > 0.01
    assert abs(ledger["residual"]) < share * ledger["dissipated"]


def test_plain_tendons_carry_nothing_of_friction_and_winches():
    document = rod_document()
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.01, 0.0]}]
    simulation = Simulation(scene_of(document))
    assert simulation._work.system.left.size == 0 and simulation._problem.data.station.size == 0
