"""Derivatives of four segments at a time: their Jacobian columns and geometric stiffness."""

import numpy as np

from soft_sim_ros.core.algebra.dual import (
    add,
    apply_t,
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
from soft_sim_ros.core.algebra.maps import keep_hankel, keep_motion
from soft_sim_ros.core.algebra.rotation import (
    cotangent_apply,
    cotangent_derivative,
    kept_stumpff,
    stumpff_lanes,
    tangent_jet,
)
from soft_sim_ros.core.algebra.simd import WIDTH, each, lanes_from, nine, six, three
from soft_sim_ros.core.algebra.spaces import polar_of, rotation_of, size_of, twist_of, wrench_of
from soft_sim_ros.core.backend.jit import algebra, bare, unit

from .rnea import place


@algebra
def segment_stumpff(model, data, rows, series):
    """Return the Stumpff functions of segments ``rows``; series (1, 40) is scratch."""
    o = twist_of(model.space, six(data.omega, rows, 0))
    stumpff_lanes(dot(o[0], o[0]), series, 0)
    return kept_stumpff(series, 0)


@algebra
def pose_derivatives(model, data, rows, beyond, c, columns, here):
    """Fill rows ``here`` of columns (4, 12, 20) for segments ``rows``, nodes ``beyond`` them.

    Row 6g + j is the base-frame twist of the node beyond per unit of strain j at Gauss point g,
    and its two rates. c: the segments' Stumpff functions.
    """
    space = model.space
    half, kappa = each(model.half, rows, 0), each(model.kappa, rows, 0)
    t, t1, t2 = tangent_jet(
        twist_of(space, six(data.omega, rows, 0)),
        twist_of(space, six(data.omega, rows, 6)),
        twist_of(space, six(data.omega, rows, 12)),
        c,
    )
    rotation = rotation_of(space, nine(data.rotation, beyond, 0))
    position = polar_of(space, three(data.position, beyond, 0))
    frame = (rotation, mul(skew(position), rotation))
    eta = dskew(twist_of(space, six(data.eta, beyond, 0)))
    acc = twist_of(space, six(data.acc, beyond, 0))
    gravity = apply_t(rotation, polar_of(space, data.gravity))
    eta_rate = dskew((acc[0], add(acc[1], gravity)))
    s = dmul(eta, t)
    s1 = dmadd(s, t1)
    s2 = dmadd(dmul(eta, dmadd(s, rmscale(2.0, t1))), dmadd(dmul(eta_rate, t), t2))
    m, m1, m2 = dmul(frame, t), dmul(frame, s1), dmul(frame, s2)
    size = size_of(space)
    for g in range(2):
        other, at = 18 * (1 - g), 120 * g
        sign = -kappa if g == 0 else kappa
        x = twist_of(space, six(data.xi, rows, other))
        e = dmadd(dspherical((half, 0.0)), rmscale(sign, dskew(x)))
        e1 = rmscale(sign, dskew(twist_of(space, six(data.xi, rows, other + 6))))
        e2 = rmscale(sign, dskew(twist_of(space, six(data.xi, rows, other + 12))))
        p1 = dmadd(dmul(m1, e), dmul(m, e1))
        p2 = dmadd(dmul(m2, e), dmadd(rmscale(2.0, dmul(m1, e1)), dmul(m, e2)))
        keep_motion(space, columns, here, at, dmul(m, e))
        keep_motion(space, columns, here, at + size, p1)
        keep_motion(space, columns, here, at + 2 * size, p2)


@algebra
def local_stiffness(model, data, rows, beyond, c, hessian, here):
    """Fill rows ``here`` of hessian (4, 12, 12) for segments ``rows``, nodes ``beyond`` them.

    Row 6g + j is what the duals of ξ₁, ξ₂ gain per unit of strain j at Gauss point g, at a fixed
    wrench beyond.
    """
    space = model.space
    half, kappa = each(model.half, rows, 0), each(model.kappa, rows, 0)
    o = twist_of(space, six(data.omega, rows, 0))
    f = wrench_of(space, six(data.wrench, beyond, 0))
    q = cotangent_derivative(o, f, c)
    y = rmscale(kappa, dskew(cotangent_apply(o, f, c)))
    x1, x2 = twist_of(space, six(data.xi, rows, 0)), twist_of(space, six(data.xi, rows, 18))
    e1 = dmadd(dspherical((half, 0.0)), rmscale(-kappa, dskew(x2)))
    e2 = dmadd(dspherical((half, 0.0)), rmscale(kappa, dskew(x1)))
    qe1, qe2 = dmul(q, e1), dmul(q, e2)
    keep_hankel(space, hessian, here, 0, dmul(dtranspose(e1), qe1))
    keep_hankel(space, hessian, here, 72, dmadd(dmul(dtranspose(e1), qe2), rmscale(-1.0, y)))
    keep_hankel(space, hessian, here, 6, dmadd(dmul(dtranspose(e2), qe1), y))
    keep_hankel(space, hessian, here, 78, dmul(dtranspose(e2), qe2))


@unit
def node_jacobians(model, data, jacobian, rate):
    """Fill J and J̇ (nodes, 6, n) in the base frame, at the state of the last sweep.

    Dynamics of Soft Robots (1.25).
    """
    jacobian, rate = bare(jacobian), bare(rate)
    place(model, data)
    columns, series = np.zeros((WIDTH, 12, 20)), np.zeros((1, 40))
    n = jacobian.shape[2]
    count = len(model.half)
    for k in range(count):
        if k % WIDTH == 0:
            rows, beyond = lanes_from(k, count), lanes_from(k + 1, count + 1)
            c = segment_stumpff(model, data, rows, series)
            pose_derivatives(model, data, rows, beyond, c, columns, lanes_from(0, count - k))
        before = model.tree.node[k] if len(model.tree.node) > 0 else k
        for i in range(6):
            for j in range(n):
                jacobian[k + 1, i, j] = jacobian[before, i, j]
                rate[k + 1, i, j] = rate[before, i, j]
        for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
            j, comp = model.entry_col[e], model.entry_comp[e]
            for g in range(2):
                phi = model.entry_phi[e, g]
                for i in range(6):
                    jacobian[k + 1, i, j] += phi * columns[k % WIDTH, 6 * g + comp, i]
                    rate[k + 1, i, j] += phi * columns[k % WIDTH, 6 * g + comp, 6 + i]
