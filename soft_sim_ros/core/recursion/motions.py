"""Motion of frames between nodes: one more segment of the recursion for each."""

import numpy as np

from soft_sim_ros.core.algebra.dual import (
    add,
    apply,
    apply_t,
    cross,
    dadd,
    dcross,
    dot,
    dsub,
    load_mat,
    load_twist,
    load_vec,
    mul,
    rscale,
    store_mat,
    store_twist,
    store_vec,
    sub,
)
from soft_sim_ros.core.algebra.rotation import (
    exp_translation,
    rotation_exp,
    stumpff,
    tangent_apply,
)
from soft_sim_ros.core.backend.jit import bare, unit

# columns of what ``sample_motions`` fills: rotation by rows and position in the base frame, twist,
# and its rate, which is counted from free fall
TURN, AT, TWIST, RATE, WIDTH = 0, 9, 12, 18, 24


@unit
def sample_motions(data, samples, q, v, a, out):
    """Fill out (P, WIDTH) from the last recursion with (q, v, a), its nodes placed.

    By the formulas of ``rnea.py``; samples as for ``sample_poses``.
    """
    q, v, a, out = bare(q), bare(v), bare(a), bare(out)
    xi = np.zeros((2, 3, 6))
    for p in range(len(samples.node)):
        for i in range(2):
            for c in range(6):
                xi[i, 0, c] = samples.xi0[p, i, c]
                xi[i, 1, c] = xi[i, 2, c] = 0.0
        for e in range(samples.entry_ptr[p], samples.entry_ptr[p + 1]):
            col, c = samples.entry_col[e], samples.entry_comp[e]
            for i in range(2):
                phi = samples.entry_phi[e, i]
                xi[i, 0, c] += phi * q[col]
                xi[i, 1, c] += phi * v[col]
                xi[i, 2, c] += phi * a[col]
        half, kappa = samples.half[p], samples.kappa[p]
        x1, x2 = load_twist(xi[0, 0]), load_twist(xi[1, 0])
        u1, u2 = load_twist(xi[0, 1]), load_twist(xi[1, 1])
        z1, z2 = load_twist(xi[0, 2]), load_twist(xi[1, 2])
        omega = dadd(rscale(half, dadd(x1, x2)), rscale(kappa, dcross(x1, x2)))
        bend = dadd(dcross(u1, x2), dcross(x1, u2))
        u = dadd(rscale(half, dadd(u1, u2)), rscale(kappa, bend))
        bend = dadd(dadd(dcross(z1, x2), dcross(x1, z2)), rscale(2.0, dcross(u1, u2)))
        z = dadd(rscale(half, dadd(z1, z2)), rscale(kappa, bend))
        c = stumpff(dot(omega[0], omega[0]))
        turn, shift = rotation_exp(omega[0], c), exp_translation(omega[0], omega[1], c)
        velocity, rate = tangent_apply(omega, u, z, c)
        k = samples.node[p]
        rotation = load_mat(data.rotation[k])
        eta, acc = load_twist(data.eta[k]), load_twist(data.acc[k])
        carried = (apply_t(turn, eta[0]), apply_t(turn, sub(eta[1], cross(shift, eta[0]))))
        acc = (apply_t(turn, acc[0]), apply_t(turn, sub(acc[1], cross(shift, acc[0]))))
        store_mat(out[p, TURN:], mul(rotation, turn))
        store_vec(out[p, AT:], add(load_vec(data.position[k]), apply(rotation, shift)))
        store_twist(out[p, TWIST:], dadd(carried, velocity))
        store_twist(out[p, RATE:], dadd(dsub(acc, dcross(velocity, carried)), rate))
