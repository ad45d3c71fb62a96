"""The Newton matrix of a chain, kept and solved block by block at a cost linear in the blocks.

In the base frame a column of the Jacobian stays what it is beyond its own block, so the matrix is
semiseparable: with a few numbers per coordinate, rows P (18), Q (18), J and X (6; in a plane half
as many),

    K_ii = D_i,     K_ij = P_iᵀ Q_j  (i after j: what i feels of the motion of j),
                    K_ij = J_iᵀ X_j  (i before j: what j exerts on i).

With the motion handed towards the tip, s_{i+1} = s_i + Q_i x_i, and the wrench handed towards the
base, t_{i-1} = t_i + X_i x_i, elimination from the tip writes t_i = A_i s_{i+1} + b_i: the
articulated-body idea, on the exact tangent of an implicit step.
"""

from typing import NamedTuple

import numpy as np

from ..model import Floats, Ints, Model
from .coupling import add_columns, correct, factor_columns
from .jit import bare, kernel, unit
from .linalg import lu_factor, lu_solve, lu_solve_rows, row_dot
from .memory import struct
from .spaces import size_of


@struct
class System(NamedTuple):
    """Blocks of the matrix and of its factors.

    A block of m coordinates from c on owns …
    """

    offset: Ints  # (B + 1,) … diagonal[offset:] as (m, m)
    diagonal: Floats  # D, then its LU factors after elimination
    # with w = 6 components of a twist (3 in a plane)
    motion: Floats  # (3w n,) … motion[3w c:] as (3w, m): Q = (J; Z; Y) at the end of the block
    feels: Floats  # (3w n,) likewise: P
    exerts: Floats  # (w n,) exerts[w c:] as (w, m): X
    carry: Floats  # (3w n,) carry[3w c:] as (m, 3w): what it does when the part before moves by s
    gain: Floats  # (w n,) gain[w c:] as (w, m): what it hands on to the base
    pivot: Ints  # (n,)
    left: Floats  # (R, n) columns of U, of what ties blocks together (coupling.py) …
    right: Floats  # (R, n) … and of V
    reach: Floats  # (R, n) columns of K₀⁻¹ U
    small: Floats  # (R, R) factors of 1 + Vᵀ K₀⁻¹ U
    small_x: Floats  # (R,)
    small_pivot: Ints  # (R,)


def new_system(model: Model) -> System:
    """Allocate a zeroed system."""
    sizes = np.diff(model.block_col)
    n = int(model.block_col[-1])
    ties = int(model.couple_ptr[-1])
    size = len(model.space.components)
    return System(
        offset=np.concatenate([[0], np.cumsum(sizes**2)]).astype(np.int64),
        diagonal=np.zeros(int(np.sum(sizes**2))),
        motion=np.zeros(3 * size * n),
        feels=np.zeros(3 * size * n),
        exerts=np.zeros(size * n),
        carry=np.zeros(3 * size * n),
        gain=np.zeros(size * n),
        pivot=np.zeros(n, dtype=np.int64),
        left=np.zeros((ties, n)),
        right=np.zeros((ties, n)),
        reach=np.zeros((ties, n)),
        small=np.zeros((ties, ties)),
        small_x=np.zeros(ties),
        small_pivot=np.zeros(ties, dtype=np.int64),
    )


@kernel
def rows(flat, count, begin, end):
    """Return the (count, m) matrix of a block in a flat array."""
    return flat[count * begin : count * end].reshape((count, end - begin))


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
        feels = rows(system.feels, 3 * size, begin, end)
        exerts = rows(system.exerts, size, begin, end)
        for earlier in range(b):
            first, stop = model.block_col[earlier], model.block_col[earlier + 1]
            motion = rows(system.motion, 3 * size, first, stop)
            for i in range(m):
                for j in range(stop - first):
                    below, above = 0.0, 0.0
                    for c in range(3 * size):
                        below += feels[c, i] * motion[c, j]
                    for c in range(size):
                        above += motion[c, j] * exerts[c, i]
                    matrix[begin + i, first + j] = below
                    matrix[first + j, begin + i] = above
    add_columns(system, matrix)


@kernel
def factor_chain(model, system):
    """Eliminate from the tip to the base; return False if a block is singular or not finite."""
    size = size_of(model.space)
    # A_i: wrench handed to the base per unit motion handed to the tip
    a = np.zeros((size, 3 * size))
    for b in range(len(model.block_col) - 2, -1, -1):
        begin, end = model.block_col[b], model.block_col[b + 1]
        m = end - begin
        if m == 0:
            continue
        d = system.diagonal[system.offset[b] : system.offset[b + 1]].reshape((m, m))
        motion = rows(system.motion, 3 * size, begin, end)
        feels = rows(system.feels, 3 * size, begin, end)
        gain = rows(system.gain, size, begin, end)
        carry = system.carry[3 * size * begin : 3 * size * end].reshape((m, 3 * size))
        # gain = A Q + X, and D + Jᵀ A Q
        for r in range(size):
            for j in range(m):
                gain[r, j] = 0.0
            for c in range(3 * size):
                s = a[r, c]
                for j in range(m):
                    gain[r, j] += s * motion[c, j]
            for i in range(m):
                s = motion[r, i]
                for j in range(m):
                    d[i, j] += s * gain[r, j]
            for j in range(m):
                gain[r, j] += system.exerts[size * begin + r * m + j]
        if not lu_factor(d, system.pivot[begin:end]):
            return False
        # carry = (D + Jᵀ A Q)⁻¹ (Pᵀ + Jᵀ A)
        for i in range(m):
            for c in range(3 * size):
                carry[i, c] = feels[c, i]
            for r in range(size):
                s = motion[r, i]
                for c in range(3 * size):
                    carry[i, c] += s * a[r, c]
        lu_solve_rows(d, system.pivot[begin:end], carry)
        for r in range(size):
            for i in range(m):
                s = gain[r, i]
                for c in range(3 * size):
                    a[r, c] -= s * carry[i, c]
    return True


@kernel
def solve_chain(model, system, x):
    """Solve in place for x (n,) with the factors of ``factor_chain``."""
    size = size_of(model.space)
    handed = np.zeros(size)  # towards the base
    for b in range(len(model.block_col) - 2, -1, -1):
        begin, end = model.block_col[b], model.block_col[b + 1]
        m = end - begin
        if m == 0:
            continue
        d = system.diagonal[system.offset[b] : system.offset[b + 1]].reshape((m, m))
        jac = rows(system.motion, 3 * size, begin, end)
        gain = rows(system.gain, size, begin, end)
        y = x[begin:end]
        for c in range(size):
            take = handed[c]
            for i in range(m):
                y[i] -= jac[c, i] * take
        lu_solve(d, system.pivot[begin:end], y)
        for c in range(size):
            handed[c] += row_dot(gain[c], y, 0, m)
    s = np.zeros(3 * size)
    for b in range(len(model.block_col) - 1):
        begin, end = model.block_col[b], model.block_col[b + 1]
        m = end - begin
        motion = rows(system.motion, 3 * size, begin, end)
        carry = system.carry[3 * size * begin : 3 * size * end].reshape((m, 3 * size))
        if begin > 0:
            for i in range(m):
                x[begin + i] -= row_dot(carry[i], s, 0, 3 * size)
        y = x[begin:end]
        for c in range(3 * size):
            s[c] += row_dot(motion[c], y, 0, m)


@unit
def factor(model, system):
    """Factor the whole matrix; return False if it is singular or not finite."""
    if not factor_chain(model, system):
        return False
    if system.left.shape[0] == 0:
        return True
    return factor_ties(model, system)


@unit
def factor_ties(model, system):
    """Factor what ties blocks together, after ``factor_chain``; return False if it is singular."""
    ties, n = system.left.shape
    for c in range(ties):
        for i in range(n):
            system.reach[c, i] = system.left[c, i]
        solve_chain(model, system, system.reach[c])
    return factor_columns(system)


@unit
def solve(model, system, x):
    """Solve in place for x (n,) with the factors of ``factor``."""
    x = bare(x)
    solve_chain(model, system, x)
    if system.left.shape[0] > 0:
        correct(system, x)
