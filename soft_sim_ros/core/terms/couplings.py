"""Couplings between blocks that are not neighbours: K = K₀ + U Vᵀ with few columns.

A tendon whose length is commanded is a spring between all blocks that it passes: one column. K₀ is
the chain's own matrix, solved at linear cost; the rest is the formula of Sherman, Morrison and
Woodbury, x = y − Z (1 + Vᵀ Z)⁻¹ Vᵀ y with y = K₀⁻¹ f, Z = K₀⁻¹ U. Without columns it costs nothing.
"""

from soft_sim_ros.core.algebra.linalg import lu_factor, lu_solve, row_dot
from soft_sim_ros.core.backend.jit import kernel


@kernel
def add_columns(system, matrix):
    """Add U Vᵀ to matrix (n, n)."""
    for c in range(system.left.shape[0]):
        for i in range(matrix.shape[0]):
            for j in range(matrix.shape[1]):
                matrix[i, j] += system.left[c, i] * system.right[c, j]


@kernel
def factor_columns(system):
    """Factor 1 + Vᵀ Z, Z in system.reach; return False if it is singular."""
    count, n = system.left.shape
    for a in range(count):
        for b in range(count):
            system.small[a, b] = row_dot(system.right[a], system.reach[b], 0, n)
        system.small[a, a] += 1.0
    return lu_factor(system.small, system.small_pivot)


@kernel
def correct(system, x):
    """Turn x = K₀⁻¹ f into K⁻¹ f."""
    count, n = system.left.shape
    for a in range(count):
        system.small_x[a] = row_dot(system.right[a], x, 0, n)
    lu_solve(system.small, system.small_pivot, system.small_x)
    for a in range(count):
        s = system.small_x[a]
        for j in range(n):
            x[j] -= s * system.reach[a, j]
