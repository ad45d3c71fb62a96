"""The exact derivative of the residual, assembled from body-sized pieces.

In the base frame a column U of the Jacobian (the twist of all later nodes per unit coordinate) is
constant along the chain after its own block. With U̇, Ü its time derivatives, I, h the
inertia and momentum of a node and Λ the wrench from there to the tip, the variation of r = Σ Jᵀ F
is (docs/theory.md)

    δr = Σ_nodes Jᵀ [I (J̈ δq + 2 J̇ δq̇ + J δq̈) + G (J̇ δq + J δq̇) + D J δq]  +  Σ_segments J⁻ᵀ
    (U δq × Λ)  +  (δU)ᵀ Λ,
    G = İ + h×,  D = turning of dead loads and weight with the section.

Sums of I, G, D over the nodes of the blocks beyond (``tail``) are all that a block needs to know
of them. Where branches leave the end of a block, their sums wait for it.
"""

import numpy as np

from soft_sim_ros.core.algebra.dual import add, apply, cross, scale
from soft_sim_ros.core.algebra.maps import column_of, keep_wrench_column
from soft_sim_ros.core.algebra.products import (
    accumulate,
    add_entries,
    add_product,
    add_product_t,
    clear,
)
from soft_sim_ros.core.algebra.simd import WIDTH, fused, keep_one, lane, lanes_from, one
from soft_sim_ros.core.algebra.spaces import polar_of, rotation_of, size_of, wrench_of
from soft_sim_ros.core.backend.jit import algebra, call_contact_matrices, call_tangent, kernel, unit
from soft_sim_ros.core.terms.actuators import actuator_tangent
from soft_sim_ros.core.terms.custom import custom_matrices
from soft_sim_ros.core.terms.fibres import fibre_tangent
from soft_sim_ros.core.terms.fluid import fluid_matrices

from .columns import local_stiffness, pose_derivatives, segment_stumpff
from .elimination import rows
from .nodes import node_matrices
from .rnea import place


@kernel
def segment_columns(model, k, begin, columns, step):
    """Fill step (20, padded m) with U, U̇, Ü of segment k, of its block from column ``begin`` on."""
    count = 3 * size_of(model.space)
    clear(step, count)
    for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
        j, comp = model.entry_col[e] - begin, model.entry_comp[e]
        p1, p2 = model.entry_phi[e, 0], model.entry_phi[e, 1]
        for c in range(0, count, WIDTH):
            added = fused(p1, one(columns, comp, c), p2 * one(columns, 6 + comp, c))
            for i in range(WIDTH):
                step[c + i, j] += lane(added, i)


@algebra
def turned_wrench(space, data, k, a0, columns, out):
    """Fill out (size, m) with a0 U × Λ: change of the tail's wrench by turning with segment k."""
    rotation = rotation_of(space, data.rotation[k + 1])
    f = wrench_of(space, data.wrench[k + 1])
    fn = scale(a0, apply(rotation, f[0]))
    moved = cross(polar_of(space, data.position[k + 1]), fn)
    fm = add(scale(a0, apply(rotation, f[1])), moved)
    for j in range(0, out.shape[1], WIDTH):
        u = column_of(space, columns, j)
        moment = add(cross(u[0], fm), cross(u[1], fn))
        keep_wrench_column(space, out, j, moment, cross(u[0], fn))


@kernel
def mix(alpha, jac, z, y, size):
    """Fill z, y (size, m) with the first and second variations of J, J̇, J̈ (3 size, m)."""
    a0, a1, a2 = alpha
    for c in range(size):
        for j in range(0, z.shape[1], WIDTH):
            u, u1, u2 = one(jac, c, j), one(jac, size + c, j), one(jac, 2 * size + c, j)
            keep_one(z, c, j, a0 * u1 + a1 * u)
            keep_one(y, c, j, a0 * u2 + 2.0 * a1 * u1 + a2 * u)


@kernel
def four_segments(model, data, alpha, k, count, pieces):
    """Fill the pieces of segments from k on, of ``count``, at most four."""
    columns, hessian, nodes, series = pieces
    rows, beyond = lanes_from(k, count), lanes_from(k + 1, count + 1)
    here = lanes_from(0, count - k)
    node_matrices(model, data, beyond, nodes, here)
    if len(model.custom.node) > 0:
        for i in range(min(WIDTH, count - k)):
            if model.custom.ptr[k + i + 2] > model.custom.ptr[k + i + 1]:
                custom_matrices(model, data, k + i + 1, nodes[i])
    if len(model.fluid.node) > 0:
        for i in range(min(WIDTH, count - k)):
            if model.fluid.ptr[k + i + 2] > model.fluid.ptr[k + i + 1]:
                fluid_matrices(model, data, k + i + 1, nodes[i])
    if len(model.contact.node) > 0:
        for i in range(min(WIDTH, count - k)):
            if model.contact.ptr[k + i + 2] > model.contact.ptr[k + i + 1]:
                call_contact_matrices(data.touch.call[1], model, data, k + i + 1, nodes[i])
    if model.entry_ptr[min(k + WIDTH, count)] > model.entry_ptr[k]:
        c = segment_stumpff(model, data, rows, series)
        pose_derivatives(model, data, rows, beyond, c, columns, here)
        if alpha[0] != 0.0:
            local_stiffness(model, data, rows, beyond, c, hessian, here)


@kernel
def keep_inner(system, node, alpha, jac, size):
    """Keep J of a node, and the variation of its twist, for contact between bodies."""
    inner = system.inner[node]
    for c in range(size):
        for j in range(jac.shape[1]):
            inner[c, j] = jac[c, j]
            inner[size + c, j] = alpha[0] * jac[size + c, j] + alpha[1] * jac[c, j]


@kernel
def block_tangent(model, data, alpha, b, tail, pieces, system):
    """Fill block b of the system; tail (3 size, 8): I, G, D beyond it, moved before it.

    pieces: scratch for what is computed of four segments at once.
    """
    a0 = alpha[0]
    columns, hessian, nodes, _ = pieces
    space = model.space
    size = size_of(space)
    begin, end = model.block_col[b], model.block_col[b + 1]
    m = end - begin
    # wrench on a node by the motion of the columns so far, and wrench that they exert
    feel, exerts = rows(system, system.feels, 3 * size, b), rows(system, system.exerts, size, b)
    width = feel.shape[1]
    # J, J̇, J̈ of the columns so far, and what a segment adds to them
    jac, step = np.zeros((20, width)), np.zeros((20, width))
    z, y, out = np.zeros((size, width)), np.zeros((size, width)), np.zeros((size, width))
    turned, block = np.zeros((12, width)), np.zeros((m, width))
    clear(feel, 3 * size)
    clear(exerts, size)
    inner = np.zeros((3 * size, 8))
    start, last = model.block_seg[b], model.block_seg[b + 1] - 1
    for k in range(start, last + 1):
        i = (k - start) % WIDTH
        if i == 0:
            four_segments(model, data, alpha, k, last + 1, pieces)
        if model.entry_ptr[k + 1] > model.entry_ptr[k]:
            segment_columns(model, k, begin, columns[i], step)
            if a0 != 0.0:
                turned_wrench(space, data, k, a0, step, out)
                add_product_t(space, jac, 0, 1.0, out, block, 0, m)
                accumulate(exerts, out, size)
                add_entries(model, k, begin, a0, hessian[i], turned, block)
            accumulate(jac, step, 3 * size)
        if len(system.inner) > 0:
            keep_inner(system, k + 1, alpha, jac, size)
        # the last node of the block moves with all later ones
        accumulate(tail if k == last else inner, nodes[i], 3 * size)
        if m == 0:
            continue
        node = tail if k == last else nodes[i]
        mix(alpha, jac, z, y, size)
        clear(out, size)
        add_product(space, node, 0, 1.0, y, out)
        add_product(space, node, size, 1.0, z, out)
        add_product(space, node, 2 * size, a0, jac, out)
        add_product_t(space, jac, 0, 1.0, out, block, 0, m)
        accumulate(exerts, out, size)
        if begin > 0:
            add_product_t(space, node, 2 * size, a0, jac, feel, 0, size)
            add_product_t(space, node, size, 1.0, jac, feel, size, size)
            add_product_t(space, node, 0, 1.0, jac, feel, 2 * size, size)
    accumulate(tail, inner, 3 * size)
    diagonal = system.diagonal[system.offset[b] : system.offset[b + 1]].reshape((m, m))
    for i in range(m):
        for j in range(m):
            diagonal[i, j] = block[i, j]
    motion = rows(system, system.motion, 3 * size, b)
    for c in range(size):
        for j in range(0, width, WIDTH):
            keep_one(motion, c, j, one(jac, c, j))
            keep_one(motion, size + c, j, one(z, c, j))
            keep_one(motion, 2 * size + c, j, one(y, c, j))


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
    place(model, data)
    size = size_of(model.space)
    tail = np.zeros((3 * size, 8))
    tree = model.tree
    forks = len(tree.block) > 0
    waiting = np.zeros((tree.slots[0], 3 * size, 8))
    pieces = (
        np.zeros((WIDTH, 12, 20)),
        np.zeros((WIDTH, 12, 12)),
        np.zeros((WIDTH, 3 * size, 8)),
        np.zeros((1, 40)),
    )
    last = len(model.block_col) - 2
    for b in range(last, -1, -1):
        if forks:
            if b < last and tree.block[b + 1] != b:
                clear(tail, 3 * size)
            if tree.slot[b] >= 0:
                accumulate(tail, waiting[tree.slot[b]], 3 * size)
        block_tangent(model, data, alpha, b, tail, pieces, system)
        if forks and tree.block[b] >= 0 and tree.block[b] != b - 1:
            accumulate(waiting[tree.slot[tree.block[b]]], tail, 3 * size)
    internal_tangent(model, alpha, system)
    actuator_tangent(model, data, alpha, system)
    if alpha[0] != 0.0:
        fibre_tangent(model, data.section, alpha[0], system)
    if len(model.pairs.cell) > 0:
        call_tangent(data.meet.call[1], model, data, alpha, system)
