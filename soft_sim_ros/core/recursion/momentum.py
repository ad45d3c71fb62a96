"""Momentum of bodies, and what a step must leave of it where nothing holds them.

The equation of a free joint on the base *is* the balance of momentum: what the first six equations
of r = 0 say is that the momentum map (B, section 2: Ad* of ∂T/∂η₀) changes by weight and loads
alone. A method in time keeps that balance to its order. Under weight alone it can be kept exactly,
since the change over a step is known in closed form: the joint is given the one shift and the one
twist that restore it, at the cost of three sweeps. They are of the size of the method's own error,
so its order stays.
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
def momentum(model, data, q, v, zero, first, last, out):
    """Fill out (10,) in base axes: angular momentum about the base, momentum, Σ m p, mass.

    Of nodes ``first`` … ``last`` − 1. zero: (n,) zeros. In kg·m²/s, kg·m/s, kg·m, kg.
    """
    q, v = bare(q), bare(v)
    zero, out = bare(zero), bare(out)
    strains(model, data, q, v, zero)
    kinematics(model, data)
    place(model, data)
    angular, linear, moment, total = ORIGIN, ORIGIN, ORIGIN, 0.0
    for k in range(first, last):
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
        moment = add(moment, scale(mass, p))
    store_vec(out[0:], angular)
    store_vec(out[3:], linear)
    store_vec(out[6:], moment)
    out[9] = total


@kernel
def spatial_inertia(model, data, first, last, out):
    """Fill out (6, 6): the inertia of nodes about the base, from the last ``place``.

    Of nodes ``first`` … ``last`` − 1.
    """
    for i in range(6):
        for j in range(6):
            out[i, j] = 0.0
    for k in range(first, last):
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
def held_from_outside(model, data, first, last):
    """Return whether a constraint ties nodes ``first`` … ``last`` − 1 to others."""
    node = model.closures.node
    for k in range(len(node)):
        one, two = node[k, 0], node[k, 1]
        if data.closed.on[k] > 0.0 and (first <= one < last) != (first <= two < last):
            return True
    return False


@kernel
def loaded(model, data, first, last):
    """Return whether a load acts on nodes ``first`` … ``last`` − 1, as of the step's last stage."""
    if len(data.laws) > 0 or len(data.touch.near) > 0:
        return True
    if held_from_outside(model, data, first, last):
        return True
    if len(model.fluid.node) > 0 and model.fluid.ptr[last] > model.fluid.ptr[first]:
        return True
    if data.active[0] == 0 and data.active[1] == 0:
        return False
    for k in range(first, last):
        for c in range(6):
            if data.active[0] != 0 and data.dead[k, c] != 0.0:
                return True
            if data.active[1] != 0 and data.follower[k, c] != 0.0:
                return True
    return False


@kernel
def restore_momentum(model, data, work, i, h, q, v):
    """Put free joint i where, and give it the twist with which, weight alone has brought it.

    The centre of mass of what it carries then falls as Newton says, and momentum has changed by the
    impulse of weight alone. work.momentum[i] is that of h in s ago. Nothing is done where other
    loads act.
    """
    turning, column, last = model.free[i, 0], model.free[i, 1], model.free[i, 2]
    begin = turning + 1
    if loaded(model, data, begin, last):
        return
    before, found = work.momentum[i], work.momentum[len(model.free)]
    gravity, base = load_vec(data.gravity), load_mat(data.rotation[turning])
    angular, linear, first = load_vec(before[0:]), load_vec(before[3:]), load_vec(before[6:])
    total = before[9]
    # the centre of mass falls freely, and weight acts there
    path = add(scale(h, linear), scale(0.5 * h * h * total, gravity))
    arm = add(scale(h, first), scale(0.5 * h * h, linear))
    angular = add(angular, cross(arm, gravity))
    linear = add(linear, scale(h * total, gravity))
    momentum(model, data, q, v, work.zero, begin, last, found)
    off = sub(add(first, path), load_vec(found[6:]))
    shift = apply_t(base, scale(1.0 / total, off))
    for c in range(3):
        q[column + 3 + c] += shift[c]
    momentum(model, data, q, v, work.zero, begin, last, found)
    x, inertia, pivot = np.zeros(6), np.zeros((6, 6)), np.zeros(6, dtype=np.int64)
    store_vec(x[0:], sub(angular, load_vec(found[0:])))
    store_vec(x[3:], sub(linear, load_vec(found[3:])))
    spatial_inertia(model, data, begin, last, inertia)
    if not lu_factor(inertia, pivot):
        return
    lu_solve(inertia, pivot, x)
    turn, speed = load_vec(x[0:]), load_vec(x[3:])
    at = load_vec(data.position[begin])
    vector = (q[column], q[column + 1], q[column + 2])
    rate = vector_rate(vector, apply_t(load_mat(data.rotation[begin]), turn))
    speed = apply_t(base, add(speed, cross(turn, at)))
    for c in range(3):
        v[column + c] += rate[c]
        v[column + 3 + c] += speed[c]


@unit
def uphold(model, data, work, h, q, v):
    """Keep momentum and rotation vectors, before (h = 0) and after a piece of a step of h in s.

    The momentum of what nothing holds, and rotation vectors of less than a full turn. Return
    whether coordinates were exchanged: the method's memory is then void. Scenes without either
    never compile or call this.
    """
    q, v = bare(q), bare(v)
    free = len(model.free) > 0 and len(model.mass_damping) == 0  # mass damping is an external force
    if h == 0.0:
        for i in range(len(model.free) if free else 0):
            begin, last = model.free[i, 0] + 1, model.free[i, 2]
            momentum(model, data, q, v, work.zero, begin, last, work.momentum[i])
        return False
    for i in range(len(model.free) if free else 0):
        restore_momentum(model, data, work, i, h, q, v)
    return change_charts(model, work, q, v)
