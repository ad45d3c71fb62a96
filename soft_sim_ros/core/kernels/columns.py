"""Derivatives of one segment: the columns it adds to the Jacobian, and its geometric stiffness."""

import numpy as np

from .dual import (
    add,
    dapply_t,
    dmadd,
    dmul,
    dot,
    dskew,
    dspherical,
    dtranspose,
    mul,
    rmscale,
    skew,
)
from .jit import algebra, bare, unit
from .rotation import cotangent_apply, cotangent_derivative, stumpff, tangent_jet
from .spaces import (
    keep_hankel,
    keep_motion,
    polar_of,
    rotation_of,
    twist_of,
    wrench_of,
)
from .sweep import place


@algebra
def pose_derivatives(model, data, k, columns):
    """Fill columns (6, rows, 6): base-frame twist of node k + 1 per unit ξ₁, ξ₂, and its rates.

    Order of the first index: P₁, P₂, Ṗ₁, Ṗ₂, P̈₁, P̈₂.
    """
    space = model.space
    half, kappa = model.half[k], model.kappa[k]
    o = twist_of(space, data.omega[k, 0])
    t, t1, t2 = tangent_jet(
        o,
        twist_of(space, data.omega[k, 1]),
        twist_of(space, data.omega[k, 2]),
        stumpff(dot(o[0], o[0])),
    )
    rotation, position = (
        rotation_of(space, data.rotation[k + 1]),
        polar_of(space, data.position[k + 1]),
    )
    frame = (rotation, mul(skew(position), rotation))
    eta = dskew(twist_of(space, data.eta[k + 1]))
    acc = twist_of(space, data.acc[k + 1])
    gravity = dapply_t(
        (rotation, skew((0.0, 0.0, 0.0))), (polar_of(space, data.gravity), (0.0, 0.0, 0.0))
    )
    eta_rate = dskew((acc[0], add(acc[1], gravity[0])))
    s = dmul(eta, t)
    s1 = dmadd(s, t1)
    s2 = dmadd(dmul(eta, dmadd(s, rmscale(2.0, t1))), dmadd(dmul(eta_rate, t), t2))
    m, m1, m2 = dmul(frame, t), dmul(frame, s1), dmul(frame, s2)
    for g in range(2):
        other = 1 - g
        sign = -kappa if g == 0 else kappa
        e = dmadd(
            dspherical((half, 0.0)), rmscale(sign, dskew(twist_of(space, data.xi[k, other, 0])))
        )
        keep_motion(space, columns[g], dmul(m, e))
        if kappa == 0.0:
            keep_motion(space, columns[2 + g], dmul(m1, e))
            keep_motion(space, columns[4 + g], dmul(m2, e))
        else:
            e1 = rmscale(sign, dskew(twist_of(space, data.xi[k, other, 1])))
            e2 = rmscale(sign, dskew(twist_of(space, data.xi[k, other, 2])))
            keep_motion(space, columns[2 + g], dmadd(dmul(m1, e), dmul(m, e1)))
            p2 = dmadd(dmul(m2, e), dmadd(rmscale(2.0, dmul(m1, e1)), dmul(m, e2)))
            keep_motion(space, columns[4 + g], p2)


@algebra
def local_stiffness(model, data, k, hessian):
    """Fill hessian (2, 2, 6, 6): derivative of the duals of ξ₁, ξ₂ at a fixed wrench beyond."""
    space = model.space
    half, kappa = model.half[k], model.kappa[k]
    o = twist_of(space, data.omega[k, 0])
    c = stumpff(dot(o[0], o[0]))
    f = wrench_of(space, data.wrench[k + 1])
    q = cotangent_derivative(o, f, c)
    y = dskew(cotangent_apply(o, f, c))
    x1, x2 = twist_of(space, data.xi[k, 0, 0]), twist_of(space, data.xi[k, 1, 0])
    e1 = dmadd(dspherical((half, 0.0)), rmscale(-kappa, dskew(x2)))
    e2 = dmadd(dspherical((half, 0.0)), rmscale(kappa, dskew(x1)))
    qe1, qe2 = dmul(q, e1), dmul(q, e2)
    keep_hankel(space, hessian[0, 0], dmul(dtranspose(e1), qe1))
    keep_hankel(space, hessian[0, 1], dmadd(dmul(dtranspose(e1), qe2), rmscale(-kappa, y)))
    keep_hankel(space, hessian[1, 0], dmadd(dmul(dtranspose(e2), qe1), rmscale(kappa, y)))
    keep_hankel(space, hessian[1, 1], dmul(dtranspose(e2), qe2))


@unit
def node_jacobians(model, data, jacobian, rate):
    """Fill J and J̇ (nodes, 6, n) in the base frame, at the state of the last sweep: C (1.25)."""
    jacobian, rate = bare(jacobian), bare(rate)
    place(model, data)
    columns = np.zeros((6, 6, 6))
    n = jacobian.shape[2]
    for k in range(len(model.half)):
        for c in range(6):
            for j in range(n):
                jacobian[k + 1, c, j] = jacobian[k, c, j]
                rate[k + 1, c, j] = rate[k, c, j]
        if model.entry_ptr[k + 1] == model.entry_ptr[k]:
            continue
        pose_derivatives(model, data, k, columns)
        for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
            j, comp = model.entry_col[e], model.entry_comp[e]
            for g in range(2):
                phi = model.entry_phi[e, g]
                for c in range(6):
                    jacobian[k + 1, c, j] += phi * columns[g, c, comp]
                    rate[k + 1, c, j] += phi * columns[2 + g, c, comp]
