"""Maxwell branches: a spring and a dashpot in series, beside the elasticity of every coordinate.

The dashpots' elongations q_d are integrated like coordinates, behind them in every array of a
solver: work.q = (q, q_d), work.v = (q̇, q̇_d). But the law of a dashpot,

    τ q̇_d = q − q_d,     force on the coordinates K_m (q − q_d) = τ K_m q̇_d,

is linear and involves no other dashpot, so every stage solves it in closed form, outside of
Newton's method. A block has one τ. Without branches model.branch_time is empty and nothing here
runs.
"""

from soft_sim_ros.core.backend.jit import kernel


@kernel
def relax(model, work, cq, cv):
    """Set the dashpots of a stage that obey their law with work.q of the coordinates.

    q_d = start_q + cq a_d and q̇_d = start_v + cv a_d, as for any coordinate.
    """
    n = len(model.branch_time)
    for i in range(n):
        d, time = n + i, model.branch_time[i]
        gap = work.q[i] - work.start_q[d] - time * work.start_v[d]
        work.a[d] = gap / (cq + time * cv)
        work.q[d] = work.start_q[d] + cq * work.a[d]
        work.v[d] = work.start_v[d] + cv * work.a[d]


@kernel
def branch_forces(model, v, r):
    """Add the forces of all branches, τ K_m q̇_d, to r."""
    n = len(model.branch_time)
    for i in range(n):
        for e in range(model.law_ptr[i], model.law_ptr[i + 1]):
            j = model.law_col[e]
            r[i] += model.branch[e] * model.branch_time[j] * v[n + j]


@kernel
def branch_tangent(model, cq, cv, system):
    """Add the derivative of the forces by the accelerations of a stage, dashpots following."""
    n = len(model.branch_time)
    if n == 0:
        return
    for b in range(len(model.block_col) - 1):
        begin, end = model.block_col[b], model.block_col[b + 1]
        for i in range(begin, end):
            at = system.offset[b] + (i - begin) * (end - begin) - begin
            for e in range(model.law_ptr[i], model.law_ptr[i + 1]):
                j = model.law_col[e]
                lag = model.branch_time[j] * cv
                system.diagonal[at + j] += model.branch[e] * cq * lag / (cq + lag)


@kernel
def branch_energy(model, q):
    """Return ½ (q − q_d)ᵀ K_m (q − q_d) in J; 0 for q without dashpots, which are then relaxed."""
    n = len(model.branch_time)
    total = 0.0
    if len(q) == n:
        return total
    for i in range(n):
        for e in range(model.law_ptr[i], model.law_ptr[i + 1]):
            j = model.law_col[e]
            total += 0.5 * (q[i] - q[n + i]) * model.branch[e] * (q[j] - q[n + j])
    return total


@kernel
def branch_power(model, v):
    """Return τ q̇_dᵀ K_m q̇_d in W, the dissipation of the dashpots; 0 for v without dashpots."""
    n = len(model.branch_time)
    total = 0.0
    if len(v) == n:
        return total
    for i in range(n):
        for e in range(model.law_ptr[i], model.law_ptr[i + 1]):
            j = model.law_col[e]
            total += v[n + i] * model.branch[e] * model.branch_time[j] * v[n + j]
    return total
