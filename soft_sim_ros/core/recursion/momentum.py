"""Momentum of the whole chain, and what a step must leave of it where the base is free.

The equation of a free base *is* the balance of momentum: what the first six equations of r = 0 say
is that the momentum map (B, section 2: Ad* of ∂T/∂η₀) changes by weight and loads alone. A method
in time keeps that balance to its order. Under weight alone it can be kept exactly, since the change
over a step is known in closed form: the base is given the one shift and the one twist that restore
it, at the cost of three sweeps. They are of the size of the method's own error, so its order stays.
"""

import numpy as np

from soft_sim_ros.core.algebra.charts import change_charts, vector_rate
from soft_sim_ros.core.algebra.dual import (
    add,
    apply,
    apply_t,
    cross,
    dot,
    load_mat,
    load_twist,
    load_vec,
    scale,
    store_vec,
    sub,
)
from soft_sim_ros.core.algebra.linalg import lu_factor, lu_solve
from soft_sim_ros.core.backend.jit import bare, kernel, unit

from .rnea import kinematics, place, strains

ORIGIN = (0.0, 0.0, 0.0)


@unit
def momentum(model, data, q, v, zero, out):
    """Fill out (10,) in base axes: angular momentum about the base, momentum, Σ m p, mass.

    zero: (n,) zeros. In kg·m²/s, kg·m/s, kg·m, kg.
    """
    q, v = bare(q), bare(v)
    zero, out = bare(zero), bare(out)
    strains(model, data, q, v, zero)
    kinematics(model, data)
    place(model, data)
    angular, linear, first, total = ORIGIN, ORIGIN, ORIGIN, 0.0
    for k in range(model.inertia.shape[0]):
        mass = model.inertia[k, 0]
        rotation, p = load_mat(data.rotation[k]), load_vec(data.position[k])
        eta = load_twist(data.eta[k])
        push = scale(mass, apply(rotation, eta[1]))
        spin = (
            model.inertia[k, 1] * eta[0][0],
            model.inertia[k, 2] * eta[0][1],
            model.inertia[k, 3] * eta[0][2],
        )
        angular = add(angular, add(apply(rotation, spin), cross(p, push)))
        linear = add(linear, push)
        total += mass
        first = add(first, scale(mass, p))
    store_vec(out[0:], angular)
    store_vec(out[3:], linear)
    store_vec(out[6:], first)
    out[9] = total


@kernel
def spatial_inertia(model, data, out):
    """Fill out (6, 6), the inertia of the whole chain about the base, from the last ``place``."""
    for i in range(6):
        for j in range(6):
            out[i, j] = 0.0
    for k in range(model.inertia.shape[0]):
        mass = model.inertia[k, 0]
        r, p = load_mat(data.rotation[k]), load_vec(data.position[k])
        square = dot(p, p)
        for i in range(3):
            out[3 + i, 3 + i] += mass
            out[i, i] += mass * square
            for j in range(3):
                turned = 0.0
                for c in range(3):
                    turned += r[3 * i + c] * model.inertia[k, 1 + c] * r[3 * j + c]
                out[i, j] += turned - mass * p[i] * p[j]
        # m p× couples turning about the base with shifting
        for i, j, c, sign in ((0, 1, 2, -1.0), (0, 2, 1, 1.0), (1, 2, 0, -1.0)):
            out[i, 3 + j] += sign * mass * p[c]
            out[j, 3 + i] -= sign * mass * p[c]
            out[3 + j, i] += sign * mass * p[c]
            out[3 + i, j] -= sign * mass * p[c]


@kernel
def restore_momentum(model, data, work, h, q, v):
    """Put the free base where, and give it the twist with which, weight alone has brought it.

    Its centre of mass then falls as Newton says, and momentum has changed by its impulse alone.
    work.momentum[0] is that of h in s ago. Nothing is done where other loads act: data.active is
    that of the step's last stage.
    """
    if data.active[0] != 0 or data.active[1] != 0:
        return
    before, found = work.momentum[0], work.momentum[1]
    gravity, base = load_vec(data.gravity), load_mat(data.rotation[model.free[0]])
    angular, linear, first = load_vec(before[0:]), load_vec(before[3:]), load_vec(before[6:])
    total = before[9]
    # the centre of mass falls freely, and weight acts there
    path = add(scale(h, linear), scale(0.5 * h * h * total, gravity))
    arm = add(scale(h, first), scale(0.5 * h * h, linear))
    angular = add(angular, cross(arm, gravity))
    linear = add(linear, scale(h * total, gravity))
    momentum(model, data, q, v, work.zero, found)
    off = sub(add(first, path), load_vec(found[6:]))
    shift = apply_t(base, scale(1.0 / total, off))
    for i in range(3):
        q[3 + i] += shift[i]
    momentum(model, data, q, v, work.zero, found)
    x, inertia, pivot = np.zeros(6), np.zeros((6, 6)), np.zeros(6, dtype=np.int64)
    store_vec(x[0:], sub(angular, load_vec(found[0:])))
    store_vec(x[3:], sub(linear, load_vec(found[3:])))
    spatial_inertia(model, data, inertia)
    if not lu_factor(inertia, pivot):
        return
    lu_solve(inertia, pivot, x)
    turn, speed = load_vec(x[0:]), load_vec(x[3:])
    after = model.free[0] + 1
    at = load_vec(data.position[after])
    rate = vector_rate((q[0], q[1], q[2]), apply_t(load_mat(data.rotation[after]), turn))
    speed = apply_t(base, add(speed, cross(turn, at)))
    for i in range(3):
        v[i] += rate[i]
        v[3 + i] += speed[i]


@unit
def uphold(model, data, work, h, q, v):
    """Keep momentum and rotation vectors, before (h = 0) and after a piece of a step of h in s.

    The momentum of a free base, and rotation vectors of less than a full turn. Return whether
    coordinates were exchanged: the method's memory is then void. Scenes without either never
    compile or call this.
    """
    q, v = bare(q), bare(v)
    free = len(model.free) > 0 and len(model.mass_damping) == 0  # mass damping is an external force
    if h == 0.0:
        if free:
            momentum(model, data, q, v, work.zero, work.momentum[0])
        return False
    if free:
        restore_momentum(model, data, work, h, q, v)
    return change_charts(model, work, q, v)
