"""The analytic tangent is the derivative of the residual, for everything a scene can hold."""

import numpy as np
import pytest
from differences import central_difference
from scenes import ALL, random_state, rod, scene_of, zoo_document

from soft_sim_ros.core.settled import Dynamics

EFFORTS = np.array([0.3, -0.2, 8.0, 5.0])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("which", [0, 1, 2])
def test_tangent_of_the_zoo_is_its_difference_quotient(seed, which):
    dynamics = Dynamics(scene_of(zoo_document()))
    state = list(random_state(dynamics, seed))
    exact = dynamics.tangents(*state, efforts=EFFORTS, time=1.0)[which]

    def residual(x):
        moved = [*state]
        moved[which] = x
        return dynamics.inverse_dynamics(*moved, efforts=EFFORTS, time=1.0)

    size = np.full(dynamics.n, 1e-3) / np.maximum(dynamics.model.weight, 1e-3) * 0.1
    quotient = central_difference(residual, state[which], size)
    # rows and columns have very different units; compare them scaled to one
    scale = np.sqrt(np.outer(*2 * [np.abs(np.diag(exact)) + 1e-12]))
    assert np.max(np.abs(exact - quotient) / (scale + np.abs(exact))) < 2e-6


@pytest.mark.parametrize("kind", ["chebyshev", "monomial", "constant", "linear"])
def test_every_basis_has_the_right_tangent(kind):
    dynamics = rod(kind=kind, order=2, elements=3, gravity=(1.0, 2.0, -9.0), strains=ALL[:4])
    q, v, a = random_state(dynamics, 5)
    exact = dynamics.tangents(q, v, a)[0]
    size = 1e-4 / dynamics.model.weight
    quotient = central_difference(lambda x: dynamics.inverse_dynamics(x, v, a), q, size)
    scale = np.sqrt(np.outer(*2 * [np.abs(np.diag(exact)) + 1e-12]))
    assert np.max(np.abs(exact - quotient) / (scale + np.abs(exact))) < 2e-6


def test_tendon_and_moment_forces_are_the_gradient_of_their_port_positions():
    dynamics = Dynamics(scene_of(zoo_document()))
    q, _, _ = random_state(dynamics, 7)
    zero = np.zeros(dynamics.n)
    rest = dynamics.inverse_dynamics(q, zero, zero)
    size = 1e-4 / np.maximum(dynamics.model.weight, 1e-3)
    for i in range(dynamics.actuators):
        effort = np.zeros(dynamics.actuators)
        effort[i] = 1.7
        force = rest - dynamics.inverse_dynamics(q, zero, zero, efforts=effort)
        gradient = central_difference(lambda x, i=i: dynamics.ports(x, zero)[0][[i]], q, size)[0]
        np.testing.assert_allclose(force, 1.7 * gradient, atol=1e-8 * np.abs(force).max())


def test_port_velocity_is_the_rate_of_the_port_position():
    dynamics = Dynamics(scene_of(zoo_document()))
    q, v, _ = random_state(dynamics, 8)
    h = 1e-5
    zero = np.zeros(dynamics.n)
    rate = (dynamics.ports(q + h * v, zero)[0] - dynamics.ports(q - h * v, zero)[0]) / (2 * h)
    np.testing.assert_allclose(dynamics.ports(q, v)[1], rate, rtol=1e-7)
