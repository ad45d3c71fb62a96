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
    load_mat,
    load_twist,
    load_vec,
    load_wrench,
    mul,
    rmscale,
    skew,
)
from .jit import bare, kernel, unit
from .rotation import cotangent_apply, cotangent_derivative, stumpff, tangent_jet
from .sweep import place


@kernel
def put_lower(out, m):
    """Write the dual matrix m as the 6x6 matrix of a map between twists."""
    for i in range(3):
        for j in range(3):
            out[i, j] = m[0][3 * i + j]
            out[i + 3, j + 3] = m[0][3 * i + j]
            out[i + 3, j] = m[1][3 * i + j]
            out[i, j + 3] = 0.0


@kernel
def put_hankel(out, m):
    """Write the dual matrix m as the 6x6 matrix of a map from twists (w, v) to wrenches (M, N)."""
    for i in range(3):
        for j in range(3):
            out[i, j] = m[1][3 * i + j]
            out[i, j + 3] = m[0][3 * i + j]
            out[i + 3, j] = m[0][3 * i + j]
            out[i + 3, j + 3] = 0.0


@kernel
def pose_derivatives(model, data, k, columns):
    """Fill columns (6, 6, 6): base-frame twist of node k + 1 per unit ξ₁, ξ₂, and its rates.

    Order of the first index: P₁, P₂, Ṗ₁, Ṗ₂, P̈₁, P̈₂.
    """
    half, kappa = model.half[k], model.kappa[k]
    o = load_twist(data.omega[k, 0])
    t, t1, t2 = tangent_jet(
        o, load_twist(data.omega[k, 1]), load_twist(data.omega[k, 2]), stumpff(dot(o[0], o[0]))
    )
    rotation, position = load_mat(data.rotation[k + 1]), load_vec(data.position[k + 1])
    frame = (rotation, mul(skew(position), rotation))
    eta = dskew(load_twist(data.eta[k + 1]))
    acc = load_twist(data.acc[k + 1])
    gravity = dapply_t((rotation, skew((0.0, 0.0, 0.0))), (load_vec(data.gravity), (0.0, 0.0, 0.0)))
    eta_rate = dskew((acc[0], add(acc[1], gravity[0])))
    s = dmul(eta, t)
    s1 = dmadd(s, t1)
    s2 = dmadd(dmul(eta, dmadd(s, rmscale(2.0, t1))), dmadd(dmul(eta_rate, t), t2))
    m, m1, m2 = dmul(frame, t), dmul(frame, s1), dmul(frame, s2)
    for g in range(2):
        other = 1 - g
        sign = -kappa if g == 0 else kappa
        e = dmadd(dspherical((half, 0.0)), rmscale(sign, dskew(load_twist(data.xi[k, other, 0]))))
        put_lower(columns[g], dmul(m, e))
        if kappa == 0.0:
            put_lower(columns[2 + g], dmul(m1, e))
            put_lower(columns[4 + g], dmul(m2, e))
        else:
            e1 = rmscale(sign, dskew(load_twist(data.xi[k, other, 1])))
            e2 = rmscale(sign, dskew(load_twist(data.xi[k, other, 2])))
            put_lower(columns[2 + g], dmadd(dmul(m1, e), dmul(m, e1)))
            p2 = dmadd(dmul(m2, e), dmadd(rmscale(2.0, dmul(m1, e1)), dmul(m, e2)))
            put_lower(columns[4 + g], p2)


@kernel
def local_stiffness(model, data, k, hessian):
    """Fill hessian (2, 2, 6, 6): derivative of the duals of ξ₁, ξ₂ at a fixed wrench beyond."""
    half, kappa = model.half[k], model.kappa[k]
    o = load_twist(data.omega[k, 0])
    c = stumpff(dot(o[0], o[0]))
    f = load_wrench(data.wrench[k + 1])
    q = cotangent_derivative(o, f, c)
    y = dskew(cotangent_apply(o, f, c))
    x1, x2 = load_twist(data.xi[k, 0, 0]), load_twist(data.xi[k, 1, 0])
    e1 = dmadd(dspherical((half, 0.0)), rmscale(-kappa, dskew(x2)))
    e2 = dmadd(dspherical((half, 0.0)), rmscale(kappa, dskew(x1)))
    qe1, qe2 = dmul(q, e1), dmul(q, e2)
    put_hankel(hessian[0, 0], dmul(dtranspose(e1), qe1))
    put_hankel(hessian[0, 1], dmadd(dmul(dtranspose(e1), qe2), rmscale(-kappa, y)))
    put_hankel(hessian[1, 0], dmadd(dmul(dtranspose(e2), qe1), rmscale(kappa, y)))
    put_hankel(hessian[1, 1], dmul(dtranspose(e2), qe2))


@unit
def node_jacobians(model, data, jacobian, rate):
    """Fill J and J̇ (nodes, 6, n) in the base frame, at the state of the last sweep: C (1.25)."""
    model, data, jacobian, rate = bare(model), bare(data), bare(jacobian), bare(rate)
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
