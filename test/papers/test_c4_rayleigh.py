"""C-4: Rayleigh damping, α M q̇ + β K q̇, against its closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from differences import central_difference
from scenes import random_state, rod_document, scene_of, zoo_document
from scipy.linalg import eigh

from soft_sim_ros.core.analysis.discrete_gradient import DiscreteGradient
from soft_sim_ros.core.analysis.port_hamiltonian import PortHamiltonian
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import SceneError

ALPHA, BETA = 3.0, 2e-3


def damped(**options):
    """Return the document of a rod with Rayleigh damping only."""
    material = {"rayleigh": {"mass": ALPHA, "stiffness": BETA}}
    return rod_document(material=material, **({"order": 3} | options))


def test_damping_matrix_is_alpha_times_mass_plus_beta_times_stiffness():
    dynamics = Dynamics(scene_of(damped()))
    q, _, _ = random_state(dynamics, 1)
    zero = np.zeros(dynamics.n)
    _, damping, mass = dynamics.tangents(q, zero, zero)
    expected = ALPHA * mass + BETA * dynamics.stiffness_matrix()
    scale = np.sqrt(np.diag(expected))
    assert np.max(np.abs(damping - expected) / np.outer(scale, scale)) < 1e-12


def test_every_mode_has_its_damping_ratio():
    # ζ = α/2ω + βω/2: eigenvalues −ζω ± iω√(1 − ζ²) of the linearised motion
    dynamics = Dynamics(scene_of(damped(strains=["bend_z"], order=7)))
    zero = np.zeros(dynamics.n)
    stiffness, damping, mass = dynamics.tangents(zero, zero, zero)
    omega = np.sqrt(eigh(stiffness, mass, eigvals_only=True))
    first = np.block([
        [np.zeros_like(mass), np.eye(dynamics.n)],
        [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
    ])  # fmt: skip
    ratio = ALPHA / (2.0 * omega) + BETA * omega / 2.0
    root = np.emath.sqrt(ratio**2 - 1.0)
    expected = np.concatenate([omega * (-ratio + root), omega * (-ratio - root)])
    assert ratio.min() < 0.5 and ratio.max() > 1.0  # both kinds of motion are there
    values = np.linalg.eigvals(first)
    for value in expected:
        assert np.min(np.abs(values - value)) < 1e-7 * abs(value)


def test_small_swing_dies_out_with_the_damping_ratio_of_its_mode():
    scene = damped(strains=["bend_z"], order=2)
    scene["numerics"] |= {"step": 0.001, "integrator": "sdirk4"}
    simulation = Simulation(scene_of(scene))
    zero = np.zeros(simulation.n_coordinates)
    stiffness, _, mass = simulation.dynamics.tangents(zero, zero, zero)
    values, shapes = eigh(stiffness, mass)
    omega = np.sqrt(values[0])
    ratio = ALPHA / (2.0 * omega) + BETA * omega / 2.0
    simulation.set_state(1e-5 * shapes[:, 0], zero)
    turning = omega * np.sqrt(1.0 - ratio**2)
    for _ in range(5):
        simulation.advance(100)
        t = simulation.time
        amplitude = shapes[:, 0] @ mass @ simulation.q / 1e-5
        wave = np.cos(turning * t) + ratio * omega / turning * np.sin(turning * t)
        assert amplitude == pytest.approx(np.exp(-ratio * omega * t) * wave, abs=1e-6)


@pytest.mark.parametrize("integrator", ["sdirk2", "implicit_midpoint"])
def test_turning_arm_slows_down_exponentially_and_the_ledger_knows_where_it_went(integrator):
    # rigid turning on a hinge: J ω̇ = −α J ω, without any elastic force
    scene = damped(strains=["torsion"], order=0)
    scene["bodies"].insert(0, {"joint": "hinge", "kind": "revolute", "axis": [0, 0, 1]})
    scene["initial"] = {"velocities": {"hinge": 5.0}}
    scene["numerics"] |= {"step": 0.002, "integrator": integrator}
    simulation = Simulation(scene_of(scene))
    before = simulation.ledger()[0]
    simulation.advance(250)
    assert simulation.v[0] == pytest.approx(5.0 * np.exp(-ALPHA * 0.5), rel=2e-5)
    kinetic, _, _, _, _, dissipated, residual = simulation.ledger()
    assert dissipated == pytest.approx(before - kinetic, rel=1e-4)
    assert abs(residual) < 1e-4 * before


def zoo(density=1000.0, alpha=0.0):
    """Return the dynamics of the arm with everything in it, its rods dragged."""
    document = zoo_document()
    document["materials"]["soft"] |= {"density": density, "rayleigh": {"mass": alpha}}
    return Dynamics(scene_of(document))


def test_drag_on_a_fast_strongly_bent_arm_is_that_of_the_mass_of_its_material():
    # rigid bodies have no material; M is linear in the density, so the rods' share is a difference
    dynamics, plain = zoo(alpha=ALPHA), zoo()
    q, v, a = random_state(dynamics, 4)
    drag = dynamics.inverse_dynamics(q, v, a) - plain.inverse_dynamics(q, v, a)
    rods = zoo(density=2000.0).mass_matrix(q) - plain.mass_matrix(q)
    scale = np.sqrt(np.diag(plain.mass_matrix(q)))
    expected = ALPHA * rods @ v
    assert np.max(np.abs(drag - expected) / scale) < 1e-10 * np.max(np.abs(expected) / scale)


def test_damping_matrix_holds_the_drag_at_any_shape():
    dynamics = zoo(alpha=ALPHA)
    q, _, _ = random_state(dynamics, 6)
    zero = np.zeros(dynamics.n)
    damping, scale = dynamics.damping_matrix(q), np.sqrt(np.diag(dynamics.mass_matrix(q)))
    exact = dynamics.tangents(q, zero, zero)[1]
    error = np.abs(damping - exact) / np.outer(scale, scale)
    assert np.max(error) < 1e-10 * np.max(np.abs(exact) / np.outer(scale, scale))
    assert not np.allclose(damping, dynamics.damping_matrix(), rtol=1e-3)


def test_port_hamiltonian_form_of_a_dragged_rubber_arm_moves_as_the_lagrangian_one():
    document = zoo_document()
    document["materials"]["soft"] = {
        "law": {"kind": "mooney_rivlin", "c10": 1e5, "c01": 6e4},
        "density": 1000.0,
        "rayleigh": {"mass": ALPHA, "stiffness": BETA},
    }
    system = PortHamiltonian(scene_of(document))
    q, v, _ = random_state(system.dynamics, 7)
    p = system.momentum(q, v)
    efforts = np.array([0.3, -0.2, 8.0, 5.0])
    way, push = system.rates(q, p, efforts, system.load_force(q))
    np.testing.assert_allclose(way, v, rtol=1e-6, atol=1e-9 * np.abs(v).max())
    a = system.dynamics.forward_dynamics(q, v, efforts)
    h = 1e-5
    difference = (system.momentum(q + h * v, v + h * a) - system.momentum(q - h * v, v - h * a)) / (
        2.0 * h
    )
    scale = np.sqrt(np.diag(system.dynamics.mass_matrix(q)))
    assert np.max(np.abs(push - difference) / scale) < 1e-6 * np.max(np.abs(push) / scale)


def test_discrete_gradient_books_what_the_drag_takes():
    scene = damped(strains=["torsion"], order=0)
    scene["bodies"].insert(0, {"joint": "hinge", "kind": "revolute", "axis": [0, 0, 1]})
    motion = DiscreteGradient(scene_of(scene), v=np.array([5.0, 0.0]))
    energy = motion.system.hamiltonian(motion.q, motion.p)
    for _ in range(100):
        motion.step(0.005)
    assert motion.v[0] == pytest.approx(5.0 * np.exp(-ALPHA * 0.5), rel=1e-4)
    assert motion.balance.dissipated == pytest.approx(
        energy - motion.system.hamiltonian(motion.q, motion.p), rel=1e-9
    )


def test_tangent_of_drag_is_its_difference_quotient():
    dynamics, plain = zoo(alpha=ALPHA), zoo()
    q, v, a = random_state(dynamics, 5)
    size = 1e-3 / np.maximum(dynamics.model.weight, 1e-3)
    scale = np.sqrt(np.diag(plain.mass_matrix(q)))

    def drag(x, y):
        return dynamics.inverse_dynamics(x, y, a) - plain.inverse_dynamics(x, y, a)

    quotients = (
        central_difference(lambda x: drag(x, v), q, size),
        central_difference(lambda y: drag(q, y), v, size),
    )
    for which, quotient in enumerate(quotients):
        exact = dynamics.tangents(q, v, a)[which] - plain.tangents(q, v, a)[which]
        units = np.outer(scale, scale)
        assert np.max(np.abs(exact - quotient) / units) < 1e-7 * np.max(np.abs(exact) / units)


@pytest.mark.parametrize("key", ["mass", "stiffness"])
def test_negative_damping_is_refused(key):
    with pytest.raises(SceneError, match=rf"rayleigh.{key} = -1.0: expected a number >= 0"):
        scene_of(rod_document(material={"rayleigh": {key: -1.0}}))
