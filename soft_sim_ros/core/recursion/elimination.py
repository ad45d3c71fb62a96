"""The Newton matrix of a forest, kept and solved block by block at a cost linear in the blocks.

In the base frame a column of the Jacobian is constant beyond its own block, so the matrix is
semiseparable. It is stored by a few numbers per coordinate, the rows P (18), Q (18), J and X (6;
half as many in a plane):

    K_ii = D_i,     K_ij = P_iᵀ Q_j  (i after j: force on i by the motion of j),
                    K_ij = J_iᵀ X_j  (i before j: force that j exerts on i).

With the motion handed towards the tip, s_{i+1} = s_i + Q_i x_i, and the wrench handed towards the
base, t_{i-1} = t_i + X_i x_i, elimination from the tip writes t_i = A_i s_{i+1} + b_i: the
articulated-body idea, on the exact tangent of an implicit step. Blocks of different branches know
nothing of each other: K_ij = 0. Where branches leave, A and t of all of them are summed up, and s
goes on into each.
"""

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.algebra.linalg import lu_factor, lu_invert
from soft_sim_ros.core.algebra.products import (
    accumulate,
    add_product_t,
    add_wide_product,
    clear,
    row_product,
)
from soft_sim_ros.core.algebra.simd import WIDTH, fused, keep_one, one
from soft_sim_ros.core.algebra.spaces import size_of
from soft_sim_ros.core.backend.jit import bare, kernel, unit
from soft_sim_ros.core.backend.structs import struct
from soft_sim_ros.core.floats import Floats, Ints
from soft_sim_ros.core.model.model import Model
from soft_sim_ros.core.model.pairs import columns_of
from soft_sim_ros.core.terms.couplings import add_columns, correct, factor_columns


@struct
class System(NamedTuple):
    """Blocks of the matrix and of its factors.

    With w = 6 components of a twist (3 in a plane), and block b of m coordinates padded to W, a
    multiple of four, with zeros. ``rows`` (k, W) of block b begin at k · column[b] of an array.
    """

    offset: Ints  # (B + 1,) diagonal[offset[b]:] as (m, m)
    column: Ints  # (B + 1,) sums of W
    square: Ints  # (B + 1,) inverse[square[b]:] as (m, W)
    diagonal: Floats  # D
    motion: Floats  # rows (3w, W): Q = (J; Z; Y) at the end of the block
    feels: Floats  # rows (3w, W): P
    exerts: Floats  # rows (w, W): X
    carry: Floats  # rows (3w, W): response of the block to motion of the part before, transposed
    gain: Floats  # rows (w, W): wrench passed on towards the base
    inverse: Floats  # of D + Jᵀ A Q, transposed
    scratch: Floats  # (3w + m, W) of the largest block
    pivot: Ints  # (m,) of the largest block
    vectors: Floats  # (2, W) of the largest block
    left: Floats  # (R, n) columns of U of the couplings between blocks (couplings.py) …
    right: Floats  # (R, n) … and of V
    reach: Floats  # (R, n) columns of K₀⁻¹ U
    small: Floats  # (R R,) factors of 1 + Vᵀ K₀⁻¹ U, of as many columns as are in use
    small_x: Floats  # (R,)
    small_pivot: Ints  # (R,)
    tied: Ints  # (1,) columns in use: those of actuators, then those of bodies that touch
    # (S + 1, 2w, W) J and variation of the twist of every node by the coordinates of its block,
    # where bodies touch one another
    inner: Floats
    # of constraints (closing.py), of C rows on F sites
    close_reach: Floats  # (6F, n) K⁻¹ Jᵀ
    close_comply: Floats  # (6F, 6F) J K⁻¹ Jᵀ
    close_arms: Floats  # (6F, C) wrenches on the sites per multiplier …
    close_bend: Floats  # (6F, 6F) … and per motion J x of the sites
    close_sense: Floats  # (C, 18F) accelerations of rows per (J; Z; Y) x
    close_inverse: Floats  # (C, C) multipliers per acceleration
    close_kept: Floats  # (C,) 1: a row that no others imply


def new_system(model: Model) -> System:
    """Allocate a zeroed system."""
    sizes = np.diff(model.block_col)
    widths = -(-sizes // WIDTH) * WIDTH
    offset, column, square = (
        np.concatenate([[0], np.cumsum(each)]).astype(np.int64)
        for each in (sizes**2, widths, sizes * widths)
    )
    own, n = int(model.couple_ptr[-1]), int(model.block_col[-1])
    ties = own + columns_of(model.pairs, n)
    size, total = len(model.space.components), int(column[-1])
    wide_sites, held = 6 * len(model.closures.site), len(model.closures.rule)
    m, wide = int(sizes.max(initial=0)), int(widths.max(initial=WIDTH))
    return System(
        offset=offset,
        column=column,
        square=square,
        diagonal=np.zeros(offset[-1]),
        motion=np.zeros(3 * size * total),
        feels=np.zeros(3 * size * total),
        exerts=np.zeros(size * total),
        carry=np.zeros(3 * size * total),
        gain=np.zeros(size * total),
        inverse=np.zeros(square[-1]),
        scratch=np.zeros((3 * size + m) * wide),
        pivot=np.zeros(m, dtype=np.int64),
        vectors=np.zeros((2, wide)),
        left=np.zeros((ties, n)),
        right=np.zeros((ties, n)),
        reach=np.zeros((ties, n)),
        small=np.zeros(ties * ties),
        small_x=np.zeros(ties),
        small_pivot=np.zeros(ties, dtype=np.int64),
        tied=np.array([own], dtype=np.int64),
        inner=np.zeros((len(model.inertia) if len(model.pairs.cell) else 0, 2 * size, wide)),
        close_reach=np.zeros((wide_sites, n if wide_sites else 0)),
        close_comply=np.zeros((wide_sites, wide_sites)),
        close_arms=np.zeros((wide_sites, held)),
        close_bend=np.zeros((wide_sites, wide_sites)),
        close_sense=np.zeros((held, 3 * wide_sites)),
        close_inverse=np.zeros((held, held)),
        close_kept=np.zeros(held),
    )


def diagonal_of(model: Model, system: System) -> Ints:
    """Return where the diagonal (n,) of the matrix stands in ``system.diagonal``."""
    sizes = np.diff(model.block_col)
    block = np.repeat(np.arange(len(sizes)), sizes)
    own = np.arange(len(block)) - model.block_col[block]
    return np.asarray(system.offset[block] + own * (sizes[block] + 1))


@kernel
def rows(system, flat, count, b):
    """Return the (count, W) matrix of block b in a flat array."""
    begin, end = system.column[b], system.column[b + 1]
    return flat[count * begin : count * end].reshape((count, end - begin))


@kernel
def before(model, b):
    """Return the block that block b leaves the end of, −1 for the base."""
    return model.tree.block[b] if len(model.tree.block) > 0 else b - 1


@unit
def dense(model, system, matrix):
    """Fill matrix (n, n) with the whole matrix of a system that has not been factored."""
    matrix = bare(matrix)
    size = size_of(model.space)
    for b in range(len(model.block_col) - 1):
        begin, end = model.block_col[b], model.block_col[b + 1]
        m = end - begin
        at = system.offset[b]
        for i in range(m):
            for j in range(m):
                matrix[begin + i, begin + j] = system.diagonal[at]
                at += 1
        feels = rows(system, system.feels, 3 * size, b)
        exerts = rows(system, system.exerts, size, b)
        if len(model.tree.block) > 0:
            for i in range(m):
                for j in range(begin):
                    matrix[begin + i, j] = matrix[j, begin + i] = 0.0
        earlier = before(model, b)
        while earlier >= 0:
            first, stop = model.block_col[earlier], model.block_col[earlier + 1]
            motion = rows(system, system.motion, 3 * size, earlier)
            for i in range(m):
                for j in range(stop - first):
                    below, above = 0.0, 0.0
                    for c in range(3 * size):
                        below += feels[c, i] * motion[c, j]
                    for c in range(size):
                        above += motion[c, j] * exerts[c, i]
                    matrix[begin + i, first + j] = below
                    matrix[first + j, begin + i] = above
            earlier = before(model, earlier)
    add_columns(system, matrix)


@kernel
def add_all(a, b):
    """Add a matrix of the same shape to a."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            a[i, j] += b[i, j]


@kernel
def factor_forest(model, system):
    """Eliminate from tips to base; return False if a block is singular or not finite."""
    space = model.space
    size = size_of(space)
    tree, last = model.tree, len(model.block_col) - 2
    forks = len(tree.block) > 0
    # A_i: wrench handed to the base per unit motion handed to the tip; of branches, summed up
    a = np.zeros((size, 3 * size))
    waiting = np.zeros((tree.slots[0], size, 3 * size))
    for b in range(last, -1, -1):
        if forks:
            # block b + 1 is done: it goes on from b, or hands on to where its branch leaves
            if b < last and tree.block[b + 1] != b:
                p = tree.block[b + 1]
                if p >= 0:
                    add_all(waiting[tree.slot[p]], a)
                a[:] = 0.0
            if tree.slot[b] >= 0:
                add_all(a, waiting[tree.slot[b]])
        m = model.block_col[b + 1] - model.block_col[b]
        if m == 0:
            continue
        motion, gain = rows(system, system.motion, 3 * size, b), rows(system, system.gain, size, b)
        carry = rows(system, system.carry, 3 * size, b)
        width = motion.shape[1]
        felt = system.scratch[: 3 * size * width].reshape((3 * size, width))
        block = system.scratch[3 * size * width : (3 * size + m) * width].reshape((m, width))
        # A Q, and D + Jᵀ A Q, transposed as its inverse will be
        clear(gain, size)
        add_wide_product(a, motion, gain)
        for i in range(m):
            for j in range(m):
                block[j, i] = system.diagonal[system.offset[b] + i * m + j]
        add_product_t(space, gain, 0, 1.0, motion, block, 0, m)
        accumulate(gain, rows(system, system.exerts, size, b), size)
        inverse = system.inverse[system.square[b] : system.square[b + 1]].reshape((m, width))
        if not lu_factor(block, system.pivot):
            return False
        lu_invert(block, system.pivot, inverse)
        # carry = (D + Jᵀ A Q)⁻¹ (Pᵀ + Jᵀ A)
        clear(felt, 3 * size)
        accumulate(felt, rows(system, system.feels, 3 * size, b), 3 * size)
        add_product_t(space, a, 0, 1.0, motion, felt, 0, 3 * size)
        clear(carry, 3 * size)
        add_wide_product(felt, inverse, carry)
        for r in range(size):
            for c in range(3 * size):
                a[r, c] -= row_product(gain, r, carry, c)
    return True


@kernel
def solve_forest(model, system, x):
    """Solve in place for x (n,) with the factors of ``factor_forest``."""
    size = size_of(model.space)
    tree, last = model.tree, len(model.block_col) - 2
    forks = len(tree.block) > 0
    handed = np.zeros(size)  # towards the base
    waiting = np.zeros((tree.slots[0], size))
    for b in range(last, -1, -1):
        if forks:
            if b < last and tree.block[b + 1] != b:
                p = tree.block[b + 1]
                for c in range(size):
                    if p >= 0:
                        waiting[tree.slot[p], c] += handed[c]
                    handed[c] = 0.0
            if tree.slot[b] >= 0:
                for c in range(size):
                    handed[c] += waiting[tree.slot[b], c]
        begin, m = model.block_col[b], model.block_col[b + 1] - model.block_col[b]
        if m == 0:
            continue
        motion, gain = rows(system, system.motion, 3 * size, b), rows(system, system.gain, size, b)
        width = motion.shape[1]
        inverse = system.inverse[system.square[b] : system.square[b + 1]].reshape((m, width))
        for i in range(m):
            system.vectors[0, i] = x[begin + i]
        for j in range(0, width, WIDTH):
            total = one(system.vectors, 0, j)
            for c in range(size):
                total = fused(-handed[c], one(motion, c, j), total)
            keep_one(system.vectors, 0, j, total)
        for j in range(0, width, WIDTH):
            total = system.vectors[0, 0] * one(inverse, 0, j)
            for c in range(1, m):
                total = fused(system.vectors[0, c], one(inverse, c, j), total)
            keep_one(system.vectors, 1, j, total)
        for i in range(m):
            x[begin + i] = system.vectors[1, i]
        for c in range(size):
            handed[c] += row_product(gain, c, system.vectors, 1)
    s = np.zeros(3 * size)
    kept = np.zeros((tree.slots[0], 3 * size))
    for b in range(len(model.block_col) - 1):
        if forks:
            # block b − 1 is done: what leaves its end begins with its motion
            if b > 0 and tree.slot[b - 1] >= 0:
                kept[tree.slot[b - 1]] = s
            p = tree.block[b]
            if p != b - 1:
                for c in range(3 * size):
                    s[c] = kept[tree.slot[p], c] if p >= 0 else 0.0
        begin, m = model.block_col[b], model.block_col[b + 1] - model.block_col[b]
        if m == 0:
            continue
        motion = rows(system, system.motion, 3 * size, b)
        carry = rows(system, system.carry, 3 * size, b)
        width = motion.shape[1]
        for i in range(m):
            system.vectors[1, i] = x[begin + i]
        for i in range(m, width):
            system.vectors[1, i] = 0.0
        if begin > 0:
            for j in range(0, width, WIDTH):
                total = one(system.vectors, 1, j)
                for c in range(3 * size):
                    total = fused(-s[c], one(carry, c, j), total)
                keep_one(system.vectors, 1, j, total)
            for i in range(m):
                x[begin + i] = system.vectors[1, i]
        for c in range(3 * size):
            s[c] += row_product(motion, c, system.vectors, 1)


@unit
def factor(model, system):
    """Factor the whole matrix; return False if it is singular or not finite."""
    if not factor_forest(model, system):
        return False
    if system.tied[0] == 0:
        return True
    return factor_ties(model, system)


@unit
def factor_ties(model, system):
    """Factor what ties blocks together, after ``factor_forest``; return False if it is singular."""
    n = system.left.shape[1]
    for c in range(system.tied[0]):
        for i in range(n):
            system.reach[c, i] = system.left[c, i]
        solve_forest(model, system, system.reach[c])
    return factor_columns(system)


@unit
def solve(model, system, x):
    """Solve in place for x (n,) with the factors of ``factor``."""
    x = bare(x)
    solve_forest(model, system, x)
    if system.tied[0] > 0:
        correct(system, x)
