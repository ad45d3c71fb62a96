"""The recursion over the forest: motion from base to tips, wrenches from tips to base.

``inverse_dynamics`` is the residual of statics, of forward dynamics and of every implicit step. It
returns

    r = M(q) q̈ + C(q, q̇) q̇ + g(q) + K q + R q̇ − (loads and actuators),

of Dynamics of Soft Robots (1.31) with the misprints of (1.35), (1.36) settled by virtual work (k =
∫Φᵀ H Φ q, R = ∫Φᵀ Γ Φ).
"""

from soft_sim_ros.core.algebra.dual import (
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
from soft_sim_ros.core.algebra.rotation import (
    cotangent_apply,
    exp_translation,
    kept_stumpff,
    rotation_exp,
    stumpff_lanes,
    tangent_apply,
)
from soft_sim_ros.core.algebra.simd import WIDTH, each, four, keep, lanes_from, six
from soft_sim_ros.core.algebra.spaces import (
    keep_polar,
    keep_rotation,
    keep_twist,
    keep_wrench,
    polar_of,
    rotation_of,
    twist_of,
    wrench_of,
)
from soft_sim_ros.core.backend.jit import algebra, bare, call_contact, kernel, unit
from soft_sim_ros.core.terms.actuators import actuation
from soft_sim_ros.core.terms.custom import custom_wrenches
from soft_sim_ros.core.terms.fibres import fibre_forces
from soft_sim_ros.core.terms.fluid import fluid_wrenches
from soft_sim_ros.core.terms.mass_damping import damping_wrench


@kernel
def strains(model, data, q, v, a):
    """Fill data.xi: strain, rate and acceleration at both Gauss points of every segment.

    Entries of a segment are in the order of their components, so each component is summed up in
    registers. Rates of components without coordinates keep the zeros of their allocation.
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
def relative_motion(model, data):
    """Fill the relative motion over every segment from its strains; data.xi must be filled."""
    space = model.space
    count = len(model.half)
    for k in range(0, count, WIDTH):
        rows = lanes_from(k, count)
        half, kappa = each(model.half, rows, 0), each(model.kappa, rows, 0)
        x1, x2 = twist_of(space, six(data.xi, rows, 0)), twist_of(space, six(data.xi, rows, 18))
        u1, u2 = twist_of(space, six(data.xi, rows, 6)), twist_of(space, six(data.xi, rows, 24))
        z1, z2 = twist_of(space, six(data.xi, rows, 12)), twist_of(space, six(data.xi, rows, 30))
        omega = dadd(rscale(half, dadd(x1, x2)), rscale(kappa, dcross(x1, x2)))
        bracket = dadd(dcross(u1, x2), dcross(x1, u2))
        u = dadd(rscale(half, dadd(u1, u2)), rscale(kappa, bracket))
        bracket = dadd(dadd(dcross(z1, x2), dcross(x1, z2)), rscale(2.0, dcross(u1, u2)))
        z = dadd(rscale(half, dadd(z1, z2)), rscale(kappa, bracket))
        keep(data.omega, rows, 0, omega[0] + omega[1])
        keep(data.omega, rows, 6, u[0] + u[1])
        keep(data.omega, rows, 12, z[0] + z[1])
        stumpff_lanes(dot(omega[0], omega[0]), data.series, k // WIDTH)
        c = kept_stumpff(data.series, k // WIDTH)
        turn = rotation_exp(omega[0], c)
        shift = exp_translation(omega[0], omega[1], c)
        keep(data.relative, rows, 0, turn + shift)
        velocity, rate = tangent_apply(omega, u, z, c)
        keep(data.step, rows, 0, velocity[0] + velocity[1] + rate[0] + rate[1])


@algebra
def kinematics(model, data):
    """Carry twist and acceleration from base to tips; data.xi must be filled.

    data.acc is the acceleration minus gravity, which makes weight an inertial force.
    """
    relative_motion(model, data)
    space = model.space
    gravity = polar_of(space, data.gravity)
    eta = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    acc = ((0.0, 0.0, 0.0), scale(-1.0, gravity))
    keep_twist(space, data.eta[0], eta)
    keep_twist(space, data.acc[0], acc)
    forks = len(model.tree.node) > 0
    for k in range(len(model.half)):
        if forks and model.tree.node[k] != k:
            p = model.tree.node[k]
            eta, acc = twist_of(space, data.eta[p]), twist_of(space, data.acc[p])
        turn, shift = rotation_of(space, data.relative[k]), polar_of(space, data.relative[k, 9:])
        velocity, rate = twist_of(space, data.step[k]), twist_of(space, data.step[k, 6:])
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
    forks = len(model.tree.node) > 0
    for k in range(len(model.half)):
        if forks and model.tree.node[k] != k:
            p = model.tree.node[k]
            rotation = rotation_of(space, data.rotation[p])
            position = polar_of(space, data.position[p])
        position = add(position, apply(rotation, polar_of(space, data.relative[k, 9:])))
        rotation = mul(rotation, rotation_of(space, data.relative[k]))
        keep_rotation(space, data.rotation[k + 1], rotation)
        keep_polar(space, data.position[k + 1], position)


@algebra
def inertial_wrenches(model, data):
    """Fill data.wrench with the wrench of inertia and weight of every node, without loads."""
    space = model.space
    count = len(model.inertia)
    for k in range(0, count, WIDTH):
        rows = lanes_from(k, count)
        mass, j1, j2, j3 = four(model.inertia, rows, 0)
        eta, acc = twist_of(space, six(data.eta, rows, 0)), twist_of(space, six(data.acc, rows, 0))
        force = scale(mass, add(acc[1], cross(eta[0], eta[1])))
        spin = (j1 * eta[0][0], j2 * eta[0][1], j3 * eta[0][2])
        moment = add((j1 * acc[0][0], j2 * acc[0][1], j3 * acc[0][2]), cross(eta[0], spin))
        keep(data.wrench, rows, 0, moment + force)


@algebra
def node_wrench(model, data, k):
    """Return inertial minus external wrench of node k in its own frame, as N + εM."""
    space = model.space
    force, moment = wrench_of(space, data.wrench[k])
    if len(model.mass_damping) > 0:
        pull, twist = damping_wrench(model, k, twist_of(space, data.eta[k]))
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
def carry_wrenches(model, data):
    """Sum up wrenches from tips to base: data.wrench becomes what acts on a node and beyond it."""
    space = model.space
    segments = len(model.half)
    forks = len(model.tree.node) > 0
    wrench = node_wrench(model, data, segments)
    keep_wrench(space, data.wrench[segments], wrench)
    for k in range(segments - 1, -1, -1):
        turn, shift = rotation_of(space, data.relative[k]), polar_of(space, data.relative[k, 9:])
        force = apply(turn, wrench[0])
        carried = (force, add(apply(turn, wrench[1]), cross(shift, force)))
        if forks and model.tree.node[k] != k:
            # a branch begins here: what it hands on waits at the node that it leaves
            p = model.tree.node[k]
            waiting = wrench_of(space, data.wrench[p])
            keep_wrench(space, data.wrench[p], dadd(waiting, carried))
            wrench = node_wrench(model, data, k)
        else:
            wrench = dadd(carried, node_wrench(model, data, k))
        keep_wrench(space, data.wrench[k], wrench)


@algebra
def dual_forces(model, data):
    """Fill data.dual: work of the wrench beyond every segment per unit of its strains."""
    space = model.space
    count = len(model.half)
    for k in range(0, count, WIDTH):
        rows = lanes_from(k, count)
        half, kappa = each(model.half, rows, 0), each(model.kappa, rows, 0)
        omega = twist_of(space, six(data.omega, rows, 0))
        x1, x2 = twist_of(space, six(data.xi, rows, 0)), twist_of(space, six(data.xi, rows, 18))
        beyond = lanes_from(k + 1, count + 1)
        wrench = wrench_of(space, six(data.wrench, beyond, 0))
        y = cotangent_apply(omega, wrench, kept_stumpff(data.series, k // WIDTH))
        f1 = dadd(rscale(half, y), rscale(kappa, dcross(x2, y)))
        f2 = dsub(rscale(half, y), rscale(kappa, dcross(x1, y)))
        keep(data.dual, rows, 0, f1[1] + f1[0] + f2[1] + f2[0])


@algebra
def project(model, data, r):
    """Carry wrenches from tips to base and add their projection on the coordinates to r."""
    inertial_wrenches(model, data)
    if len(model.custom.node) > 0:
        custom_wrenches(model, data)
    if len(model.fluid.node) > 0:
        fluid_wrenches(model, data)
    if len(model.contact.node) > 0:
        call_contact(data.touch.call[0], model, data)
    if len(model.pairs.cell) > 0:
        call_contact(data.meet.call[0], model, data)
    carry_wrenches(model, data)
    dual_forces(model, data)
    for k in range(len(model.half)):
        for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
            comp = model.entry_comp[e]
            r[model.entry_col[e]] += (
                model.entry_phi[e, 0] * data.dual[k, comp]
                + model.entry_phi[e, 1] * data.dual[k, 6 + comp]
            )


@kernel
def internal_forces(model, q, v, r):
    """Add K q + R v to r."""
    for i in range(len(model.law_ptr) - 1):
        for e in range(model.law_ptr[i], model.law_ptr[i + 1]):
            j = model.law_col[e]
            r[i] += model.stiffness[e] * q[j] + model.damping[e] * v[j]


@kernel
def coordinate_forces(model, data, q, v, r):
    """Add what acts on the coordinates themselves: elasticity, viscosity, actuators."""
    internal_forces(model, q, v, r)
    if len(model.fibres.block) > 0:
        fibre_forces(model.fibres, data.section, q, r)
    actuation(model, data, q, r)


@unit
def inverse_dynamics(model, data, q, v, a, r):
    """Fill r with the residual of the motion (q, v, a) under the loads and efforts in data."""
    q, v, a, r = bare(q), bare(v), bare(a), bare(r)
    for i in range(len(r)):
        r[i] = 0.0
    strains(model, data, q, v, a)
    kinematics(model, data)
    placed = len(model.custom.node) > 0 or len(model.fluid.node) > 0 or len(model.contact.node) > 0
    if data.active[0] != 0 or placed:
        place(model, data)
    project(model, data, r)
    coordinate_forces(model, data, q, v, r)
