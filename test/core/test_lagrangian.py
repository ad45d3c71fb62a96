"""The structure of M q̈ + C q̇ + g + k + R q̇ = τ, C (1.31), at random states."""

import numpy as np
import pytest
from scenes import random_state, scene_of, zoo_document

from soft_sim_ros.core.settled import Dynamics

SEEDS = range(3)


@pytest.fixture(scope="module")
def zoo():
    document = zoo_document()
    document["loads"] = []
    return Dynamics(scene_of(document))


def derivative(function, x, direction):
    """Sixth-order difference quotient of function along a direction."""
    h = 2e-3
    weights = {1: 45.0, 2: -9.0, 3: 1.0}
    total = 0.0
    for k, w in weights.items():
        total = total + w * (function(x + k * h * direction) - function(x - k * h * direction))
    return total / (60.0 * h)


@pytest.mark.parametrize("seed", SEEDS)
def test_parts_add_up_to_inverse_dynamics(zoo, seed):
    q, v, a = random_state(zoo, seed)
    parts = zoo.mass_matrix(q) @ a + zoo.coriolis_matrix(q, v) @ v + zoo.gravity_force(q)
    parts += zoo.elastic_force(q) + zoo.damping_matrix() @ v
    whole = zoo.inverse_dynamics(q, v, a)
    np.testing.assert_allclose(parts, whole, rtol=0, atol=1e-11 * np.abs(whole).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_forward_dynamics_undoes_inverse_dynamics(zoo, seed):
    q, v, _ = random_state(zoo, seed)
    efforts = np.array([0.3, -0.2, 8.0, 5.0])
    a = zoo.forward_dynamics(q, v, efforts)
    left = zoo.inverse_dynamics(q, v, a, efforts)
    assert np.abs(left).max() < 1e-9 * np.abs(zoo.inverse_dynamics(q, v, 0 * a, efforts)).max()


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_rate_minus_twice_coriolis_is_skew(zoo, seed):
    q, v, _ = random_state(zoo, seed)
    v = 0.2 * v
    rate = derivative(zoo.mass_matrix, q, v)
    coriolis = zoo.coriolis_matrix(q, v)
    skew = rate - 2.0 * coriolis
    assert np.abs(skew + skew.T).max() < 1e-8 * np.abs(coriolis).max()
    assert np.abs(skew).max() > 0.1 * np.abs(coriolis).max()


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_matrix_is_the_hessian_of_kinetic_energy_and_positive(zoo, seed):
    q, v, _ = random_state(zoo, seed)
    mass = zoo.mass_matrix(q)
    assert zoo.energies(q, v)[0] == pytest.approx(0.5 * v @ mass @ v, rel=1e-12)
    assert np.linalg.eigvalsh(mass).min() > 0.0


@pytest.mark.parametrize("seed", SEEDS)
def test_static_forces_are_the_gradient_of_potential_energy(zoo, seed):
    q, v, _ = random_state(zoo, seed)
    direction = 0.1 * v
    zero = np.zeros(zoo.n)
    slope = derivative(lambda x: sum(zoo.energies(x, zero)[1:]), q, direction)
    force = zoo.gravity_force(q) + zoo.elastic_force(q)
    assert force @ direction == pytest.approx(slope, rel=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_coriolis_force_is_lagranges_of_kinetic_energy(zoo, seed):
    """C q̇ = Ṁ q̇ − ∂T/∂q: independent of every sign in the recursion."""
    q, v, _ = random_state(zoo, seed)
    v = 0.2 * v
    rate = derivative(zoo.mass_matrix, q, v) @ v
    gradient = [
        derivative(lambda x: zoo.energies(x, v)[0], q, row / zoo.model.weight[i] * 0.1)
        * zoo.model.weight[i]
        / 0.1
        for i, row in enumerate(np.eye(zoo.n))
    ]
    force = zoo.coriolis_matrix(q, v) @ v
    np.testing.assert_allclose(force, rate - gradient, rtol=0, atol=1e-7 * np.abs(force).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_jacobian_gives_twists_and_its_rate_their_change(zoo, seed):
    q, v, _ = random_state(zoo, seed)
    v = 0.2 * v
    jacobian, rate = zoo.jacobians(q, v)
    np.testing.assert_allclose(jacobian @ v, zoo.node_twists(q, v), atol=1e-11)
    quotient = derivative(lambda x: zoo.jacobians(x, v)[0], q, v)
    np.testing.assert_allclose(rate, quotient, atol=1e-7 * np.abs(rate).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_power_of_all_forces_is_the_rate_of_energy(zoo, seed):
    """H changes by port power minus damping along any motion of the equations of motion."""
    q, v, _ = random_state(zoo, seed)
    v = 0.05 * v
    efforts = np.array([0.3, -0.2, 8.0, 5.0])
    a = zoo.forward_dynamics(q, v, efforts)
    zero = np.zeros(zoo.n)

    def energy(t):
        return sum(zoo.energies(q + t * v + 0.5 * t * t * a, v + t * a))

    h = 1e-6
    rate = (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h)
    power = efforts @ zoo.ports(q, v)[1] - v @ zoo.damping_matrix() @ v
    assert rate == pytest.approx(power, rel=1e-5)
    assert np.all(zoo.ports(q, zero)[1] == 0.0)
