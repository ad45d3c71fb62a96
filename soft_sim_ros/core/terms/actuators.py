"""Actuators as ports: their generalised forces, the derivative of these, positions and rates.

The kernels read only data.xi, the strains at the Gauss points. A port position is gain · q (a
moment, a joint torque), or a multiple of the lengthening of a path (−1 for a tendon, the area for a
chamber).
"""

import numpy as np

from soft_sim_ros.core.algebra.products import add_entries
from soft_sim_ros.core.algebra.simd import padded
from soft_sim_ros.core.backend.jit import bare, kernel, unit

from .friction import TENSION, capstan, capstan_tangent
from .tendons import (
    add_length,
    add_length_rate,
    length_hessian,
    pull,
    stretch_energy,
    stretch_loss,
    tendon_motion,
)


@kernel
def actuation(model, data, q, r):
    """Subtract the generalised forces of all actuators from r.

    A tension T does the work −T δℓ of shortening the path ℓ = ∫ |Γ + K × d + d'| ds.
    """
    for i in range(len(model.port_ptr) - 1):
        for e in range(model.port_ptr[i], model.port_ptr[i + 1]):
            r[model.port_col[e]] -= model.port_gain[e] * data.effort[i]
    if len(model.tendon_seg) > 0:
        tendon_forces(model, data, r)


@unit
def tendon_forces(model, data, r):
    """Subtract the generalised forces of all tendons and chambers from r."""
    r = bare(r)
    for i in range(len(model.tendon_ptr) - 1):
        if model.tendon_ptr[i] == model.tendon_ptr[i + 1]:
            continue
        tension = pull(model, data, i)[0]
        if tension == 0.0:
            continue
        if model.friction[i, 0] != 0.0:
            capstan(model, data, i, tension)
        for p in range(model.tendon_ptr[i], model.tendon_ptr[i + 1]):
            for g in range(2):
                if model.friction[i, 0] != 0.0:
                    tension = data.station[p, g, TENSION]
                add_length(model, data, p, g, tension, r)


@kernel
def actuator_tangent(model, data, alpha, system):
    """Add α₀ ∂/∂q + α₁ ∂/∂q̇ of ``actuation`` to the system."""
    for c in range(model.couple_ptr[len(model.couple_ptr) - 1]):
        for j in range(system.left.shape[1]):
            system.left[c, j] = 0.0
            system.right[c, j] = 0.0
    if len(model.tendon_seg) > 0 and (alpha[0] != 0.0 or alpha[1] != 0.0):
        tendon_tangents(model, data, alpha, system)


@unit
def tendon_tangents(model, data, alpha, system):
    """Add the derivatives of the generalised forces of all tendons and chambers."""
    for i in range(len(model.tendon_ptr) - 1):
        if model.tendon_ptr[i] < model.tendon_ptr[i + 1]:
            tendon_tangent(model, data, i, alpha, system)


@kernel
def tendon_tangent(model, data, i, alpha, system):
    """Add T ∂²ℓ/∂q² of actuator i, and the change of its tension with the shape and its rate."""
    tension, stiffness, damping = pull(model, data, i)
    if tension == 0.0:
        return
    rubs = model.friction[i, 0] != 0.0
    column = model.couple_ptr[i]
    hessian = np.zeros((12, 12))
    if rubs:
        capstan(model, data, i, tension)
    for p in range(model.tendon_ptr[i], model.tendon_ptr[i + 1]):
        k = model.tendon_seg[p]
        for g in range(2):
            here = data.station[p, g, TENSION] if rubs else tension
            length_hessian(model, data, p, g, here, hessian)
            if stiffness != 0.0:
                add_length(model, data, p, g, here / tension, system.left[column])
                add_length(model, data, p, g, alpha[0] * stiffness, system.right[column])
                add_length_rate(model, data, p, g, alpha, damping, system.right[column])
        if alpha[0] != 0.0:
            b = model.seg_block[k]
            begin, m = model.block_col[b], model.block_col[b + 1] - model.block_col[b]
            added = np.zeros((m, padded(m)))
            add_entries(model, k, begin, alpha[0], hessian, np.zeros((12, padded(m))), added)
            block = system.diagonal[system.offset[b] : system.offset[b + 1]].reshape((m, m))
            for row in range(m):
                for col in range(m):
                    block[row, col] += added[row, col]
    if rubs:
        if model.length_control[i, 0] != 0.0:
            column += 1
        capstan_tangent(model, data, i, alpha, column, system)


@kernel
def actuator_loss(model, data):
    """Return the power in W that tendons turn into heat, at the last sweep."""
    if model.couple_ptr[-1] == 0 and len(data.station) == 0:
        return 0.0  # neither a commanded length nor friction
    return tendon_loss(model, data)


@unit
def tendon_loss(model, data):
    """Return ``actuator_loss``, or 0 for models whose actuators have no loss."""
    total = 0.0
    for i in range(len(model.tendon_ptr) - 1):
        if model.length_control[i, 0] != 0.0:
            total += stretch_loss(model, data, i)
        if model.friction[i, 0] != 0.0:
            total += capstan(model, data, i, pull(model, data, i)[0])
    return total


@kernel
def tendon_energy(model, data):
    """Return the energy in J stored in tendons whose length is commanded, at the last sweep."""
    total = 0.0
    for i in range(len(model.tendon_ptr) - 1):
        total += stretch_energy(model, data, i)
    return total


@kernel
def port_motion(model, data, q, v, position, velocity, effort):
    """Fill position, velocity and effort (A,) of all ports; data.xi must hold strains and rates.

    The effort of a tendon is its tension, of a chamber its pressure.
    """
    for i in range(len(model.port_ptr) - 1):
        x, rate = 0.0, 0.0
        for e in range(model.port_ptr[i], model.port_ptr[i + 1]):
            x += model.port_gain[e] * q[model.port_col[e]]
            rate += model.port_gain[e] * v[model.port_col[e]]
        effort[i] = data.effort[i]
        if model.tendon_gain[i] != 0.0:
            length, speed = tendon_motion(model, data, i)
            x += model.tendon_gain[i] * (length - model.tendon_rest[i])
            rate += model.tendon_gain[i] * speed
        if model.length_control[i, 0] != 0.0:
            effort[i] = pull(model, data, i)[0]
        position[i], velocity[i] = x, rate
