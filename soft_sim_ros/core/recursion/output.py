"""Outputs of a state: energies, actuator ports, frames along the arm."""

import math

from soft_sim_ros.core.algebra.dual import (
    add,
    apply,
    dadd,
    dcross,
    dot,
    load_mat,
    load_twist,
    load_vec,
    mul,
    rscale,
    store_twist,
)
from soft_sim_ros.core.algebra.rotation import exp_translation, rotation_exp, stumpff
from soft_sim_ros.core.backend.jit import bare, call_bristles, call_contact_energy, kernel, unit
from soft_sim_ros.core.terms.actuators import port_motion, tendon_energy
from soft_sim_ros.core.terms.fibres import fibre_energy
from soft_sim_ros.core.terms.fluid import fluid_energies
from soft_sim_ros.core.terms.maxwell import branch_energy

from .rnea import kinematics, place, strains


@unit
def energies(model, data, q, v, zero):
    """Return kinetic, elastic and gravity energy in J.

    The base frame has gravity energy 0; buoyancy belongs to it, and the fluid that moves along to
    the kinetic energy. zero: (n,) zeros.
    """
    q, v, zero = bare(q), bare(v), bare(zero)
    strains(model, data, q, v, zero)
    kinematics(model, data)
    place(model, data)
    kinetic, weight, elastic = 0.0, 0.0, 0.0
    for k in range(model.inertia.shape[0]):
        mass = model.inertia[k, 0]
        for c in range(3):
            kinetic += 0.5 * model.inertia[k, 1 + c] * data.eta[k, c] ** 2
            kinetic += 0.5 * mass * data.eta[k, 3 + c] ** 2
            weight -= mass * data.gravity[c] * data.position[k, c]
    if len(model.fluid.node) > 0:
        along, lifted = fluid_energies(model, data)
        kinetic, weight = kinetic + along, weight + lifted
    for i in range(len(model.law_ptr) - 1):
        for e in range(model.law_ptr[i], model.law_ptr[i + 1]):
            elastic += 0.5 * q[i] * model.stiffness[e] * q[model.law_col[e]]
    elastic += fibre_energy(model.fibres, data.section, q) + branch_energy(model, q)
    elastic += tendon_energy(model, data)
    if len(model.contact.node) > 0:
        elastic += call_contact_energy(data.touch.call[2], model, data)
        elastic += call_bristles(data.touch.call[3], model, data, data.touch.bristle[0])
    if len(model.pairs.cell) > 0:
        elastic += call_contact_energy(data.meet.call[2], model, data)
    return kinetic, elastic, weight


@unit
def ports(model, data, q, v, zero, position, velocity, effort):
    """Fill position, velocity and effort (A,) of all actuator ports.

    Effort · velocity is power into the arm.
    """
    q, v = bare(q), bare(v)
    zero, position, velocity, effort = bare(zero), bare(position), bare(velocity), bare(effort)
    strains(model, data, q, v, zero)
    port_motion(model, data, q, v, position, velocity, effort)


@kernel
def quaternion(m):
    """Return x, y, z, w of a rotation matrix, by its largest component."""
    trace = m[0] + m[4] + m[8]
    if trace >= m[0] and trace >= m[4] and trace >= m[8]:
        w = 1.0 + trace
        x, y, z = m[7] - m[5], m[2] - m[6], m[3] - m[1]
    elif m[0] >= m[4] and m[0] >= m[8]:
        x = 1.0 + m[0] - m[4] - m[8]
        y, z, w = m[1] + m[3], m[2] + m[6], m[7] - m[5]
    elif m[4] >= m[8]:
        y = 1.0 - m[0] + m[4] - m[8]
        x, z, w = m[1] + m[3], m[5] + m[7], m[2] - m[6]
    else:
        z = 1.0 - m[0] - m[4] + m[8]
        x, y, w = m[2] + m[6], m[5] + m[7], m[3] - m[1]
    s = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    return s * x, s * y, s * z, s * w


@unit
def sample_poses(model, data, samples, base, q, zero, poses):
    """Fill poses (P, 7) x y z qx qy qz qw in the world; base (12,) = rotation by rows, position.

    The quaternions already in ``poses`` decide the sign of the new ones, so they are continuous in
    time.
    """
    base = bare(base)
    q, zero, poses = bare(q), bare(zero), bare(poses)
    strains(model, data, q, zero, zero)
    kinematics(model, data)
    place(model, data)
    row = (base[0], base[1], base[2], base[3], base[4], base[5], base[6], base[7], base[8])
    origin = (base[9], base[10], base[11])
    xi = data.xi[0]  # used as scratch: every user of data.xi fills it first
    for p in range(len(samples.node)):
        for i in range(2):
            for c in range(6):
                xi[i, 0, c] = samples.xi0[p, i, c]
        for e in range(samples.entry_ptr[p], samples.entry_ptr[p + 1]):
            for i in range(2):
                xi[i, 0, samples.entry_comp[e]] += samples.entry_phi[e, i] * q[samples.entry_col[e]]
        x1, x2 = load_twist(xi[0, 0]), load_twist(xi[1, 0])
        omega = rscale(samples.half[p], dadd(x1, x2))
        omega = dadd(omega, rscale(samples.kappa[p], dcross(x1, x2)))
        c = stumpff(dot(omega[0], omega[0]))
        k = samples.node[p]
        rotation = mul(row, load_mat(data.rotation[k]))
        shift = apply(rotation, exp_translation(omega[0], omega[1], c))
        spot = add(add(origin, apply(row, load_vec(data.position[k]))), shift)
        x, y, z, w = quaternion(mul(rotation, rotation_exp(omega[0], c)))
        old = poses[p, 3] * x + poses[p, 4] * y + poses[p, 5] * z + poses[p, 6] * w
        if old < 0.0:
            x, y, z, w = -x, -y, -z, -w
        store_twist(poses[p], (spot, (x, y, z)))
        poses[p, 6] = w
