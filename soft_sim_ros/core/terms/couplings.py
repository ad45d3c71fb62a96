"""Couplings between blocks that are not neighbours: K = K₀ + U Vᵀ with few columns.

A tendon whose length is commanded is a spring between all blocks that it passes: one column. K₀ is
the chain's own matrix, solved at linear cost; the rest is the formula of Sherman, Morrison and
Woodbury, x = y − Z (1 + Vᵀ Z)⁻¹ Vᵀ y with y = K₀⁻¹ f, Z = K₀⁻¹ U. Without columns it costs nothing.

Columns of tendons are always in use, those of bodies that touch while they do: System.tied.
"""

from soft_sim_ros.core.algebra.linalg import lu_factor, lu_solve, row_dot
from soft_sim_ros.core.backend.jit import kernel


@kernel
def add_columns(system, matrix):
    """Add U Vᵀ to matrix (n, n)."""
    for c in range(system.tied[0]):
        for i in range(matrix.shape[0]):
            for j in range(matrix.shape[1]):
                matrix[i, j] += system.left[c, i] * system.right[c, j]


@kernel
def small_of(system, count):
    """Return the matrix 1 + Vᵀ Z of so many columns."""
    return system.small[: count * count].reshape((count, count))


@kernel
def factor_columns(system):
    """Factor 1 + Vᵀ Z, Z in system.reach; return False if it is singular."""
    count, n = system.tied[0], system.left.shape[1]
    small = small_of(system, count)
    for a in range(count):
        for b in range(count):
            small[a, b] = row_dot(system.right[a], system.reach[b], 0, n)
        small[a, a] += 1.0
    return lu_factor(small, system.small_pivot)


@kernel
def correct(system, x):
    """Turn x = K₀⁻¹ f into K⁻¹ f."""
    count, n = system.tied[0], system.left.shape[1]
    for a in range(count):
        system.small_x[a] = row_dot(system.right[a], x, 0, n)
    lu_solve(small_of(system, count), system.small_pivot, system.small_x)
    for a in range(count):
        s = system.small_x[a]
        for j in range(n):
            x[j] -= s * system.reach[a, j]
