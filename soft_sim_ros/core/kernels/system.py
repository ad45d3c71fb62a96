"""The Newton matrix of a chain, kept and solved block by block at a cost linear in the blocks.

In the base frame a column of the Jacobian stays what it is beyond its own block, so the matrix is
semiseparable: with a few numbers per coordinate, rows P (18), Q (18), J and X (6),

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
from .linalg import lu_factor, lu_solve, lu_solve_rows


class System(NamedTuple):
    """Blocks of the matrix and of its factors.

    A block of m coordinates from c on owns …
    """

    offset: Ints  # (B + 1,) … diagonal[offset:] as (m, m)
    diagonal: Floats  # D, then its LU factors after elimination
    motion: Floats  # (18 n,) … motion[18 c:] as (18, m): Q = (J; Z; Y) at the end of the block
    feels: Floats  # (18 n,) likewise: P
    exerts: Floats  # (6 n,) exerts[6 c:] as (6, m): X
    carry: Floats  # (18 n,) carry[18 c:] as (m, 18): what it does when the part before moves by s
    gain: Floats  # (6 n,) gain[6 c:] as (6, m): what it hands on to the base
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
    return System(
        offset=np.concatenate([[0], np.cumsum(sizes**2)]).astype(np.int64),
        diagonal=np.zeros(int(np.sum(sizes**2))),
        motion=np.zeros(18 * n),
        feels=np.zeros(18 * n),
        exerts=np.zeros(6 * n),
        carry=np.zeros(18 * n),
        gain=np.zeros(6 * n),
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
    model, system, matrix = bare(model), bare(system), bare(matrix)
    for b in range(len(model.block_col) - 1):
        begin, end = model.block_col[b], model.block_col[b + 1]
        m = end - begin
        at = system.offset[b]
        for i in range(m):
            for j in range(m):
                matrix[begin + i, begin + j] = system.diagonal[at]
                at += 1
        feels = rows(system.feels, 18, begin, end)
        exerts = rows(system.exerts, 6, begin, end)
        for earlier in range(b):
            first, stop = model.block_col[earlier], model.block_col[earlier + 1]
            motion = rows(system.motion, 18, first, stop)
            for i in range(m):
                for j in range(stop - first):
                    below, above = 0.0, 0.0
                    for c in range(18):
                        below += feels[c, i] * motion[c, j]
                    for c in range(6):
                        above += motion[c, j] * exerts[c, i]
                    matrix[begin + i, first + j] = below
                    matrix[first + j, begin + i] = above
    add_columns(system, matrix)


@kernel
def factor_chain(model, system):
    """Eliminate from the tip to the base; return False if a block is singular or not finite."""
    a = np.zeros((6, 18))  # A_i: wrench handed to the base per unit motion handed to the tip
    for b in range(len(model.block_col) - 2, -1, -1):
        begin, end = model.block_col[b], model.block_col[b + 1]
        m = end - begin
        if m == 0:
            continue
        d = system.diagonal[system.offset[b] : system.offset[b + 1]].reshape((m, m))
        motion = rows(system.motion, 18, begin, end)
        feels = rows(system.feels, 18, begin, end)
        gain = rows(system.gain, 6, begin, end)
        carry = system.carry[18 * begin : 18 * end].reshape((m, 18))
        # gain = A Q + X, and D + Jᵀ A Q
        for r in range(6):
            for j in range(m):
                gain[r, j] = 0.0
            for c in range(18):
                s = a[r, c]
                for j in range(m):
                    gain[r, j] += s * motion[c, j]
            for i in range(m):
                s = motion[r, i]
                for j in range(m):
                    d[i, j] += s * gain[r, j]
            for j in range(m):
                gain[r, j] += system.exerts[6 * begin + r * m + j]
        if not lu_factor(d, system.pivot[begin:end]):
            return False
        # carry = (D + Jᵀ A Q)⁻¹ (Pᵀ + Jᵀ A)
        for i in range(m):
            for c in range(18):
                carry[i, c] = feels[c, i]
            for r in range(6):
                s = motion[r, i]
                for c in range(18):
                    carry[i, c] += s * a[r, c]
        lu_solve_rows(d, system.pivot[begin:end], carry)
        for r in range(6):
            for i in range(m):
                s = gain[r, i]
                for c in range(18):
                    a[r, c] -= s * carry[i, c]
    return True


@kernel
def solve_chain(model, system, x):
    """Solve in place for x (n,) with the factors of ``factor_chain``."""
    b0, b1, b2, b3, b4, b5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for b in range(len(model.block_col) - 2, -1, -1):
        begin, end = model.block_col[b], model.block_col[b + 1]
        m = end - begin
        if m == 0:
            continue
        d = system.diagonal[system.offset[b] : system.offset[b + 1]].reshape((m, m))
        jac = rows(system.motion, 18, begin, end)
        gain = rows(system.gain, 6, begin, end)
        y = x[begin:end]
        for i in range(m):
            y[i] -= (jac[0, i] * b0 + jac[1, i] * b1 + jac[2, i] * b2) + (
                jac[3, i] * b3 + jac[4, i] * b4 + jac[5, i] * b5
            )
        lu_solve(d, system.pivot[begin:end], y)
        for i in range(m):
            b0 += gain[0, i] * y[i]
            b1 += gain[1, i] * y[i]
            b2 += gain[2, i] * y[i]
            b3 += gain[3, i] * y[i]
            b4 += gain[4, i] * y[i]
            b5 += gain[5, i] * y[i]
    s = np.zeros(18)
    for b in range(len(model.block_col) - 1):
        begin, end = model.block_col[b], model.block_col[b + 1]
        m = end - begin
        motion = rows(system.motion, 18, begin, end)
        carry = system.carry[18 * begin : 18 * end].reshape((m, 18))
        if begin > 0:
            for i in range(m):
                total = 0.0
                for c in range(18):
                    total += carry[i, c] * s[c]
                x[begin + i] -= total
        for c in range(18):
            for i in range(m):
                s[c] += motion[c, i] * x[begin + i]


@kernel
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
    model, system = bare(model), bare(system)
    ties, n = system.left.shape
    for c in range(ties):
        for i in range(n):
            system.reach[c, i] = system.left[c, i]
        solve_chain(model, system, system.reach[c])
    return factor_columns(system)


@kernel
def solve(model, system, x):
    """Solve in place for x (n,) with the factors of ``factor``."""
    solve_chain(model, system, x)
    if system.left.shape[0] > 0:
        correct(system, x)
