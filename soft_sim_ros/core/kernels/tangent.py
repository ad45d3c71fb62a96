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
from .dual import add, apply, cross, load_mat, load_vec, load_wrench, scale
from .fibres import fibre_tangent
from .jit import bare, kernel, unit
from .nodes import node_matrices
from .products import (
    accumulate,
    accumulate3,
    add_entries,
    clear,
    gram_add,
    product,
    product_add,
    product_t_add,
)
from .sweep import place
from .system import rows


@kernel
def segment_columns(model, k, begin, columns, step):
    """Fill step (3, 6, m) with U, U̇, Ü of segment k.

    The columns of its block, first coordinate ``begin``.
    """
    clear(step)
    for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
        j, comp = model.entry_col[e] - begin, model.entry_comp[e]
        p1, p2 = model.entry_phi[e, 0], model.entry_phi[e, 1]
        for d in range(3):
            for c in range(6):
                step[d, c, j] += p1 * columns[2 * d, c, comp] + p2 * columns[2 * d + 1, c, comp]


@kernel
def turned_wrench(data, k, a0, columns, out):
    """Fill out (6, m) with a0 U × Λ: the wrench of the tail turned by the columns of segment k."""
    rotation, p = load_mat(data.rotation[k + 1]), load_vec(data.position[k + 1])
    f = load_wrench(data.wrench[k + 1])
    fn = scale(a0, apply(rotation, f[0]))
    fm = add(scale(a0, apply(rotation, f[1])), cross(p, fn))
    for j in range(out.shape[1]):
        w = (columns[0, j], columns[1, j], columns[2, j])
        v = (columns[3, j], columns[4, j], columns[5, j])
        moment = add(cross(w, fm), cross(v, fn))
        push = cross(w, fn)
        for c in range(3):
            out[c, j] = moment[c]
            out[c + 3, j] = push[c]


@kernel
def block_tangent(model, data, alpha, b, tail, system):
    """Fill block b of the system; tail (3, 6, 6) holds I, G, D beyond it and is moved before it."""
    a0, a1, a2 = alpha
    begin, end = model.block_col[b], model.block_col[b + 1]
    m = end - begin
    block = system.diagonal[system.offset[b] : system.offset[b + 1]].reshape((m, m))
    exerts = rows(system.exerts, 6, begin, end)
    scratch = np.zeros((12, 6, m))
    jac, step, feel = scratch[0:3], scratch[3:6], scratch[6:9]  # J, J̇, J̈ of the columns so far
    z, y, out = scratch[9], scratch[10], scratch[11]
    node, inner = np.zeros((3, 6, 6)), np.zeros((3, 6, 6))
    columns = np.zeros((6, 6, 6))
    hessian = np.zeros((2, 2, 6, 6))
    last = model.block_seg[b + 1] - 1
    for k in range(model.block_seg[b], last + 1):
        if model.entry_ptr[k + 1] > model.entry_ptr[k]:
            pose_derivatives(model, data, k, columns)
            segment_columns(model, k, begin, columns, step)
            if a0 != 0.0:
                turned_wrench(data, k, a0, step[0], out)
                gram_add(jac[0], out, block)
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
        for c in range(6):
            for j in range(m):
                z[c, j] = a0 * jac[1, c, j] + a1 * jac[0, c, j]
                y[c, j] = a0 * jac[2, c, j] + 2.0 * a1 * jac[1, c, j] + a2 * jac[0, c, j]
        product(node[0], y, out)
        product_add(node[1], z, out, 1.0)
        product_add(node[2], jac[0], out, a0)
        gram_add(jac[0], out, block)
        accumulate(exerts, out)
        if begin > 0:
            product_t_add(node[2], jac[0], feel[0], a0)
            product_t_add(node[1], jac[0], feel[1], 1.0)
            product_add(node[0], jac[0], feel[2], 1.0)
    clear(tail)
    accumulate3(tail, inner)
    accumulate3(tail, node)
    motion, feels = rows(system.motion, 18, begin, end), rows(system.feels, 18, begin, end)
    for c in range(6):
        for j in range(m):
            motion[c, j], motion[6 + c, j], motion[12 + c, j] = jac[0, c, j], z[c, j], y[c, j]
            for d in range(3):
                feels[6 * d + c, j] = feel[d, c, j]


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
    model, data, system = bare(model), bare(data), bare(system)
    for i in range(len(system.diagonal)):
        system.diagonal[i] = 0.0
    for i in range(len(system.exerts)):
        system.exerts[i] = 0.0
    place(model, data)
    tail = np.zeros((3, 6, 6))
    for b in range(len(model.block_col) - 2, -1, -1):
        block_tangent(model, data, alpha, b, tail, system)
    internal_tangent(model, alpha, system)
    actuator_tangent(model, data, alpha, system)
    if alpha[0] != 0.0:
        fibre_tangent(model, data.section, alpha[0], system)
