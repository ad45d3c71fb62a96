"""The exact derivative of the residual, assembled from body-sized pieces.

In the base frame a column U of the Jacobian (the twist of all that follows, per unit coordinate)
does not change along the chain after its own block. With U̇, Ü its time derivatives, I, h the
inertia and momentum of a node and Λ the wrench from there to the tip, the variation of r = Σ Jᵀ F
is (docs/theory.md)

    δr = Σ_nodes Jᵀ [I (J̈ δq + 2 J̇ δq̇ + J δq̈) + G (J̇ δq + J δq̇) + D J δq]  +  Σ_segments J⁻ᵀ
    (U δq × Λ)  +  (δU)ᵀ Λ,
    G = İ + h×,  D = turning of dead loads and weight with the section.

Sums of I, G, D over the nodes of later blocks (``tail``) are all that a block needs to know of
them.
"""

import numpy as np

from .actuators import actuator_tangent
from .columns import local_stiffness, pose_derivatives
from .dual import add, apply, cross, scale
from .fibres import fibre_tangent
from .jit import algebra, kernel, unit
from .nodes import node_matrices
from .products import (
    accumulate,
    accumulate3,
    add_entries,
    add_gram,
    add_product,
    add_product_t,
    clear,
)
from .spaces import (
    column_of,
    keep_wrench_column,
    polar_of,
    rotation_of,
    size_of,
    wrench_of,
)
from .sweep import place
from .system import rows


@kernel
def segment_columns(model, k, begin, columns, step):
    """Fill step (3, size, m) with U, U̇, Ü of segment k.

    The columns of its block, first coordinate ``begin``.
    """
    size = size_of(model.space)
    clear(step)
    for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
        j, comp = model.entry_col[e] - begin, model.entry_comp[e]
        p1, p2 = model.entry_phi[e, 0], model.entry_phi[e, 1]
        for d in range(3):
            for c in range(size):
                step[d, c, j] += p1 * columns[2 * d, c, comp] + p2 * columns[2 * d + 1, c, comp]


@algebra
def turned_wrench(space, data, k, a0, columns, out):
    """Fill out (size, m) with a0 U × Λ: the tail's wrench turned by columns of segment k."""
    rotation = rotation_of(space, data.rotation[k + 1])
    f = wrench_of(space, data.wrench[k + 1])
    fn = scale(a0, apply(rotation, f[0]))
    moved = cross(polar_of(space, data.position[k + 1]), fn)
    fm = add(scale(a0, apply(rotation, f[1])), moved)
    for j in range(out.shape[1]):
        u = column_of(space, columns, j)
        moment = add(cross(u[0], fm), cross(u[1], fn))
        keep_wrench_column(space, out, j, moment, cross(u[0], fn))


@kernel
def block_tangent(model, data, alpha, b, tail, system):
    """Fill block b of the system; tail (3, size, size): I, G, D beyond it, moved before it."""
    a0, a1, a2 = alpha
    space = model.space
    size = size_of(space)
    begin, end = model.block_col[b], model.block_col[b + 1]
    m = end - begin
    block = system.diagonal[system.offset[b] : system.offset[b + 1]].reshape((m, m))
    exerts = rows(system.exerts, size, begin, end)
    scratch = np.zeros((12, size, m))
    jac, step, feel = scratch[0:3], scratch[3:6], scratch[6:9]  # J, J̇, J̈ of the columns so far
    z, y, out = scratch[9], scratch[10], scratch[11]
    node, inner = np.zeros((3, size, size)), np.zeros((3, size, size))
    columns = np.zeros((6, size, 6))
    hessian = np.zeros((2, 2, 6, 6))
    last = model.block_seg[b + 1] - 1
    for k in range(model.block_seg[b], last + 1):
        if model.entry_ptr[k + 1] > model.entry_ptr[k]:
            pose_derivatives(model, data, k, columns)
            segment_columns(model, k, begin, columns, step)
            if a0 != 0.0:
                turned_wrench(space, data, k, a0, step[0], out)
                add_gram(jac[0], out, block, size)
                accumulate(exerts, out)
                local_stiffness(model, data, k, hessian)
                add_entries(model, k, begin, a0, hessian, block)
            accumulate3(jac, step)
        node_matrices(model, data, k + 1, node[0], node[1], node[2])
        if k == last:
            accumulate3(node, tail)
        else:
            accumulate3(inner, node)
        if m == 0:
            continue
        for c in range(size):
            for j in range(m):
                out[c, j] = 0.0
                z[c, j] = a0 * jac[1, c, j] + a1 * jac[0, c, j]
                y[c, j] = a0 * jac[2, c, j] + 2.0 * a1 * jac[1, c, j] + a2 * jac[0, c, j]
        add_product(node[0], y, out, 1.0, size)
        add_product(node[1], z, out, 1.0, size)
        add_product(node[2], jac[0], out, a0, size)
        add_gram(jac[0], out, block, size)
        accumulate(exerts, out)
        if begin > 0:
            add_product_t(node[2], jac[0], feel[0], a0, size)
            add_product_t(node[1], jac[0], feel[1], 1.0, size)
            add_product(node[0], jac[0], feel[2], 1.0, size)
    clear(tail)
    accumulate3(tail, inner)
    accumulate3(tail, node)
    motion = rows(system.motion, 3 * size, begin, end)
    feels = rows(system.feels, 3 * size, begin, end)
    for c in range(size):
        for j in range(m):
            motion[c, j] = jac[0, c, j]
            motion[size + c, j] = z[c, j]
            motion[2 * size + c, j] = y[c, j]
            for d in range(3):
                feels[d * size + c, j] = feel[d, c, j]


@kernel
def internal_tangent(model, alpha, system):
    """Add α₀ K + α₁ R."""
    a0, a1, _ = alpha
    for b in range(len(model.block_col) - 1):
        begin, end = model.block_col[b], model.block_col[b + 1]
        for i in range(begin, end):
            at = system.offset[b] + (i - begin) * (end - begin) - begin
            for e in range(model.law_ptr[i], model.law_ptr[i + 1]):
                term = a0 * model.stiffness[e] + a1 * model.damping[e]
                system.diagonal[at + model.law_col[e]] += term


@unit
def tangent(model, data, alpha, system):
    """Fill system with α₀ ∂r/∂q + α₁ ∂r/∂q̇ + α₂ ∂r/∂q̈ at the last residual's state.

    Exact for the discrete model, actuators and loads included.
    """
    for i in range(len(system.diagonal)):
        system.diagonal[i] = 0.0
    for i in range(len(system.exerts)):
        system.exerts[i] = 0.0
    place(model, data)
    size = size_of(model.space)
    tail = np.zeros((3, size, size))
    for b in range(len(model.block_col) - 2, -1, -1):
        block_tangent(model, data, alpha, b, tail, system)
    internal_tangent(model, alpha, system)
    actuator_tangent(model, data, alpha, system)
    if alpha[0] != 0.0:
        fibre_tangent(model, data.section, alpha[0], system)
