"""Block elimination along the chain solves the same system as dense algebra."""

import numpy as np
import pytest
from scenes import ALL, random_state, rod, scene_of, zoo_document

from soft_sim_ros.core.recursion.elimination import factor, new_system, solve
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.settled import Dynamics


@pytest.mark.parametrize(
    "alpha", [(1e-6, 1e-3, 1.0), (1e-2, 0.1, 1.0), (0.0, 0.0, 1.0), (1.0, 0, 0)]
)
@pytest.mark.parametrize(
    "dynamics",
    [
        pytest.param(lambda: Dynamics(scene_of(zoo_document())), id="zoo"),
        pytest.param(lambda: rod(order=1, elements=7, gravity=(0, 0, -9.8)), id="elements"),
        pytest.param(lambda: rod(kind="linear", elements=5, strains=ALL[:4]), id="hats"),
    ],
)
def test_block_elimination_agrees_with_dense_algebra(dynamics, alpha):
    dynamics = dynamics()
    q, v, a = random_state(dynamics, 2)
    dynamics.residual(q, 0.1 * v, 0.1 * a, dynamics.forcing())
    alpha = tuple(float(x) for x in alpha)
    matrix = dynamics.last_tangent(alpha)
    system = new_system(dynamics.model)
    tangent(dynamics.model, dynamics._data, alpha, system)
    assert factor(dynamics.model, system)
    known = np.random.default_rng(1).normal(size=dynamics.n) / dynamics.model.weight
    found = matrix @ known
    solve(dynamics.model, system, found)
    error = np.abs((found - known) * dynamics.model.weight).max()
    assert error < 1e-13 * np.linalg.cond(matrix / np.outer(*2 * [dynamics.model.weight])) + 1e-9


def test_a_singular_block_is_reported():
    dynamics = rod(order=0, strains=["bend_z"])
    system = new_system(dynamics.model)
    system.diagonal[:] = 0.0
    assert not factor(dynamics.model, system)
