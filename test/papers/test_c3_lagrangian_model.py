"""C (1.31)–(1.36): M, C, g, k, R, and the Coriolis matrix once more from Christoffel symbols."""

import numpy as np
import pytest
from scenes import ALL, random_state, rod, scene_of, zoo_document

from soft_sim_ros.core.settled import Dynamics

SEEDS = range(3)


@pytest.fixture(scope="module")
def zoo():
    document = zoo_document()
    document["loads"] = []
    return Dynamics(scene_of(document))


def state(dynamics, seed):
    q, v, a = random_state(dynamics, seed)
    return q, 0.2 * v, a


def difference_quotient(function, x, direction):
    """Sixth-order difference quotient of function along a direction."""
    h = 2e-3
    total = 0.0
    for k, w in ((1, 45.0), (2, -9.0), (3, 1.0)):
        total = total + w * (function(x + k * h * direction) - function(x - k * h * direction))
    return total / (60.0 * h)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_derivative_of_the_mass_matrix_is_its_difference_quotient(zoo, seed):
    q, v, _ = state(zoo, seed)
    quotient = difference_quotient(zoo.mass_matrix, q, v)
    exact = zoo.mass_matrix_derivative(q) @ v
    np.testing.assert_allclose(exact, quotient, rtol=0, atol=1e-9 * np.abs(quotient).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_both_coriolis_matrices_give_one_force(zoo, seed):
    """(1.33) by the recursion and by Christoffel symbols of M alone."""
    q, v, _ = state(zoo, seed)
    by_integral = zoo.coriolis_matrix(q, v) @ v
    by_symbols = zoo.christoffel_matrix(q, v) @ v
    size = np.abs(by_integral).max()
    assert size > 0.0
    np.testing.assert_allclose(by_symbols, by_integral, rtol=0, atol=1e-10 * size)


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_rate_minus_twice_either_is_skew_without_difference_quotients(zoo, seed):
    q, v, _ = state(zoo, seed)
    rate = zoo.mass_matrix_derivative(q) @ v
    for coriolis in (zoo.coriolis_matrix(q, v), zoo.christoffel_matrix(q, v)):
        skew = rate - 2.0 * coriolis
        assert np.abs(skew + skew.T).max() < 1e-10 * np.abs(coriolis).max()
        assert np.abs(skew).max() > 0.1 * np.abs(coriolis).max()


def test_the_two_matrices_are_not_the_same_matrix():
    """They share C q̇ and skewness; the rest is a choice, and in space the choices differ."""
    dynamics = rod(order=1, strains=ALL[:3])
    q, v, _ = state(dynamics, 1)
    by_integral, by_symbols = dynamics.coriolis_matrix(q, v), dynamics.christoffel_matrix(q, v)
    assert np.abs(by_integral - by_symbols).max() > 0.01 * np.abs(by_symbols).max()


@pytest.mark.parametrize("seed", SEEDS)
def test_1_43_holds_with_the_other_sign(zoo, seed):
    """N q̇ = (Ṁ − 2C) q̇ = ∂(q̇ᵀ M q̇)/∂q − Ṁ q̇, where (1.43) prints −∂(q̇ᵀ M q̇)/∂q − Ṁ q̇."""
    q, v, _ = state(zoo, seed)
    slope = zoo.mass_matrix_derivative(q)
    gradient = np.einsum("ijk,i,j->k", slope, v, v)
    rate = slope @ v
    left = (rate - 2.0 * zoo.christoffel_matrix(q, v)) @ v
    size = np.abs(left).max()
    np.testing.assert_allclose(left, gradient - rate @ v, rtol=0, atol=1e-11 * size)
    assert np.abs(left - (-gradient - rate @ v)).max() > 0.1 * size


@pytest.mark.parametrize("seed", SEEDS)
def test_jacobian_projects_nothing_of_the_material(zoo, seed):
    """(1.35), (1.36) print Jᵀ; only Φᵀ gives the gradient of the energy, whatever the pose."""
    q, v, _ = state(zoo, seed)
    zero = np.zeros(zoo.n)

    def energy(x):
        return zoo.energies(x, zero)[1]

    slope = difference_quotient(energy, q, v)
    assert zoo.elastic_force(q) @ v == pytest.approx(slope, rel=1e-9)
    turned = np.array(q)
    turned[zoo.compiled.chain.joints["knee"]] += 1.0  # another pose, the same strains
    same = [i for i in range(zoo.n) if i not in zoo.compiled.chain.joints.values()]
    np.testing.assert_array_equal(zoo.elastic_force(turned)[same], zoo.elastic_force(q)[same])


@pytest.mark.parametrize("seed", SEEDS)
def test_the_five_parts_are_the_residual(zoo, seed):
    q, v, a = state(zoo, seed)
    parts = zoo.mass_matrix(q) @ a + zoo.christoffel_matrix(q, v) @ v + zoo.gravity_force(q)
    parts += zoo.elastic_force(q) + zoo.damping_matrix() @ v
    whole = zoo.inverse_dynamics(q, v, a)
    np.testing.assert_allclose(parts, whole, rtol=0, atol=1e-10 * np.abs(whole).max())
