"""The port-Hamiltonian form C (1.38)–(1.46), and its integration by a discrete gradient."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import ALL, random_state, rod, rod_document, scene_of, zoo_document

from soft_sim_ros.core.analysis import discrete_gradient
from soft_sim_ros.core.analysis.discrete_gradient import DiscreteGradient
from soft_sim_ros.core.analysis.port_hamiltonian import PortHamiltonian
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import Diverged, NewtonFailed, SceneError
from soft_sim_ros.scene import load_scene

EFFORTS = np.array([0.3, -0.2, 3.0, 2.0])


@pytest.fixture(scope="module")
def zoo():
    """Joints, rods in space, rigid bodies, tendons, moments; no loads."""
    document = zoo_document()
    document["loads"] = []
    document["numerics"] = {"basis": {"order": 1}}
    return PortHamiltonian(Dynamics(scene_of(document)))


def state(system, seed, speed=0.1):
    q, v, _ = random_state(system.dynamics, seed)
    return q, speed * v


def difference_quotient(function, x, size):
    """Fourth-order difference quotients along every coordinate of x."""
    columns = []
    for e in np.diag(size):
        near, far = function(x + e) - function(x - e), function(x + 2 * e) - function(x - 2 * e)
        columns.append((8.0 * near - far) / (12.0 * e.sum()))
    return np.array(columns)


@pytest.mark.parametrize("seed", range(2))
def test_gradient_of_the_hamiltonian_is_its_difference_quotient(zoo, seed):
    q, v = state(zoo, seed)
    p = zoo.momentum(q, v)
    by_q, by_p = zoo.gradient(q, p)
    weight = zoo.dynamics.model.weight
    quotient = difference_quotient(lambda x: zoo.hamiltonian(x, p), q, 1e-3 / weight)
    assert np.abs((by_q - quotient) / weight).max() < 1e-7 * np.abs(by_q / weight).max()
    quotient = difference_quotient(lambda x: zoo.hamiltonian(q, x), p, 1e-3 * weight)
    assert np.abs((by_p - quotient) * weight).max() < 1e-8 * np.abs(by_p * weight).max()
    np.testing.assert_allclose(by_p, v, rtol=1e-9, atol=1e-9 * np.abs(v).max())  # (1.40)


def test_1_42_holds_with_the_other_sign(zoo):
    """∂H/∂q at fixed p is −∂𝓛/∂q at fixed q̇; (1.42) prints +½∂(q̇ᵀMq̇)/∂q + ∂𝓛/∂q."""
    q, v = state(zoo, 0)
    weight, dynamics = zoo.dynamics.model.weight, zoo.dynamics

    def lagrangian(x):
        kinetic, elastic, weight_energy = dynamics.energies(x, v)
        return kinetic - elastic - weight_energy

    by_q = zoo.gradient(q, zoo.momentum(q, v))[0]
    quotient = difference_quotient(lagrangian, q, 1e-3 / weight)
    assert np.abs((by_q + quotient) / weight).max() < 1e-7 * np.abs(by_q / weight).max()


@pytest.mark.parametrize("seed", range(2))
def test_1_44_is_the_lagrangian_equation_of_motion(zoo, seed):
    """q̇ = M⁻¹ p and ṗ = M q̈ + Ṁ q̇ with q̈ of the recursion, under efforts."""
    q, v = state(zoo, seed)
    dynamics = zoo.dynamics
    a = dynamics.forward_dynamics(q, v, EFFORTS)
    rate = dynamics.mass_matrix_derivative(q) @ v
    q_rate, p_rate = zoo.rates(q, zoo.momentum(q, v), EFFORTS)
    expected = dynamics.mass_matrix(q) @ a + rate @ v
    np.testing.assert_allclose(q_rate, v, rtol=1e-8, atol=1e-8 * np.abs(v).max())
    np.testing.assert_allclose(p_rate, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


def test_structure(zoo):
    q, v = state(zoo, 1)
    structure, dissipation = zoo.structure(), zoo.dissipation()
    np.testing.assert_array_equal(structure, -structure.T)
    np.testing.assert_allclose(dissipation, dissipation.T, rtol=1e-12, atol=1e-15)
    assert np.linalg.eigvalsh(dissipation).min() > -1e-12
    # outputs are the port velocities, so u · y is power
    gradient = np.concatenate(zoo.gradient(q, zoo.momentum(q, v)))
    velocity = zoo.dynamics.ports(q, v)[1]
    output = zoo.input_matrix(q).T @ gradient
    np.testing.assert_allclose(output, velocity, atol=1e-7 * np.abs(velocity).max())


@pytest.mark.parametrize("h", [1e-3, 5e-3, 2e-2])
def test_energy_balance_of_every_step_is_exact(zoo, h):
    """(1.45) with −q̇ᵀR q̇: stored = supplied − dissipated, for tendons as well."""
    motion = DiscreteGradient(zoo)
    worst = 0.0
    for _ in range(15):
        one = motion.step(h, EFFORTS)
        worst = max(worst, abs(one.stored - one.supplied + one.dissipated))
        assert one.dissipated >= 0.0
    energy = zoo.hamiltonian(motion.q, motion.p)
    assert energy - zoo.hamiltonian(0 * motion.q, 0 * motion.p) == pytest.approx(
        motion.balance.stored, abs=1e-12 * abs(energy)
    )
    assert motion.balance.dissipated > 1e-3
    assert worst < 3e-12 * abs(energy)


def test_work_of_the_ports_is_the_integral_of_effort_times_velocity(zoo):
    """What a step books as supplied is what the ports see, by quadrature over small steps."""
    motion, h, total = DiscreteGradient(zoo), 5e-4, 0.0
    for _ in range(40):
        before = zoo.dynamics.ports(motion.q, motion.v)[1]
        motion.step(h, EFFORTS)
        after = zoo.dynamics.ports(motion.q, motion.v)[1]
        total += 0.5 * h * EFFORTS @ (before + after)
    assert motion.balance.supplied == pytest.approx(total, rel=2e-3)


def arm(order=2, **options):
    """Return a rod with a bending, a twisting and a stretching actuator."""
    options.setdefault("gravity", (0.0, 0.0, -9.81))
    ports = [
        {"moment": strain, "rod": "rod", "section": "s", "strain": strain}
        for strain in ("bend_y", "torsion", "stretch")
    ]
    return rod_document(order=order, actuators=ports, **options)


# young_modulus Pa, radius m, viscosity Pa·s, density kg/m³, step s, effort N·m, steps
STRESS = [
    (1e4, 0.03, 0.0, 1000.0, 5e-3, 0.005, 40),
    (1e6, 0.03, 0.0, 1000.0, 5e-3, 1.0, 15),
    (1e6, 0.005, 20.0, 1000.0, 2e-3, 1e-3, 12),
    (1e6, 0.03, 1e5, 100.0, 1e-2, 1.0, 40),
    (1e9, 0.01, 0.0, 8000.0, 1e-2, 1.0, 10),
    (1e11, 0.002, 1e5, 8000.0, 1e-3, 0.1, 10),
]


@pytest.mark.parametrize(
    ("young", "radius", "viscosity", "density", "h", "effort", "steps"), STRESS
)
@pytest.mark.parametrize("command", ["step", "noise", "reversal"])
def test_passivity_is_never_violated(young, radius, viscosity, density, h, effort, steps, command):
    """Property 1.1: ∫ uᵀy dt ≥ H(t) − H(0), soft and stiff, at steps too long to resolve all of it.

    Not by standing still: an arm that only turns its momentum round keeps the balance as well.
    """
    material = {"young_modulus": young, "shear_modulus": young / 3}
    material |= {"viscosity": viscosity, "density": density}
    motion = DiscreteGradient(scene_of(arm(radius=radius, material=material)))
    rng = np.random.default_rng(7)
    scale = np.array([effort, 0.5 * effort, effort / radius])
    peak = 0.0
    for k in range(steps):
        u = {"step": 1.0, "noise": rng.normal(size=3), "reversal": (-1.0) ** (k // 5)}[command]
        motion.step(h, u * scale)
        stored, supplied, dissipated = motion.balance
        peak = max(peak, abs(stored), abs(supplied), abs(motion._energy))
        assert supplied - stored >= dissipated - 1e-9 * peak
        assert dissipated >= 0.0
    assert np.abs(motion.q * motion.system.dynamics.model.weight).max() > 0.01


def test_generalised_forces_are_inputs_as_well():
    """The paper's own port, u = τ and y = q̇."""
    motion = DiscreteGradient(rod(order=1, material={"viscosity": 100.0}))
    rng = np.random.default_rng(2)
    force = rng.normal(size=motion.system.n) * 0.01 * motion.system.dynamics.model.weight
    work = 0.0
    for _ in range(20):
        before = motion.q
        one = motion.step(5e-3, tau=force)
        assert one.stored == pytest.approx(one.supplied - one.dissipated, abs=1e-13)
        work += force @ (motion.q - before)
    assert motion.balance.supplied == pytest.approx(work, rel=1e-12)
    assert motion.balance.supplied > motion.balance.stored > 0.0


def test_energy_of_a_free_undamped_rod_does_not_drift():
    motion = DiscreteGradient(scene_of(arm(order=1)))
    energy = motion._energy
    kinetic = 0.0
    for _ in range(400):
        motion.step(0.02)
        kinetic = max(kinetic, 0.5 * motion.p @ motion.v)
    assert kinetic > 0.1
    assert abs(motion._energy - energy) < 1e-12 * kinetic


def test_steps_are_reversible():
    motion = DiscreteGradient(scene_of(arm(order=1)))
    for _ in range(10):
        motion.step(5e-3)
    q, p = motion.q, motion.p
    motion.step(5e-3)
    motion.step(-5e-3)
    weight = motion.system.dynamics.model.weight
    assert np.abs((motion.q - q) * weight).max() < 1e-9
    assert np.abs(motion.p - p).max() < 1e-9 * np.abs(p).max()


def test_motion_agrees_with_that_of_q_and_its_rate_to_second_order():
    """Against sdirk4 of (q, q̇) at a small step: bending in space, loads of both kinds, efforts."""
    document = arm(
        order=1,
        strains=ALL[:3],
        material={"viscosity": 500.0},
        loads=[
            {"point": "a", "body": "rod", "force": [0.2, 0.5, -0.3], "moment": [0.01, 0.02, 0.0]},
            {"point": "b", "body": "rod", "force": [-0.3, 0.2, 0.4], "frame": "body"},
        ],
        numerics={"basis": {"order": 1}, "integrator": "sdirk4", "step": 0.0005},
    )
    document["actuators"] = document["actuators"][:2]
    scene, efforts = scene_of(document), np.array([0.1, 0.05])
    exact = Simulation(scene)
    exact.set_efforts(efforts)
    exact.advance(200)
    weight = exact.dynamics.model.weight
    errors = []
    for steps in (20, 40, 80):
        motion = DiscreteGradient(scene)
        for _ in range(steps):
            motion.step(0.1 / steps, efforts)
        errors.append(np.abs((motion.q - exact.q) * weight).max())
    assert np.abs(exact.q * weight).max() > 0.05
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert order == pytest.approx([2.0, 2.0], abs=0.15)


def top():
    """Return a heavy top on a ball, spinning fast: it turns over."""
    document = {
        "name": "top",
        "gravity": [0.0, 0.0, -9.81],
        "bodies": [
            {"joint": "ball", "kind": "spherical"},
            {"rigid_body": "top", "mass": 0.5, "inertia": [4e-4, 7e-4, 9e-4],
             "com": {"position": [0.04, 0.01, 0.0]}},
        ],
        "initial": {"velocities": {"ball": [6.0, 9.0, 12.0]}},
        "numerics": {"integrator": "sdirk4", "step": 0.0005, "newton_tolerance": 1e-9},
    }  # fmt: skip
    return scene_of(document)


def test_rotation_vectors_beyond_a_turn_change_their_chart():
    """Poses, not coordinates, agree with (q, q̇) to second order; the balance stays exact."""
    exact = Simulation(top())
    start = exact.q.copy(), exact.v.copy()
    exact.advance(800)
    expected = exact.dynamics.node_poses(exact.q)[-1]
    errors = []
    for steps in (80, 160, 320):
        motion, changes, worst = DiscreteGradient(top(), *start), 0, 0.0
        for _ in range(steps):
            before = motion.q
            one = motion.step(0.4 / steps)
            changes += np.linalg.norm(motion.q - before) > 1.0
            worst = max(worst, abs(one.stored - one.supplied + one.dissipated))
        assert changes == 1
        assert worst < 1e-13
        errors.append(np.abs(exact.dynamics.node_poses(motion.q)[-1] - expected).max())
    assert -np.polyfit(np.log([1, 2, 4]), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.15)
    assert errors[-1] < 2e-3


def test_a_damped_driven_arm_in_space_balances_and_is_of_second_order():
    """(1.45) in every step: weight, six strains, torsion, a tendon, loads, inputs that change."""
    tendon = {"tendon": "pull", "rod": "rod", "offset": {"from": [0.02, 0.01], "to": [0.0, 0.02]}}
    document = arm(
        order=1,
        material={"viscosity": 2e3, "rayleigh": {"mass": 2.0}},
        loads=[{"point": "f", "body": "rod", "force": [0.2, 0.3, 0.1], "frame": "body"}],
        numerics={"basis": {"order": 1}, "integrator": "sdirk4", "step": 0.0005,
                  "newton_tolerance": 1e-9},
    )  # fmt: skip
    document["actuators"] = [*document["actuators"][:2], tendon]
    scene = scene_of(document)
    inputs = np.array([[0.1, 0.05, 2.0], [-0.1, 0.1, 0.5], [0.2, -0.1, 4.0]])
    exact = Simulation(scene)
    for row in inputs:
        exact.set_efforts(row)
        exact.advance(80)
    errors = []
    for pieces in (8, 16, 32):
        motion, worst, turned = DiscreteGradient(scene), 0.0, 0.0
        for row in np.repeat(inputs, pieces, axis=0):
            one = motion.step(0.04 / pieces, row)
            worst = max(worst, abs(one.stored - one.supplied + one.dissipated))
            turned += abs(one.supplied) + abs(one.stored) + one.dissipated
            assert one.dissipated >= 0.0
        assert worst < 1e-12 * turned
        errors.append(np.abs((motion.q - exact.q) * motion.system.dynamics.model.weight).max())
    assert -np.polyfit(np.log([1, 2, 4]), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.2)
    assert motion.balance.dissipated > 0.05 * motion.balance.supplied > 0.0


@pytest.fixture(scope="module")
def flying():
    """A tumbling rubber rod, its initial state, and poses of its tip every 20 ms by sdirk4."""
    scene = load_scene("flying_body")
    fine = replace(scene.numerics, step=0.0005, integrator="sdirk4", options={})
    exact = Simulation(replace(scene, numerics=fine))
    start, tips = (exact.q.copy(), exact.v.copy()), []
    for _ in range(5):
        exact.advance(40)
        tips.append(exact.dynamics.node_poses(exact.q)[-1])
    return scene, start, tips


@pytest.mark.parametrize("h", [0.002, 0.004, 0.02])
def test_a_balance_without_a_motion_is_not_taken_for_one(flying, h):
    """Steps of 4 ms once let the body stand still, its momentum turned round, its balance exact."""
    scene, start, tips = flying
    motion = DiscreteGradient(scene, *start)
    for tip in tips:
        for _ in range(round(0.02 / h)):
            motion.step(h)
        pose = motion.system.dynamics.node_poses(motion.q)[-1]
        assert np.abs(pose - tip).max() < 2e-3  # of metres and of directions
    assert motion.balance.stored == pytest.approx(-motion.balance.dissipated, abs=1e-11)


def test_steps_that_show_no_motion_are_refused(flying, monkeypatch):
    """Where cutting them does not help; here it is not tried.

    Which of their solutions Newton's method finds, if any, round-off decides: that none is taken
    for a motion is what counts, and that both reasons are met with.
    """
    monkeypatch.setattr(discrete_gradient, "CUTS", 0)
    scene, start, _ = flying
    told = []
    for h in (0.005, 0.008, 0.01, 0.015, 0.02, 0.03):
        motion = DiscreteGradient(scene, *start)
        with pytest.raises((Diverged, NewtonFailed)) as caught:
            for _ in range(5):
                motion.step(h)
        if isinstance(caught.value, Diverged):
            assert caught.value.time == motion.time
            assert f"a step of {h} s does not show the motion" in str(caught.value)
            assert "a shorter one" in str(caught.value)
            told.append(str(caught.value))
    assert any("velocities at its ends disagree" in text for text in told)
    assert any("balanced by a correction of" in text for text in told)


def test_an_arm_at_rest_is_not_refused():
    """There the correction is a quotient of round-off."""
    dynamics = Dynamics(scene_of(arm(order=1)))
    start = equilibrium(dynamics)
    motion = DiscreteGradient(dynamics, start)
    for _ in range(20):
        motion.step(0.05)
    assert np.abs(start * dynamics.model.weight).max() > 0.1
    assert np.abs((motion.q - start) * dynamics.model.weight).max() < 1e-8


def test_a_hopeless_step_is_a_typed_error():
    motion = DiscreteGradient(scene_of(arm(order=1)))
    before = motion.q
    with pytest.raises((NewtonFailed, Diverged)):
        motion.step(1e-3, np.array([1e12, 0.0, 0.0]))
    assert motion.q is before


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"h": 0.0}, "h"),
        ({"h": np.inf}, "h"),
        ({"h": 1e-3, "efforts": [np.nan, 0.0, 0.0]}, "efforts"),
        ({"h": 1e-3, "efforts": [1.0]}, "efforts"),
        ({"h": 1e-3, "tau": [1.0]}, "tau"),
    ],
)
def test_bad_arguments_are_refused_by_name(arguments, name):
    motion = DiscreteGradient(scene_of(arm(order=1)))
    with pytest.raises(ValueError, match=rf"^{name} "):
        motion.step(**arguments)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"friction": 0.1}, "actuators[0].friction"),
        ({"control": "length", "axial_stiffness": 1e3}, "actuators[0].control"),
    ],
)
def test_tendons_whose_tension_is_not_their_effort_are_refused(change, key):
    tendon = {"tendon": "pull", "rod": "rod", "offset": [0.02, 0.0]}
    with pytest.raises(SceneError) as caught:
        PortHamiltonian(rod(order=1, actuators=[tendon | change]))
    assert caught.value.key_path == key
