"""A, B, C, D against difference quotients, and against steps of the nonlinear simulation."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import ALL, rod_document, scene_of, zoo_document
from scipy import signal
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.analysis.linearisation import linearise
from soft_sim_ros.core.analysis.modes import complex_modes
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation

EFFORTS = np.array([0.05, -0.02, 3.0, 2.0])
TIP = np.array([0.01, -0.02, 0.03, 0.2, -0.1, 0.15])


@pytest.fixture(scope="module")
def zoo():
    document = zoo_document()
    document["bodies"][3]["stiffness"] = 2.0  # its knee would fall
    dynamics = Dynamics(scene_of(document))
    return dynamics, equilibrium(dynamics, efforts=EFFORTS, tip=TIP)


def difference(function, x, size):
    columns = [
        (function(x + h * e) - function(x - h * e)) / (2 * h)
        for e, h in zip(np.eye(len(x)), size, strict=True)
    ]
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("follows", [False, True])
def test_matrices_are_the_difference_quotients_of_the_motion(zoo, follows):
    dynamics, q = zoo
    n, actuators = dynamics.n, dynamics.actuators
    if follows:
        q = equilibrium(dynamics, efforts=EFFORTS, tip=TIP, tip_follows=True)
    system = linearise(dynamics, q, EFFORTS, 0.0, tip=TIP, tip_follows=follows)
    zero = np.zeros(n)
    mass = dynamics.mass_matrix(q)
    assert np.abs(mass @ system.drift[n:]).max() < 1e-8

    def flow(x, u):
        data = dynamics.forcing(EFFORTS + u[:actuators], 0.0, 1.0, TIP + u[actuators:], follows)
        force = dynamics.residual(x[:n], x[n:], zero, data)
        return np.concatenate([x[n:], -np.linalg.solve(dynamics.mass_matrix(x[:n]), force)])

    x, u = np.concatenate([q, zero]), np.zeros(actuators + 6)
    size = 1e-4 / np.maximum(np.tile(dynamics.model.weight, 2), 1e-3)
    quotient = difference(lambda y: flow(y, u), x, size)
    assert np.abs(system.A - quotient).max() < 1e-5 * np.abs(system.A).max()
    quotient = difference(lambda w: flow(x, w), u, np.full(len(u), 1e-2))
    np.testing.assert_allclose(system.B, quotient, atol=1e-7 * np.abs(system.B).max())

    base = dynamics.node_poses(q)[-1]

    def output(y):
        pose = dynamics.node_poses(y[:n])[-1]
        turn = Rotation.from_matrix(pose[:3, :3] @ base[:3, :3].T).as_rotvec()
        return np.concatenate([pose[:3, 3], turn, *dynamics.ports(y[:n], y[n:])])

    quotient = difference(output, x, size)
    np.testing.assert_allclose(system.C, quotient, atol=2e-6 * np.abs(system.C).max())
    expected = output(x)
    expected[3:6] = 0.0
    np.testing.assert_allclose(system.output, expected, atol=1e-12)


def test_efforts_act_through_the_rates_of_their_ports(zoo):
    """Effort · port rate is power, so Mᵀ-weighted B is Cᵀ: a check on every actuator at once."""
    dynamics, q = zoo
    n, actuators = dynamics.n, dynamics.actuators
    system = linearise(dynamics, q, EFFORTS, tip=TIP)
    forces = dynamics.mass_matrix(q) @ system.B[n:, :actuators]
    rates = system.C[-actuators:, n:]
    np.testing.assert_allclose(forces, rates.T, atol=1e-8 * np.abs(rates).max())


def test_its_poles_are_the_complex_modes(zoo):
    dynamics, q = zoo
    system = linearise(dynamics, q, EFFORTS, tip=TIP)
    poles = np.linalg.eigvals(system.A)
    found = complex_modes(dynamics, q, EFFORTS, tip=TIP).values
    for s in found[:10]:
        assert np.min(np.abs(poles - s)) < 1e-6 * abs(s)


def bent_arm(integrator="sdirk4", step=0.001):
    """A heavy arm bent by a tendon, at rest."""
    document = rod_document(
        radius=0.02,
        strains=ALL[:4],
        gravity=(0, 0, -9.81),
        material={"viscosity": 3000.0},
        numerics={
            "basis": {"order": 2},
            "step": step,
            "integrator": integrator,
            "newton_tolerance": 1e-13,
        },
    )
    document["actuators"] = [
        {"tendon": "pull", "rod": "rod", "offset": [0.01, 0.01], "safe": 4.0},
        {"moment": "turn", "rod": "rod", "section": "s", "strain": "torsion"},
    ]
    document["initial"] = {"state": "equilibrium"}
    return Simulation(scene_of(document))


def test_a_small_step_of_the_efforts_is_answered_as_the_nonlinear_simulation_answers():
    simulation = bent_arm()
    dynamics, rest = simulation.dynamics, simulation.q.copy()
    system = linearise(dynamics, rest, np.array([4.0, 0.0]))
    small = np.array([1e-3, 2e-4])
    sampler = simulation.sampler(2)
    times = 0.05 * np.arange(1, 13)
    simulation.set_efforts(np.array([4.0, 0.0]) + small)
    start = sampler.poses()[-1].copy()
    moved, ports = [], []
    for _ in times:
        simulation.advance(50)
        moved.append(sampler.poses()[-1, :3] - start[:3])
        ports.append(np.concatenate(simulation.ports()[:2]))
    u = np.concatenate([small, np.zeros(6)])
    t = np.linspace(0, 0.6, 601)
    _, y, _ = signal.lsim(signal.StateSpace(*system.matrices), np.tile(u, (601, 1)), t)
    y = y[50::50]
    size = np.abs(moved).max()
    np.testing.assert_allclose(y[:, :3], moved, atol=1e-3 * size)
    np.testing.assert_allclose(
        y[:, 6:], ports - system.output[6:], atol=2e-3 * np.abs(y[:, 6:]).max()
    )
    # settled: the static gain, against two equilibria
    there = equilibrium(dynamics, rest, efforts=np.array([4.0, 0.0]) + small)
    far = dynamics.node_poses(there)[-1][:3, 3] - dynamics.node_poses(rest)[-1][:3, 3]
    np.testing.assert_allclose((system.static_gain() @ u)[:3], far, atol=1e-3 * np.abs(far).max())


def test_the_discrete_system_is_the_continuous_one_at_its_instants():
    simulation = bent_arm()
    system = linearise(simulation.dynamics, simulation.q, np.array([4.0, 0.0]))
    step = 0.02
    sampled = system.discrete(step)
    expected = signal.cont2discrete(system.matrices, step, method="zoh")
    np.testing.assert_allclose(sampled.A, expected[0], atol=1e-9 * np.abs(expected[0]).max())
    np.testing.assert_allclose(sampled.B, expected[1], atol=1e-9 * np.abs(expected[1]).max())
    np.testing.assert_allclose(sampled.static_gain(), system.static_gain(), atol=1e-6)
    with pytest.raises(ValueError, match=r"has a step of 0.02 s already"):
        sampled.discrete(0.1)
    with pytest.raises(ValueError, match="above zero"):
        system.discrete(0.0)


def test_off_equilibrium_the_drift_says_so_and_carries_the_motion():
    """Let go from the straight shape: for a short time x = drift · t, as the simulation moves."""
    document = rod_document(
        strains=["bend_y"], gravity=(0, 0, -9.81), numerics={"basis": {"order": 2}, "step": 1e-4}
    )
    simulation = Simulation(scene_of(document))
    system = linearise(simulation.dynamics, simulation.q)
    assert np.abs(system.drift).max() > 1.0
    simulation.advance(100)
    sampled = system.discrete(0.01)
    # the second-order remainder of C: the tip falls by millimetres here
    x = np.concatenate([simulation.q, simulation.v])
    n = simulation.n_coordinates
    assert np.abs(x[:n] - sampled.drift[:n]).max() < 2e-3 * np.abs(x[:n]).max()


def test_inputs_and_outputs_can_be_chosen_by_name(zoo):
    dynamics, q = zoo
    system = linearise(dynamics, q, EFFORTS, tip=TIP)
    part = system.select(("helix", "tip_force_z"), ("tip_z", "helix_rate"))
    assert part.D.shape == (2, 2) and part.states == system.states
    whole = system.static_gain()
    rows = [system.outputs.index(o) for o in part.outputs]
    columns = [system.inputs.index(i) for i in part.inputs]
    np.testing.assert_allclose(part.static_gain(), whole[np.ix_(rows, columns)])
    assert replace(part, step=0.0).matrices[0] is part.A
