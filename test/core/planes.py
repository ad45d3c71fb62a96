"""The equations of a scene in space and in its plane, side by side, for tests."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Model
from soft_sim_ros.core.recursion.elimination import dense, new_system
from soft_sim_ros.core.recursion.rnea import inverse_dynamics
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.settled import Dynamics


def in_both(
    dynamics: Dynamics, flat: Model, q: Floats, v: Floats, a: Floats
) -> Iterator[tuple[Floats, Floats]]:
    """Give residuals (n,), then tangents (n, n), each as (in space, in the plane)."""
    data = dynamics.forcing()
    results = []
    for model in (dynamics.model, flat):
        out, matrix = np.zeros(dynamics.n), np.zeros((dynamics.n, dynamics.n))
        system = new_system(model)
        inverse_dynamics(model, data, q, v, a, out)
        tangent(model, data, (0.7, 0.4, 1.0), system)
        dense(model, system, matrix)
        results.append((out, matrix))
    yield from zip(*results, strict=True)
