"""The recursion over the chain: motion from base to tip, wrenches from tip to base.

``inverse_dynamics`` is the residual of everything: statics, forward dynamics and every implicit
step. It returns

    r = M(q) q̈ + C(q, q̇) q̇ + g(q) + K q + R q̇ − (loads and actuators),

of C (1.31) with the misprints of (1.35), (1.36) settled by virtual work (k = ∫Φᵀ H Φ q, R = ∫Φᵀ Γ
Φ).
"""

from .actuators import actuation
from .drag import drag_wrench
from .dual import (
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
    load_wrench,
    mul,
    rscale,
    scale,
    store_mat,
    store_twist,
    store_vec,
    store_wrench,
    sub,
)
from .fibres import fibre_forces
from .jit import bare, kernel, unit
from .rotation import cotangent_apply, exp_translation, rotation_exp, stumpff, tangent_apply


@kernel
def strains(model, data, q, v, a):
    """Fill data.xi: strain, rate and acceleration at both Gauss points of every segment."""
    xi = data.xi
    for k in range(len(model.half)):
        for i in range(2):
            for c in range(6):
                xi[k, i, 0, c] = model.xi0[k, i, c]
                xi[k, i, 1, c] = 0.0
                xi[k, i, 2, c] = 0.0
        for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
            col, c = model.entry_col[e], model.entry_comp[e]
            for i in range(2):
                phi = model.entry_phi[e, i]
                xi[k, i, 0, c] += phi * q[col]
                xi[k, i, 1, c] += phi * v[col]
                xi[k, i, 2, c] += phi * a[col]


@kernel
def kinematics(model, data):
    """Carry twist and acceleration from base to tip; data.xi must be filled.

    data.acc is the acceleration minus gravity, which makes weight an inertial force.
    """
    gravity = load_vec(data.gravity)
    eta = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    acc = ((0.0, 0.0, 0.0), scale(-1.0, gravity))
    store_twist(data.eta[0], eta)
    store_twist(data.acc[0], acc)
    for k in range(len(model.half)):
        half, kappa = model.half[k], model.kappa[k]
        x1, x2 = load_twist(data.xi[k, 0, 0]), load_twist(data.xi[k, 1, 0])
        u1, u2 = load_twist(data.xi[k, 0, 1]), load_twist(data.xi[k, 1, 1])
        z1, z2 = load_twist(data.xi[k, 0, 2]), load_twist(data.xi[k, 1, 2])
        omega, u, z = (
            rscale(half, dadd(x1, x2)),
            rscale(half, dadd(u1, u2)),
            rscale(half, dadd(z1, z2)),
        )
        if kappa != 0.0:
            omega = dadd(omega, rscale(kappa, dcross(x1, x2)))
            u = dadd(u, rscale(kappa, dadd(dcross(u1, x2), dcross(x1, u2))))
            bracket = dadd(dcross(z1, x2), dcross(x1, z2))
            z = dadd(z, rscale(kappa, dadd(bracket, rscale(2.0, dcross(u1, u2)))))
        store_twist(data.omega[k, 0], omega)
        store_twist(data.omega[k, 1], u)
        store_twist(data.omega[k, 2], z)
        c = stumpff(dot(omega[0], omega[0]))
        turn = rotation_exp(omega[0], c)
        shift = exp_translation(omega[0], omega[1], c)
        store_mat(data.relative[k], turn)
        store_vec(data.relative[k, 9:], shift)
        velocity, rate = tangent_apply(omega, u, z, c)
        # η⁺ = Ad⁻¹η + v,  η̇⁺ = Ad⁻¹η̇ − [v, Ad⁻¹η] + v̇
        carried = (apply_t(turn, eta[0]), apply_t(turn, sub(eta[1], cross(shift, eta[0]))))
        acc = (apply_t(turn, acc[0]), apply_t(turn, sub(acc[1], cross(shift, acc[0]))))
        acc = dadd(dsub(acc, dcross(velocity, carried)), rate)
        eta = dadd(carried, velocity)
        store_twist(data.eta[k + 1], eta)
        store_twist(data.acc[k + 1], acc)


@kernel
def place(model, data):
    """Fill orientation and position of every node in the base frame from the last kinematics."""
    rotation, position = load_mat(data.rotation[0]), load_vec(data.position[0])
    for k in range(len(model.half)):
        position = add(position, apply(rotation, load_vec(data.relative[k, 9:])))
        rotation = mul(rotation, load_mat(data.relative[k]))
        store_mat(data.rotation[k + 1], rotation)
        store_vec(data.position[k + 1], position)


@kernel
def node_wrench(model, data, k):
    """Return inertial minus external wrench of node k in its own frame, as N + εM."""
    mass = model.inertia[k, 0]
    eta, acc = load_twist(data.eta[k]), load_twist(data.acc[k])
    force = scale(mass, add(acc[1], cross(eta[0], eta[1])))
    j1, j2, j3 = model.inertia[k, 1], model.inertia[k, 2], model.inertia[k, 3]
    spin = (j1 * eta[0][0], j2 * eta[0][1], j3 * eta[0][2])
    moment = add((j1 * acc[0][0], j2 * acc[0][1], j3 * acc[0][2]), cross(eta[0], spin))
    if len(model.drag) > 0:
        pull, twist = drag_wrench(model, k, eta)
        force, moment = add(force, pull), add(moment, twist)
    if data.active[0] != 0:
        rotation, dead = load_mat(data.rotation[k]), load_wrench(data.dead[k])
        force = sub(force, apply_t(rotation, dead[0]))
        moment = sub(moment, apply_t(rotation, dead[1]))
    if data.active[1] != 0:
        follower = load_wrench(data.follower[k])
        force, moment = sub(force, follower[0]), sub(moment, follower[1])
    return (force, moment)


@kernel
def project(model, data, r):
    """Carry wrenches from tip to base and add their projection on the coordinates to r."""
    segments = len(model.half)
    wrench = node_wrench(model, data, segments)
    store_wrench(data.wrench[segments], wrench)
    for k in range(segments - 1, -1, -1):
        if model.entry_ptr[k + 1] > model.entry_ptr[k]:
            omega = load_twist(data.omega[k, 0])
            y = cotangent_apply(omega, wrench, stumpff(dot(omega[0], omega[0])))
            half, kappa = model.half[k], model.kappa[k]
            f1 = rscale(half, y)
            f2 = f1
            if kappa != 0.0:
                x1, x2 = load_twist(data.xi[k, 0, 0]), load_twist(data.xi[k, 1, 0])
                f1 = dadd(f1, rscale(kappa, dcross(x2, y)))
                f2 = dsub(f2, rscale(kappa, dcross(x1, y)))
            w1 = (f1[1][0], f1[1][1], f1[1][2], f1[0][0], f1[0][1], f1[0][2])
            w2 = (f2[1][0], f2[1][1], f2[1][2], f2[0][0], f2[0][1], f2[0][2])
            for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
                comp = model.entry_comp[e]
                r[model.entry_col[e]] += (
                    model.entry_phi[e, 0] * w1[comp] + model.entry_phi[e, 1] * w2[comp]
                )
        turn, shift = load_mat(data.relative[k]), load_vec(data.relative[k, 9:])
        force = apply(turn, wrench[0])
        moment = add(apply(turn, wrench[1]), cross(shift, force))
        wrench = dadd((force, moment), node_wrench(model, data, k))
        store_wrench(data.wrench[k], wrench)


@kernel
def internal_forces(model, q, v, r):
    """Add K q + R v to r."""
    for i in range(len(model.law_ptr) - 1):
        for e in range(model.law_ptr[i], model.law_ptr[i + 1]):
            j = model.law_col[e]
            r[i] += model.stiffness[e] * q[j] + model.damping[e] * v[j]


@unit
def inverse_dynamics(model, data, q, v, a, r):
    """Fill r with the residual of the motion (q, v, a) under the loads and efforts in data."""
    model, data, q, v, a, r = bare(model), bare(data), bare(q), bare(v), bare(a), bare(r)
    for i in range(len(r)):
        r[i] = 0.0
    strains(model, data, q, v, a)
    kinematics(model, data)
    if data.active[0] != 0:
        place(model, data)
    project(model, data, r)
    internal_forces(model, q, v, r)
    if len(model.fibres.block) > 0:
        fibre_forces(model.fibres, data.section, q, r)
    actuation(model, data, q, r)
