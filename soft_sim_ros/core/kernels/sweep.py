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
    mul,
    rscale,
    scale,
    sub,
)
from .fibres import fibre_forces
from .jit import algebra, bare, kernel, unit
from .rotation import cotangent_apply, exp_translation, rotation_exp, stumpff, tangent_apply
from .spaces import (
    keep_polar,
    keep_rotation,
    keep_twist,
    keep_wrench,
    polar_of,
    rotation_of,
    twist_of,
    wrench_of,
)


@kernel
def strains(model, data, q, v, a):
    """Fill data.xi: strain, rate and acceleration at both Gauss points of every segment.

    Entries of a segment are in the order of their components, so each component is summed up in
    registers; rates without coordinates are the zeros they were allocated as.
    """
    xi = data.xi
    for k in range(len(model.half)):
        for i in range(2):
            for c in range(6):
                xi[k, i, 0, c] = model.xi0[k, i, c]
        e, end = model.entry_ptr[k], model.entry_ptr[k + 1]
        while e < end:
            c = model.entry_comp[e]
            x1, x2, u1, u2, z1, z2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            while e < end and model.entry_comp[e] == c:
                col, phi1, phi2 = model.entry_col[e], model.entry_phi[e, 0], model.entry_phi[e, 1]
                x1 += phi1 * q[col]
                x2 += phi2 * q[col]
                u1 += phi1 * v[col]
                u2 += phi2 * v[col]
                z1 += phi1 * a[col]
                z2 += phi2 * a[col]
                e += 1
            xi[k, 0, 0, c] += x1
            xi[k, 1, 0, c] += x2
            xi[k, 0, 1, c], xi[k, 1, 1, c] = u1, u2
            xi[k, 0, 2, c], xi[k, 1, 2, c] = z1, z2


@algebra
def kinematics(model, data):
    """Carry twist and acceleration from base to tip; data.xi must be filled.

    data.acc is the acceleration minus gravity, which makes weight an inertial force.
    """
    space = model.space
    gravity = polar_of(space, data.gravity)
    eta = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    acc = ((0.0, 0.0, 0.0), scale(-1.0, gravity))
    keep_twist(space, data.eta[0], eta)
    keep_twist(space, data.acc[0], acc)
    for k in range(len(model.half)):
        half, kappa = model.half[k], model.kappa[k]
        x1, x2 = twist_of(space, data.xi[k, 0, 0]), twist_of(space, data.xi[k, 1, 0])
        u1, u2 = twist_of(space, data.xi[k, 0, 1]), twist_of(space, data.xi[k, 1, 1])
        z1, z2 = twist_of(space, data.xi[k, 0, 2]), twist_of(space, data.xi[k, 1, 2])
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
        keep_twist(space, data.omega[k, 0], omega)
        keep_twist(space, data.omega[k, 1], u)
        keep_twist(space, data.omega[k, 2], z)
        c = stumpff(dot(omega[0], omega[0]))
        turn = rotation_exp(omega[0], c)
        shift = exp_translation(omega[0], omega[1], c)
        keep_rotation(space, data.relative[k], turn)
        keep_polar(space, data.relative[k, 9:], shift)
        velocity, rate = tangent_apply(omega, u, z, c)
        # η⁺ = Ad⁻¹η + v,  η̇⁺ = Ad⁻¹η̇ − [v, Ad⁻¹η] + v̇
        carried = (apply_t(turn, eta[0]), apply_t(turn, sub(eta[1], cross(shift, eta[0]))))
        acc = (apply_t(turn, acc[0]), apply_t(turn, sub(acc[1], cross(shift, acc[0]))))
        acc = dadd(dsub(acc, dcross(velocity, carried)), rate)
        eta = dadd(carried, velocity)
        keep_twist(space, data.eta[k + 1], eta)
        keep_twist(space, data.acc[k + 1], acc)


@unit
def place(model, data):
    """Fill orientation and position of every node in the base frame from the last kinematics."""
    space = model.space
    rotation, position = rotation_of(space, data.rotation[0]), polar_of(space, data.position[0])
    for k in range(len(model.half)):
        position = add(position, apply(rotation, polar_of(space, data.relative[k, 9:])))
        rotation = mul(rotation, rotation_of(space, data.relative[k]))
        keep_rotation(space, data.rotation[k + 1], rotation)
        keep_polar(space, data.position[k + 1], position)


@algebra
def node_wrench(model, data, k):
    """Return inertial minus external wrench of node k in its own frame, as N + εM."""
    space = model.space
    mass = model.inertia[k, 0]
    eta, acc = twist_of(space, data.eta[k]), twist_of(space, data.acc[k])
    force = scale(mass, add(acc[1], cross(eta[0], eta[1])))
    j1, j2, j3 = model.inertia[k, 1], model.inertia[k, 2], model.inertia[k, 3]
    spin = (j1 * eta[0][0], j2 * eta[0][1], j3 * eta[0][2])
    moment = add((j1 * acc[0][0], j2 * acc[0][1], j3 * acc[0][2]), cross(eta[0], spin))
    if len(model.drag) > 0:
        pull, twist = drag_wrench(model, k, eta)
        force, moment = add(force, pull), add(moment, twist)
    if data.active[0] != 0:
        rotation, dead = rotation_of(space, data.rotation[k]), wrench_of(space, data.dead[k])
        force = sub(force, apply_t(rotation, dead[0]))
        moment = sub(moment, apply_t(rotation, dead[1]))
    if data.active[1] != 0:
        follower = wrench_of(space, data.follower[k])
        force, moment = sub(force, follower[0]), sub(moment, follower[1])
    return (force, moment)


@algebra
def project(model, data, r):
    """Carry wrenches from tip to base and add their projection on the coordinates to r."""
    space = model.space
    segments = len(model.half)
    wrench = node_wrench(model, data, segments)
    keep_wrench(space, data.wrench[segments], wrench)
    for k in range(segments - 1, -1, -1):
        if model.entry_ptr[k + 1] > model.entry_ptr[k]:
            omega = twist_of(space, data.omega[k, 0])
            y = cotangent_apply(omega, wrench, stumpff(dot(omega[0], omega[0])))
            half, kappa = model.half[k], model.kappa[k]
            f1 = rscale(half, y)
            f2 = f1
            if kappa != 0.0:
                x1, x2 = twist_of(space, data.xi[k, 0, 0]), twist_of(space, data.xi[k, 1, 0])
                f1 = dadd(f1, rscale(kappa, dcross(x2, y)))
                f2 = dsub(f2, rscale(kappa, dcross(x1, y)))
            w1 = (f1[1][0], f1[1][1], f1[1][2], f1[0][0], f1[0][1], f1[0][2])
            w2 = (f2[1][0], f2[1][1], f2[1][2], f2[0][0], f2[0][1], f2[0][2])
            for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
                comp = model.entry_comp[e]
                r[model.entry_col[e]] += (
                    model.entry_phi[e, 0] * w1[comp] + model.entry_phi[e, 1] * w2[comp]
                )
        turn, shift = rotation_of(space, data.relative[k]), polar_of(space, data.relative[k, 9:])
        force = apply(turn, wrench[0])
        moment = add(apply(turn, wrench[1]), cross(shift, force))
        wrench = dadd((force, moment), node_wrench(model, data, k))
        keep_wrench(space, data.wrench[k], wrench)


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
    q, v, a, r = bare(q), bare(v), bare(a), bare(r)
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
