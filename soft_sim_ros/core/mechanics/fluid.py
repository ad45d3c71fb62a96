"""What the surrounding fluid adds to the parts of the equations of motion, and to wrenches."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.compile.fluid import places_of
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Data, Model, Wetted
from soft_sim_ros.core.recursion.rnea import inverse_dynamics
from soft_sim_ros.core.terms.fluid import fluid_wrench


def _carried(fluid: Wetted, jacobians: Floats, e: int) -> Floats:
    """Return the body Jacobian (6, n) of a place, or its rate, from those of all nodes."""
    offset = np.eye(4)
    offset[:3, :3], offset[:3, 3] = fluid.frame[e, :9].reshape(3, 3), fluid.frame[e, 9:]
    out: Floats = se3.Ad(se3.inverse(offset)) @ jacobians[fluid.node[e]]
    return out


def added_coriolis(fluid: Wetted, jacobians: Floats, rates: Floats, v: Floats) -> Floats:
    """Return the part (n, n) of the Coriolis matrix that belongs to the added mass.

    Kirchhoff's equations: Σ Jᵀ (𝓜_A J̇ + (𝓜_A ad_η − ad_ηᵀ 𝓜_A) J), with the null term
    𝓜_A ad_η that makes Ṁ − 2C skew.
    """
    out = np.zeros((len(v), len(v)))
    for e in range(len(fluid.node)):
        own, rate = _carried(fluid, jacobians, e), _carried(fluid, rates, e)
        added, ad = np.diag(fluid.added[e]), se3.ad(own @ v)
        out += own.T @ (added @ rate + (added @ ad - ad.T @ added) @ own)
    return out


def viscous_matrix(fluid: Wetted, jacobians: Floats) -> Floats:
    """Return Σ Jᵀ diag(viscous) J (n, n): drag in proportion to velocity."""
    out = np.zeros((jacobians.shape[2],) * 2)
    for e in range(len(fluid.node)):
        if fluid.viscous[e].any():
            own = _carried(fluid, jacobians, e)
            out += own.T @ (fluid.viscous[e][:, None] * own)
    return out


def other_force(model: Model, data: Data, q: Floats, v: Floats) -> Floats:
    """Return the force (n,) of the fluid that is not in M, C, g or R.

    That is quadratic drag, lift, all that a current does, and the pressure that ends lack.
    """
    found = np.zeros((2, len(q)))
    inverse_dynamics(model, data, q, v, np.zeros(len(q)), found[0])
    nothing = {name: np.zeros_like(getattr(model.fluid, name)) for name in _OTHER}
    calm = model._replace(fluid=model.fluid._replace(**nothing))
    current = data.current.copy()
    data.current[:] = 0.0
    inverse_dynamics(calm, data, q, v, np.zeros(len(q)), found[1])
    data.current[:] = current
    out: Floats = found[1] - found[0]
    return out


_OTHER = ("quadratic", "lift", "end")


def densities(compiled: Compiled, data: Data) -> dict[int, Floats]:
    """Return minus the wrench of the fluid per length (N, 6) at the nodes of elements of rods.

    By the first segment of an element, in section axes, at the last residual; only of elements
    that the fluid touches.
    """
    out: dict[int, Floats] = {}
    for first, (places, lengths) in places_of(compiled.scene, compiled.chain).items():
        found = np.zeros((len(places), 6))
        for row, e in zip(found, places.tolist(), strict=True):
            fluid_wrench(compiled.model, data, e, row)
        out[first] = found / lengths[:, None]
    return out
