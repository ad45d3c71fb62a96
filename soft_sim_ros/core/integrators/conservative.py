"""The implicit midpoint rule, made to close the energy ledger.

The midpoint rule keeps quadratic invariants; the energy of large rotations is not quadratic, so it
is off by O(h³) in a step. Multiplying all velocities by one number 1 + O(h³) at the end of the
step changes the kinetic energy by exactly the missing amount, and nothing else. If the arm hardly
moves, a step may correct only a part; the rest is left to the next steps. If it does move, a large
correction means that the step does not resolve the motion, and the step is refused.
"""

import math

from soft_sim_ros.core.backend.jit import call_close, call_stage, unit
from soft_sim_ros.core.terms.forcing import apply_loads, damping_power, inside, load_power

from .ledger import residual, stock
from .newton import CONVERGED, UNBALANCED, largest
from .predictor import judge, predict, remember
from .problem import AFTER_PIECE, CLOSE, DISSIPATED, LOAD_WORK, STAGE, STEPS

# Velocities are not changed by more than this part in one step.
MOST = 0.01
# The rest may be at most this part of all energies while the arm moves faster than this multiple of
# the tolerance of Newton's method; in slower motion the rest is the error of Newton's method.
LEFT, MOVING = 1e-9, 1000.0


@unit
def conservative_step(problem, t, h):
    """Advance by h in s from t; return CONVERGED or why not."""
    model, data, work, state = problem.model, problem.data, problem.work, problem.state
    held, calls, ledger = problem.held, problem.calls, problem.state.ledger
    q, v = state.q, state.v
    n = len(q)
    for i in range(n):
        work.start_q[i], work.start_v[i] = q[i] + 0.5 * h * v[i], v[i]
    apply_loads(problem.loads, held.tip, held.follows[0] != 0, inside(t, h, 0.5), 1.0, data)
    predict(work, 0, h, 1.0)
    status = call_stage(calls[STAGE], problem, 0.25 * h * h, 0.5 * h, problem.method.tolerance)
    if status != CONVERGED:
        return status
    judge(model, work, 0)
    dissipated, worked = h * damping_power(model, data, work.v), h * load_power(model, data)
    for i in range(n):
        work.stage_a[0, i] = work.a[i]
        q[i] += h * work.v[i]
        v[i] += h * work.a[i]
    if calls[CLOSE] != 0:
        status = call_close(calls[CLOSE], problem, AFTER_PIECE, t + h, h)
        if status != CONVERGED:
            return status
    ledger[DISSIPATED] += dissipated
    ledger[LOAD_WORK] += worked
    kinetic, elastic, weight, done = stock(model, data, held, state, q, v)
    wrong = residual(state, kinetic + elastic + weight, done, ledger)
    square = 1.0 - wrong / kinetic if kinetic > 0.0 else 1.0
    factor = min(1.0 + MOST, max(1.0 - MOST, math.sqrt(max(square, 0.0))))
    left = abs(wrong + (factor * factor - 1.0) * kinetic)
    turned = abs(done) + abs(ledger[LOAD_WORK]) + ledger[DISSIPATED]
    if (
        left > LEFT * (kinetic + elastic + abs(weight) + turned)
        and largest(model.weight, v) > MOVING * problem.method.tolerance
    ):
        return UNBALANCED
    for i in range(len(model.law_ptr) - 1):  # dashpots behind the coordinates move no mass
        v[i] *= factor
    remember(work, h)
    work.counters[STEPS] += 1
    return CONVERGED
