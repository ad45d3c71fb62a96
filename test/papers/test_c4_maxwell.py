"""C-4: a Maxwell branch beside the elasticity (standard linear solid), against closed forms.

One stretch coordinate of a rod, x'' m + K x + K_m (x − d) = F, τ d' = x − d, has closed forms; what
a rod with all strains does is checked against the linear system of its own matrices.
"""

from __future__ import annotations

import numpy as np
import pytest
from scenes import ALL, random_state, rod_document, scene_of
from scipy.linalg import expm

from soft_sim_ros.core.analysis.port_hamiltonian import PortHamiltonian
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import Diverged, SceneError
from soft_sim_ros.scene import INTEGRATORS

RATIO, TIME = 1.5, 0.2
METHODS = [name for name in INTEGRATORS if name != "adaptive"]  # whose steps are the scene's


def document(*, step=0.01, integrator="sdirk4", ratio=RATIO, time=TIME, **options):
    """Return the document of a rod with a Maxwell branch."""
    options = {"strains": ["stretch"], "order": 0} | options
    material = {"maxwell": {"ratio": ratio, "time": time}} | options.pop("material", {})
    scene = rod_document(material=material, **options)
    scene["numerics"] |= {"step": step, "integrator": integrator}
    return scene


def simulation_of(**options):
    """Return a simulation of it, with an actuator along its one strain."""
    scene = document(**options)
    scene["actuators"] = [{"moment": "pull", "rod": "rod", "section": "s", "strain": "stretch"}]
    return Simulation(scene_of(scene))


def matrices(simulation):
    """Return mass, stiffness and input of the one coordinate."""
    dynamics, zero = simulation.dynamics, np.zeros(1)
    position = dynamics.ports(np.ones(1), zero)[0] - dynamics.ports(zero, zero)[0]
    return dynamics.mass_matrix(zero)[0, 0], dynamics.stiffness_matrix()[0, 0], position[0]


def test_creep_under_a_constant_force():
    # almost no mass: J(t) = 1/K (1 − r/(1 + r) exp(−t/(τ (1 + r))))
    simulation = simulation_of(material={"density": 1e-9}, step=0.002)
    _, stiffness, gain = matrices(simulation)
    force = 0.1 * stiffness / gain
    simulation.set_efforts([force])
    for _ in range(10):
        simulation.advance(50)
        slow = np.exp(-simulation.time / (TIME * (1.0 + RATIO)))
        compliance = (1.0 - RATIO / (1.0 + RATIO) * slow) / stiffness
        assert simulation.q[0] == pytest.approx(force * gain * compliance, rel=1e-6)


def test_recovery_after_the_force_is_gone():
    simulation = simulation_of(material={"density": 1e-9}, step=0.002)
    _, stiffness, gain = matrices(simulation)
    force = 0.1 * stiffness / gain
    simulation.set_efforts([force])
    simulation.advance(100)
    simulation.set_efforts([0.0])
    simulation.advance(100)
    slow = TIME * (1.0 + RATIO)
    remains = RATIO / (1.0 + RATIO) * (np.exp(-0.2 / slow) - np.exp(-0.4 / slow))
    assert simulation.q[0] == pytest.approx(force * gain * remains / stiffness, rel=1e-6)


def test_stress_under_a_constant_strain_rate_is_the_integral_of_the_relaxation_modulus():
    # a mass so large that nothing stops it stretches the rod at a constant rate; the energy of the
    # branch, ½ p² r K with p = τ v (1 − e^(−t/τ)), tells its stress r K p
    scene = document(step=0.01)
    scene["bodies"].append({"rigid_body": "wall", "mass": 1e12})
    simulation = Simulation(scene_of(scene))
    stiffness = simulation.dynamics.stiffness_matrix()[0, 0]
    rate = 0.1
    simulation.set_state(np.zeros(1), np.array([rate]))
    lost = 0.0
    for _ in range(8):
        simulation.advance(10)
        t, ledger = simulation.time, simulation.ledger()
        branch = ledger[1] - 0.5 * stiffness * simulation.q[0] ** 2
        strain = np.sqrt(2.0 * branch / (RATIO * stiffness))
        # σ = ∫ G(t − s) v ds with G = K (1 + r e^(−t/τ))
        assert strain == pytest.approx(rate * TIME * (1.0 - np.exp(-t / TIME)), rel=1e-6)
        decay = np.exp(-t / TIME)
        way = t - 2.0 * TIME * (1.0 - decay) + 0.5 * TIME * (1.0 - decay**2)
        lost = RATIO * stiffness * TIME * rate**2 * way
        assert ledger[5] == pytest.approx(lost, rel=1e-6)
    assert lost > 0.0


@pytest.mark.parametrize("frequency", [0.05, 0.3, 0.8, 3.0, 20.0])
def test_complex_modulus_over_frequency(frequency):
    # K* = K (1 + r iωτ/(1 + iωτ)); the effort is held over every step, which a hold accounts for
    count = 200
    omega = frequency / TIME
    step = round(2.0 * np.pi / omega / count, 9)
    omega = 2.0 * np.pi / (count * step)
    simulation = simulation_of(material={"density": 1e-9}, step=step)
    mass, stiffness, gain = matrices(simulation)
    assert mass * omega**2 < 1e-9 * stiffness
    amplitude = 0.05 * stiffness / gain
    settle = 2 + int(np.ceil(20.0 * TIME * (1.0 + RATIO) / (count * step)))
    response = []
    for i in range((settle + 1) * count):
        if i >= settle * count:
            response.append(simulation.q[0])
        simulation.set_efforts([amplitude * np.cos(omega * i * step)])
        simulation.advance(1)
    phases = np.exp(-2j * np.pi * np.arange(count) / count)
    measured = 2.0 / count * np.dot(response, phases)
    hold = np.exp(-0.5j * omega * step) * np.sinc(0.5 * omega * step / np.pi)
    # samples of what is held alias: their sum over all images is what the samples see
    modulus = stiffness * (1.0 + RATIO * 1j * omega * TIME / (1.0 + 1j * omega * TIME))
    expected = gain * amplitude * sampled_response(omega, step, stiffness)
    assert abs(measured / expected - 1.0) < 1e-6
    assert abs(gain * amplitude * hold / modulus / measured - 1.0) < 0.02


def sampled_response(omega, step, stiffness):
    """Return the exact response of x, per held unit force, at the samples: discrete-time theory."""
    # without mass x = (F + r K d)/((1 + r) K), τ d' = x − d
    slow = -1.0 / (TIME * (1.0 + RATIO))
    pole = np.exp(slow * step)
    # d_{k+1} = pole d_k + (1 − pole)/K F_k, before a change x = (F_{k−1} + r K d_k)/((1 + r) K)
    z = np.exp(1j * omega * step)
    dashpot = (1.0 - pole) / stiffness / (z - pole)
    return (1.0 / z + RATIO * stiffness * dashpot) / ((1.0 + RATIO) * stiffness)


@pytest.mark.parametrize("integrator", METHODS)
def test_ringing_solid_follows_its_three_exponentials_with_the_order_of_the_method(integrator):
    orders = {"sdirk3": 3, "sdirk4": 4}
    errors, steps = [], np.array([0.004, 0.002, 0.001])
    for step in steps:
        scene = document(step=step, integrator=integrator, time=0.02)
        simulation = Simulation(scene_of(scene))
        dynamics, zero = simulation.dynamics, np.zeros(1)
        mass, stiffness = dynamics.mass_matrix(zero)[0, 0], dynamics.stiffness_matrix()[0, 0]
        matrix = np.array([
            [0.0, 1.0, 0.0],
            [-stiffness * (1.0 + RATIO) / mass, 0.0, stiffness * RATIO / mass],
            [1.0 / 0.02, 0.0, -1.0 / 0.02],
        ])  # fmt: skip
        simulation.set_state(np.array([1e-3]), zero)
        simulation.advance(round(0.04 / step))
        exact = expm(0.04 * matrix) @ [1e-3, 0.0, 1e-3]
        errors.append(abs(simulation.q[0] - exact[0]) / 1e-3)
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope > orders.get(integrator, 2) - 0.3
    assert errors[-1] < 0.02


@pytest.mark.skipif("adaptive" not in INTEGRATORS, reason="there is no such method")
def test_adaptive_method_keeps_its_error_where_branches_ring_and_creep():
    # on the fast scale of the mass and on the slow one of the dashpot, with the same options
    errors, goals = [], (1e-5, 1e-7)
    for goal in goals:
        scene = document(step=0.01, integrator="adaptive")
        scene["numerics"]["options"] = {"error": goal}
        simulation = Simulation(scene_of(scene))
        dynamics, zero = simulation.dynamics, np.zeros(1)
        mass, stiffness = dynamics.mass_matrix(zero)[0, 0], dynamics.stiffness_matrix()[0, 0]
        matrix = np.array([
            [0.0, 1.0, 0.0],
            [-stiffness * (1.0 + RATIO) / mass, 0.0, stiffness * RATIO / mass],
            [1.0 / TIME, 0.0, -1.0 / TIME],
        ])  # fmt: skip
        simulation.set_state(np.array([0.02]), zero)
        worst = 0.0
        for _ in range(20):
            simulation.advance(1)
            exact = expm(simulation.time * matrix) @ [0.02, 0.0, 0.02]
            worst = max(worst, abs(simulation.q[0] - exact[0]))
        errors.append(worst)
        assert abs(simulation.ledger()[-1]) < 1e3 * goal * simulation.ledger()[5] / 0.02
    assert errors[0] < 100.0 * goals[0] and errors[1] < 0.1 * errors[0]


def test_all_strains_of_a_rod_relax_together():
    # small motion of a rod with all six strains: its M and K, and the branch r K on each coordinate
    scene = document(strains=ALL, order=1, step=5e-5, time=0.01, material={"density": 200.0})
    simulation = Simulation(scene_of(scene))
    n, zero = simulation.n_coordinates, np.zeros(simulation.n_coordinates)
    stiffness, _, mass = simulation.dynamics.tangents(zero, zero, zero)
    inverse = np.linalg.inv(mass)
    none, one = np.zeros((n, n)), np.eye(n)
    matrix = np.block([
        [none, one, none],
        [-(1.0 + RATIO) * inverse @ stiffness, none, RATIO * inverse @ stiffness],
        [one / 0.01, none, -one / 0.01],
    ])  # fmt: skip
    q = 1e-7 * np.random.default_rng(1).normal(size=n) / simulation.model.weight
    simulation.set_state(q, zero)
    simulation.advance(400)
    exact = expm(simulation.time * matrix) @ np.concatenate([q, zero, q])
    weight = simulation.model.weight
    assert np.max(np.abs(simulation.q - exact[:n]) * weight) < 1e-3 * np.max(np.abs(q) * weight)


@pytest.mark.parametrize("integrator", METHODS)
def test_ledger_closes_over_a_large_motion(integrator):
    residuals = []
    for step in (0.002, 0.001):
        scene = document(
            strains=["bend_y", "stretch"], order=2, step=step, integrator=integrator, time=0.05,
            gravity=(3.0, 0.0, -9.81),
        )  # fmt: skip
        scene["numerics"]["newton_tolerance"] = 1e-11  # what is left is the method's own error
        simulation = Simulation(scene_of(scene))
        simulation.advance(round(0.4 / step))
        ledger = simulation.ledger()
        residuals.append(abs(ledger[-1]) / ledger[5])
        assert ledger[5] > 0.05 * ledger[1]
    # energy_midpoint closes it to round-off, the others with their order
    assert residuals[1] < 0.02 and residuals[1] < max(0.6 * residuals[0], 1e-13)


def test_slow_and_fast_branches_are_springs_and_nothing():
    # τ → ∞: K (1 + r); τ → 0: K
    plain = Simulation(
        scene_of(
            rod_document(
                strains=["stretch"], order=0, numerics={"step": 0.001, "integrator": "sdirk4"}
            )
        )
    )
    stiff_material = {"young_modulus": 1e6 * (1.0 + RATIO), "shear_modulus": 1e6}
    stiff = Simulation(scene_of(rod_document(
        strains=["stretch"], order=0, material=stiff_material,
        numerics={"step": 0.001, "integrator": "sdirk4"},
    )))  # fmt: skip
    for time, other in ((1e6, stiff), (1e-9, plain)):
        simulation = Simulation(scene_of(document(time=time, step=0.001)))
        for one in (simulation, other):
            one.set_state(np.array([1e-3]), np.zeros(1))
            one.advance(50)
        # the dashpot that does not move holds its spring where it was relaxed, at 1e-3
        share = RATIO / (1.0 + RATIO) if other is stiff else 0.0
        expected = share * 1e-3 + (1.0 - share) * other.q[0]
        assert simulation.q[0] == pytest.approx(expected, abs=1e-8)
    assert abs(plain.q[0] - stiff.q[0]) > 1e-4


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_same_bits_however_steps_are_grouped_and_after_a_reset(integrator):
    scene = scene_of(document(
        strains=ALL, order=1, integrator=integrator, gravity=(0.0, 0.0, -9.81), step=0.002
    ))  # fmt: skip
    one, other = Simulation(scene), Simulation(scene)
    one.advance(60)
    for count in (1, 20, 39):
        other.advance(count)
    assert np.array_equal(one.q, other.q) and np.array_equal(one.ledger(), other.ledger())
    one.reset()
    one.advance(60)
    assert np.array_equal(one.q, other.q)


def test_refused_step_leaves_the_branches_where_they_were():
    scene = document(strains=["bend_y", "stretch"], order=2, gravity=(0.0, 0.0, -9.81), step=0.01)
    scene["actuators"] = [{"moment": "pull", "rod": "rod", "section": "s", "strain": "stretch"}]
    one, other = Simulation(scene_of(scene)), Simulation(scene_of(scene))
    for simulation in (one, other):
        simulation.advance(20)
    before = one.ledger()
    one.set_efforts([-1e9])
    with pytest.raises(Diverged):
        one.advance(1)
    one.set_efforts([0.0])
    np.testing.assert_allclose(one.ledger()[:3], before[:3], rtol=1e-12)
    other.set_efforts([1.0])
    other.set_efforts([0.0])
    for simulation in (one, other):
        simulation.advance(20)
    np.testing.assert_allclose(one.q, other.q, rtol=1e-5, atol=1e-8)


def test_equilibrium_is_that_of_the_relaxed_solid():
    scene = document(strains=ALL, order=2, gravity=(0.0, 0.0, -9.81))
    scene["initial"] = {"state": "equilibrium"}
    simulation = Simulation(scene_of(scene))
    del scene["materials"]["soft"]["maxwell"]
    np.testing.assert_array_equal(simulation.q, Simulation(scene_of(scene)).q)
    q = simulation.q.copy()
    simulation.advance(50)
    np.testing.assert_allclose(
        simulation.q * simulation.model.weight, q * simulation.model.weight, atol=1e-8
    )


def test_only_rods_with_the_material_have_branches():
    scene = document(strains=["bend_z"], order=1)
    scene["bodies"].insert(0, {"joint": "hinge", "kind": "revolute", "axis": [0, 0, 1],
                               "stiffness": 3.0})  # fmt: skip
    simulation = Simulation(scene_of(scene))
    q, _, _ = random_state(simulation.dynamics, 3)
    simulation.set_state(q, np.zeros(simulation.n_coordinates))
    free = simulation.ledger()
    assert free[1] == pytest.approx(0.5 * q @ simulation.dynamics.stiffness_matrix() @ q)
    model = simulation.model
    rows = np.repeat(np.arange(simulation.n_coordinates), np.diff(model.law_ptr))
    np.testing.assert_allclose(model.branch, np.where(rows == 0, 0.0, RATIO * model.stiffness))


def test_port_hamiltonian_form_refuses_branches_by_name():
    with pytest.raises(SceneError, match=r"materials.soft.maxwell") as caught:
        PortHamiltonian(scene_of(document()))
    assert caught.value.value == "{ratio: 1.5, time: 0.2}"


@pytest.mark.parametrize(
    ("branch", "key"),
    [({"ratio": 0.0, "time": 1.0}, "ratio"), ({"ratio": 1.0, "time": -1.0}, "time"),
     ({"ratio": 1.0}, "time"), ({"ratio": 1.0, "time": 1.0, "tau": 1.0}, "tau")],
)  # fmt: skip
def test_bad_branches_are_refused_by_key(branch, key):
    with pytest.raises(SceneError) as caught:
        scene_of(rod_document(material={"maxwell": branch}))
    assert caught.value.key_path == f"materials.soft.maxwell.{key}"
