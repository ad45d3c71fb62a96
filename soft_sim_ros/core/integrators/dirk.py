"""One step of a diagonally implicit Runge–Kutta method on (q, q̇), given by its tableau."""

from soft_sim_ros.core.backend.jit import call_bristles, call_contact, call_stage, unit
from soft_sim_ros.core.terms.forcing import apply_loads, damping_power, inside, load_power
from soft_sim_ros.core.terms.touch import begin_stage, end_stage, take_over

from .newton import CONVERGED
from .predictor import judge, predict, remember
from .problem import DISSIPATED, LOAD_WORK, STAGE, STEPS


@unit
def dirk_step(problem, t, h):
    """Advance by one step of h in s from t; return CONVERGED or why not.

    Stage i solves r(Q_i, V_i, A_i) = 0 at t + c_i h with Q_i = q + h Σ a_ij V_j, V_i = v + h Σ a_ij
    A_j. Dissipated energy and work of loads are summed up with the weights b.
    """
    model, data, work, state = problem.model, problem.data, problem.work, problem.state
    tableau, loads, held = problem.method.tableau, problem.loads, problem.held
    q, v, calls, goal = state.q, state.v, problem.calls, problem.method.tolerance
    stages = tableau.shape[0] - 1
    n = len(q)
    first = tableau[0, stages]
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
        apply_loads(
            loads, held.tip, held.follows[0] != 0, inside(t, h, tableau[i, stages]), 1.0, data
        )
        if i > 0:
            share = tableau[i, stages] / first
        else:
            share = first / (1.0 - first) if stages > 1 else 1.0
        predict(work, i, h, share)
        if len(model.contact.node) > 0:
            begin_stage(data.touch, data.touch.bristle, 0, tableau, i, h)
        status = call_stage(calls[STAGE], problem, diagonal * diagonal, diagonal, goal)
        if status != CONVERGED:
            return status
        if len(model.contact.node) > 0:
            end_stage(data.touch, i, diagonal)
        judge(model, work, i)
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
    if len(model.contact.node) > 0 and data.touch.alive[0] != 0:
        bristle = data.touch.bristle[0]
        dissipated += call_bristles(data.touch.call[3], model, data, bristle)
        take_over(data.touch, data.touch.bristle, 0)
        dissipated -= call_bristles(data.touch.call[3], model, data, bristle)
        if len(model.pairs.cell) > 0:
            call_contact(data.meet.call[3], model, data)
    remember(work, h)
    state.ledger[DISSIPATED] += dissipated
    state.ledger[LOAD_WORK] += worked
    work.counters[STEPS] += 1
    return CONVERGED
