"""Integrators that promise more than an order: errors kept, grids left, ledgers closed."""

import numpy as np
import pytest
from scenes import ALL, rod_document, scene_of, zoo_document

from soft_sim_ros.core.mechanics.scipy_adapter import FirstOrder, solve
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import SceneError


def arm(step=0.002, integrator="adaptive", viscosity=2000.0, strains=ALL[:4], **rest):
    """A soft rod that falls in space."""
    options = rest.pop("options", {})
    return rod_document(
        radius=0.02,
        strains=strains,
        order=2,
        gravity=(1.0, 3.0, -9.0),
        material={"viscosity": viscosity},
        numerics={
            "basis": {"order": 2}, "step": step, "integrator": integrator, "options": options,
        },
        **rest,
    )  # fmt: skip


def path(simulation, steps, every=1):
    """Return the states (T, 2n) that a simulation goes through, weighed as tip displacements."""
    states, weight = [], np.tile(simulation.model.weight, 2)
    for _ in range(steps // every):
        simulation.advance(every)
        states.append(np.concatenate([simulation.q, simulation.v]) * weight)
    return np.array(states)


@pytest.fixture(scope="module")
def fall():
    """States every 8 ms of the fall, by Radau on the same equations of motion."""
    simulation = Simulation(scene_of(arm()))
    times = 0.008 * np.arange(41)
    q, v = solve(simulation.dynamics, times, simulation.q, simulation.v, rtol=1e-10)
    return np.concatenate([q, v], axis=1)[1:] * np.tile(simulation.model.weight, 2)


def test_adaptive_error_is_proportional_to_what_is_asked_for(fall):
    asked = np.array([1e-4, 1e-5, 1e-6, 1e-7])
    n = fall.shape[1] // 2
    found = []
    for error in asked:
        simulation = Simulation(scene_of(arm(0.008, options={"error": error})))
        found.append(np.abs(path(simulation, 40) - fall)[:, :n].max())
        # the sum of its estimates covers it
        assert found[-1] < simulation.time_error < 300.0 * found[-1]
    slope = np.polyfit(np.log(asked), np.log(found), 1)[0]
    assert abs(slope - 1.0) < 0.25, found


def test_states_between_the_steps_of_the_adaptive_method_have_its_order(fall):
    """Error against the mean step, on a grid that is finer than the steps and not theirs."""
    found, steps = [], []
    for error in (1e-5, 1e-6, 1e-7, 1e-8):
        simulation = Simulation(scene_of(arm(0.001, options={"error": error})))
        states = path(simulation, 320)[7::8]
        found.append(np.abs(states - fall).max())
        steps.append(0.32 / simulation.statistics().steps)
    assert steps[-1] > 0.001  # the grid really is finer
    slope = np.polyfit(np.log(steps), np.log(found), 1)[0]
    assert slope > 3.75, (steps, found)


def test_adaptive_steps_do_not_depend_on_the_grid():
    """A finer grid only shows more of the same motion."""
    coarse, fine = (Simulation(scene_of(arm(step))) for step in (0.008, 0.001))
    states = [path(coarse, 40), path(fine, 320, every=8)]
    np.testing.assert_allclose(states[0], states[1], rtol=0.0, atol=1e-4)
    n = coarse.n_coordinates
    np.testing.assert_allclose(states[0][:, :n], states[1][:, :n], rtol=0.0, atol=5e-6)
    counts = [s.statistics() for s in (coarse, fine)]
    assert abs(counts[0].evaluations - counts[1].evaluations) < 0.2 * counts[0].evaluations


@pytest.mark.parametrize("integrator", ["adaptive", "energy_midpoint", "generalized_alpha"])
def test_grouping_steps_into_calls_changes_no_bit(integrator):
    document = zoo_document()
    document["numerics"] |= {"integrator": integrator}
    one, two = (Simulation(scene_of(document)) for _ in range(2))
    for simulation, groups in ((one, [60, 60]), (two, [1, 2, 3, 4, 50, 7, 53])):
        simulation.set_efforts([0.1, 0.2, 5.0, 3.0])
        done = 0
        for steps in groups:
            simulation.advance(steps)
            simulation.ledger()
            done += steps
            if done == 60:
                simulation.set_efforts([0.05, -0.1, 2.0, 6.0])
    assert one.q.tobytes() == two.q.tobytes() and one.v.tobytes() == two.v.tobytes()
    np.testing.assert_array_equal(one.ledger(), two.ledger())


def test_a_reset_adaptive_run_repeats_its_bits():
    simulation = Simulation(scene_of(zoo_document({}) | {"numerics": {
        "basis": {"order": 2}, "integrator": "adaptive"}}))  # fmt: skip

    def run():
        simulation.set_efforts([0.1, 0.2, 5.0, 3.0])
        simulation.advance(40)
        return simulation.q.tobytes()

    first = run()
    simulation.reset()
    assert run() == first


def test_an_input_that_jumps_cuts_the_pending_step():
    """Efforts that jump every 10 ms: the motion is that of Radau, restarted at every jump."""
    document = arm(0.001, options={"error": 1e-7})
    document["actuators"] = [
        {"moment": "m", "rod": "rod", "section": "s", "strain": "bend_y"},
        {"moment": "n", "rod": "rod", "section": "s", "strain": "torsion"},
    ]
    simulation = Simulation(scene_of(document))
    weight = simulation.model.weight
    q, v = simulation.q.copy(), simulation.v.copy()
    rng = np.random.default_rng(2)
    for _ in range(5):
        efforts = rng.uniform(-0.2, 0.2, 2)
        simulation.set_efforts(efforts)
        simulation.advance(10)
        times = [0.0, 0.005, 0.01]
        qs, vs = solve(simulation.dynamics, times, q, v, efforts=efforts, rtol=1e-9)
        q, v = qs[-1], vs[-1]
        assert np.abs((simulation.q - q) * weight).max() < 2e-6
    assert np.abs(q * weight).max() > 0.01


@pytest.mark.parametrize(
    ("integrator", "most"), [("adaptive", 1e-4), ("energy_midpoint", 1e-13), ("sdirk4", 1e-3)]
)
def test_damped_ledger(integrator, most):
    """Work in, heat out, energy left: with efforts that jump and a dead and a follower load."""
    document = zoo_document()
    document["numerics"] |= {"integrator": integrator}
    simulation = Simulation(scene_of(document))
    rng = np.random.default_rng(1)
    for _ in range(5):
        simulation.set_efforts(rng.uniform(0, 1, 4) * [0.1, 0.2, 5.0, 3.0])
        simulation.advance(30)
        kinetic, elastic, gravity, work, loads, lost, residual = simulation.ledger()
        turned_over = abs(kinetic) + abs(elastic) + abs(gravity) + abs(work) + abs(loads) + lost
        assert lost > 0.0 and abs(residual) < most * turned_over


@pytest.mark.parametrize("strains", [["bend_y", "bend_z"], ALL])
def test_undamped_motion_keeps_its_energy(strains):
    document = arm(0.002, "energy_midpoint", viscosity=0.0, strains=strains)
    simulation = Simulation(scene_of(document))
    largest = 0.0
    for _ in range(20):
        simulation.advance(250)
        kinetic, elastic, gravity, *_, residual = simulation.ledger()
        largest = max(largest, kinetic)
        assert abs(residual) < 1e-12 * (largest + elastic + abs(gravity))
    assert largest > 0.01


@pytest.mark.parametrize("method", ["Radau", "DOP853"])
def test_adaptive_motion_is_that_of_scipy(method):
    document = arm(0.01, strains=["bend_y", "bend_z"], options={"error": 1e-8})
    document["loads"] = [{"point": "p", "body": "rod", "force": [0.0, 0.3, 0.2], "frame": "body"}]
    simulation = Simulation(scene_of(document))
    times = [0.0, 0.1, 0.2]
    q, v = solve(simulation.dynamics, times, simulation.q, simulation.v, method=method, rtol=1e-9)
    for k in (1, 2):
        simulation.advance(10)
        weight = simulation.model.weight
        assert np.abs((simulation.q - q[k]) * weight).max() < 2e-7
        assert np.abs((simulation.v - v[k]) * weight).max() < 2e-6


def test_first_order_jacobian_is_the_derivative():
    system = FirstOrder(scene_of(arm()))
    n = system.dynamics.n
    rng = np.random.default_rng(0)
    scale = np.concatenate([0.2 / system.dynamics.model.weight, 0.5 / system.dynamics.model.weight])
    scale[9:n] *= 0.1
    y, direction = rng.normal(size=(2, 2 * n)) * scale
    h = 1e-6
    numeric = (system(0.0, y + h * direction) - system(0.0, y - h * direction)) / (2 * h)
    exact = system.jacobian(0.0, y) @ direction
    np.testing.assert_allclose(exact, numeric, rtol=1e-5, atol=1e-6 * np.abs(numeric).max())


@pytest.mark.parametrize("error", [0.0, 1.0, -1e-6])
def test_an_error_that_cannot_be_meant_is_refused(error):
    with pytest.raises(SceneError, match=r"options.error"):
        Simulation(scene_of(arm(options={"error": error})))
