"""Actuators as ports: their generalised forces, the derivative of these, positions and rates.

The kernels see data.xi, the strains at the Gauss points, and nothing else of the motion.
"""

import numpy as np

from .dual import add, cross, dot, load_twist, load_vec, scale
from .jit import kernel
from .products import add_entries


@kernel
def tendon_direction(path, xi):
    """Return the tangent t = Γ + K × d + d' of a tendon, |t| and the offset d."""
    d, slope = load_vec(path[0]), load_vec(path[1])
    strain = load_twist(xi)
    t = add(add(strain[1], cross(strain[0], d)), slope)
    return t, dot(t, t) ** 0.5, d


@kernel
def actuation(model, data, q, r):
    """Subtract the generalised forces of all actuators from r.

    A tension T does the work −T δℓ of shortening the path ℓ = ∫ |Γ + K × d + d'| ds.
    """
    for i in range(len(model.port_ptr) - 1):
        effort = data.effort[i]
        for e in range(model.port_ptr[i], model.port_ptr[i + 1]):
            r[model.port_col[e]] -= model.port_gain[e] * effort
        length = 0.0
        for p in range(model.tendon_ptr[i], model.tendon_ptr[i + 1]):
            k = model.tendon_seg[p]
            for g in range(2):
                t, norm, d = tendon_direction(model.tendon_path[p, g], data.xi[k, g, 0])
                length += model.half[k] * norm
                n = scale(1.0 / norm, t)
                m = cross(d, n)
                dual = (m[0], m[1], m[2], n[0], n[1], n[2])
                for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
                    r[model.entry_col[e]] += (
                        effort * model.half[k] * model.entry_phi[e, g] * dual[model.entry_comp[e]]
                    )
        data.tendon[i] = length


@kernel
def actuator_tangent(model, data, alpha, system):
    """Add α₀ T ∂²ℓ/∂q² of every tendon under tension."""
    a0 = alpha[0]
    if a0 == 0.0:
        return
    hessian = np.zeros((2, 2, 6, 6))
    slope = np.zeros((3, 6))
    for i in range(len(model.tendon_ptr) - 1):
        effort = data.effort[i]
        if effort == 0.0:
            continue
        for p in range(model.tendon_ptr[i], model.tendon_ptr[i + 1]):
            k = model.tendon_seg[p]
            for g in range(2):
                t, norm, d = tendon_direction(model.tendon_path[p, g], data.xi[k, g, 0])
                n = scale(1.0 / norm, t)
                # ∂t/∂ξ = [−d× , 1]; ∂²|t| = (1 − n nᵀ)/|t|
                for a in range(6):
                    slope[0, a] = slope[1, a] = slope[2, a] = 0.0
                slope[0, 1], slope[0, 2], slope[0, 3] = d[2], -d[1], 1.0
                slope[1, 0], slope[1, 2], slope[1, 4] = -d[2], d[0], 1.0
                slope[2, 0], slope[2, 1], slope[2, 5] = d[1], -d[0], 1.0
                for a in range(6):
                    sa = (slope[0, a], slope[1, a], slope[2, a])
                    na = dot(n, sa)
                    for b in range(6):
                        sb = (slope[0, b], slope[1, b], slope[2, b])
                        hessian[g, g, a, b] = model.half[k] / norm * (dot(sa, sb) - na * dot(n, sb))
            b = model.seg_block[k]
            begin, m = model.block_col[b], model.block_col[b + 1] - model.block_col[b]
            block = system.diagonal[system.offset[b] : system.offset[b + 1]].reshape((m, m))
            add_entries(model, k, begin, a0 * effort, hessian, block)


@kernel
def port_motion(model, data, q, v, position, velocity):
    """Fill position and velocity (A,) of all ports; data.xi must hold strains and rates."""
    for i in range(len(model.port_ptr) - 1):
        x, rate = model.tendon_rest[i], 0.0
        for e in range(model.port_ptr[i], model.port_ptr[i + 1]):
            x += model.port_gain[e] * q[model.port_col[e]]
            rate += model.port_gain[e] * v[model.port_col[e]]
        for p in range(model.tendon_ptr[i], model.tendon_ptr[i + 1]):
            k = model.tendon_seg[p]
            for g in range(2):
                t, norm, d = tendon_direction(model.tendon_path[p, g], data.xi[k, g, 0])
                x -= model.half[k] * norm
                u = load_twist(data.xi[k, g, 1])
                turned = (
                    u[0][1] * d[2] - u[0][2] * d[1],
                    u[0][2] * d[0] - u[0][0] * d[2],
                    u[0][0] * d[1] - u[0][1] * d[0],
                )
                rate -= model.half[k] / norm * dot(t, add(u[1], turned))
        position[i], velocity[i] = x, rate
