"""One step of a diagonally implicit Runge–Kutta method on (q, q̇), given by its tableau."""

from .forcing import apply_loads, damping_power, inside, load_power
from .jit import call_stage, kernel
from .newton import CONVERGED, STEPS

DISSIPATED, LOAD_WORK = 0, 1


@kernel
def predict(work, tableau, i, h):
    """Set work.a, the guess of stage i, on a line through two earlier stages.

    For the first stage of a step these are the two that the last step left in memory, for later
    ones the last of these and the first stage of this step. Only step sizes enter, not times, so
    the same motion has the same bits whenever it starts.
    """
    if work.restart[0] != 0:
        return
    stages = tableau.shape[0] - 1
    first = tableau[0, stages]
    if i == 0:
        span = 1.0 if stages == 1 else (1.0 - first) / first
        share = h / (span * work.last[0])
        for c in range(len(work.a)):
            work.a[c] = work.memory[1, c] + share * (work.memory[1, c] - work.memory[0, c])
    else:
        share = tableau[i, stages] / first
        for c in range(len(work.a)):
            work.a[c] = work.memory[1, c] + share * (work.stage_a[0, c] - work.memory[1, c])


@kernel
def remember(work, stages, h):
    """Keep the first and last stage of a step (or the last two steps of a one-stage method)."""
    fresh = work.restart[0] != 0
    for c in range(len(work.a)):
        old = work.stage_a[0, c] if stages > 1 or fresh else work.memory[1, c]
        work.memory[0, c], work.memory[1, c] = old, work.stage_a[stages - 1, c]
    work.last[0] = h
    work.restart[0] = 0


@kernel
def dirk_step(
    calls, model, loads, data, work, tableau, tip, tip_follows, tolerance, limit, t, h, q, v, ledger
):
    """Advance q, v by one step of h in s from t; return CONVERGED or why not.

    tableau: (s + 1, s + 1) of A | c over b | 0. Stage i solves r(Q_i, V_i, A_i) = 0 at t + c_i h
    with Q_i = q + h Σ a_ij V_j, V_i = v + h Σ a_ij A_j. Ledger (2,) collects dissipated energy and
    work with weights b.
    """
    stages = tableau.shape[0] - 1
    n = len(q)
    dissipated, worked = 0.0, 0.0
    for i in range(stages):
        diagonal = tableau[i, i] * h
        for c in range(n):
            x, u = q[c], v[c]
            for j in range(i):
                x += h * tableau[i, j] * work.stage_v[j, c]
                u += h * tableau[i, j] * work.stage_a[j, c]
            work.start_v[c] = u
            work.start_q[c] = x + diagonal * u
        apply_loads(loads, tip, tip_follows, inside(t, h, tableau[i, stages]), 1.0, data)
        predict(work, tableau, i, h)
        status = call_stage(
            calls[2], calls, model, data, work, diagonal * diagonal, diagonal, tolerance, limit
        )
        if status != CONVERGED:
            return status
        for c in range(n):
            work.stage_v[i, c] = work.v[c]
            work.stage_a[i, c] = work.a[c]
        weight = h * tableau[stages, i]
        dissipated += weight * damping_power(model, data, work.v)
        worked += weight * load_power(model, data)
    for c in range(n):
        for i in range(stages):
            q[c] += h * tableau[stages, i] * work.stage_v[i, c]
            v[c] += h * tableau[stages, i] * work.stage_a[i, c]
    remember(work, stages, h)
    ledger[DISSIPATED] += dissipated
    ledger[LOAD_WORK] += worked
    work.counters[STEPS] += 1
    return CONVERGED
