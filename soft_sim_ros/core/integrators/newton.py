"""Newton's method for one implicit stage."""

import math

from soft_sim_ros.core.backend.jit import (
    Call,
    call_close,
    call_residual,
    call_tangent,
    kernel,
    unit,
)
from soft_sim_ros.core.recursion.closing import closed_dynamics
from soft_sim_ros.core.recursion.elimination import factor, solve
from soft_sim_ros.core.recursion.momentum import uphold
from soft_sim_ros.core.recursion.rnea import inverse_dynamics
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.terms.driven import follow_drives, hold_still, leave_out, note_forces
from soft_sim_ros.core.terms.fibres import lawful
from soft_sim_ros.core.terms.maxwell import branch_forces, branch_tangent, relax

from .problem import (
    CLOSE,
    CORRECT,
    CORRECTION,
    CQ,
    CV,
    EVALUATIONS,
    FACTOR,
    FACTORISATIONS,
    ITERATIONS,
    NO_FACTORS,
    PATTERN,
    RESIDUAL,
    TANGENT,
    Problem,
)

CONVERGED, TOO_MANY, NOT_FINITE, SINGULAR, UNRESOLVED, INVERTED, TOO_FAR = 0, 1, 2, 3, 4, 5, 6
LAWLESS, TOO_ROUGH, UNBALANCED, UNMET, MADE = 7, 8, 9, 10, 11
# In words, for errors.
REASONS = {
    1: "Newton's method does not converge, even with 1/4096 of the step",
    2: "the state is not finite",
    3: "the Newton matrix is singular",
    4: "a rod bends or twists by more than half a turn within one segment (more elements or nodes "
    "resolve it, if it is meant)",
    5: "a rod is compressed to nothing",
    6: "the tip moves by more than an arm length (or a hinge by a radian) in a fraction of a step",
    7: "a fibre is stretched, compressed or sheared beyond where the law of its material holds",
    8: "options.error cannot be met, even with a millionth of the step",
    9: "the steps do not show the motion: balancing its energy would change velocities by "
    "more than 1 %, even with 1/4096 of the step (a smaller step, or sdirk2, which damps what it "
    "does not show)",
    10: "a constraint is not met: it asks for more than bodies can do, contradicts another one, or "
    "is made where its frames are apart",
    11: "a contact makes energy, even with 1/128 of the step (a smaller step, or a softer or more "
    "damped contact)",
}
# A slower contraction than this triggers new factors.
SLOW = 0.2
# A measured contraction is trusted a little less every time it is used without being measured
# again, and never assumed better than FASTEST: the slowest component may not have shown yet.
AGEING, FASTEST = 1.1, 0.03
# A last correction that is smaller, over the goal, does not bend a bristle.
SETTLED = 1e-3
# Two corrections in a row that are smaller, over the goal, end an iteration with constraints: where
# they hold all that could move, corrections are round-off and contract no further.
STILL = 1e-2


@unit
def admissible(model, data):
    """Return CONVERGED if the rods of the last sweep are physically possible, else the reason.

    Beyond half a turn within one segment the Magnus step is invalid, and at zero stretch the rod is
    crushed: such states may solve the equations but have no physical meaning.
    """
    for k in range(len(model.half)):
        if model.kappa[k] == 0.0:
            continue
        wx, wy, wz = data.omega[k, 0, 0], data.omega[k, 0, 1], data.omega[k, 0, 2]
        if not wx * wx + wy * wy + wz * wz < math.pi**2:
            return UNRESOLVED
        if not (data.xi[k, 0, 0, 3] > 0.0 and data.xi[k, 1, 0, 3] > 0.0):
            return INVERTED
    return CONVERGED if lawful(model.fibres, data.section) else LAWLESS


@kernel
def largest(weight, x):
    """Return max |x| weight, NaN if any is."""
    size = 0.0
    for i in range(len(x)):
        change = abs(x[i]) * weight[i]
        if not change <= size:  # written so that NaN propagates
            size = change
    return size


@kernel
def give_up(problem, why):
    """Leave nothing of a failed iteration that a shorter step would begin with; return why."""
    problem.work.key[CQ] = NO_FACTORS
    if problem.calls[CLOSE] != 0:
        problem.data.closed.multiplier[:] = 0.0
    return why


@unit
def solve_stage(problem, cq, cv, goal):
    """Find work.a with r(q, v, a) = 0 at q = start_q + cq a, v = start_v + cv a.

    The measure of convergence is the largest correction of a velocity, each coordinate weighed by
    how far it moves the tip, in arm lengths per second. Factors are kept, across steps too, while
    they contract well, together with their measured contraction: once it is known, the first
    correction is enough to estimate the remaining error. goal: largest remaining error.
    """
    model, data, work, method = problem.model, problem.data, problem.work, problem.method
    calls = problem.calls
    n = len(work.a)
    driven, closing = len(model.driven) > 0, calls[CLOSE]
    judged = 1 if closing != 0 else 0
    touching = len(model.contact.node) > 0
    if touching:
        data.touch.mode[0] = cv
    stale = work.key[CQ] != cq or work.key[CV] != cv
    before = 0.0
    refreshed = -1
    for iteration in range(method.limit):
        for i in range(n):
            work.q[i] = work.start_q[i] + cq * work.a[i]
            work.v[i] = work.start_v[i] + cv * work.a[i]
        if driven:
            follow_drives(model, data, work)
        relax(model, work, cq, cv)
        call_residual(calls[RESIDUAL], model, data, work.q, work.v, work.a, work.residual)
        branch_forces(model, work.v, work.residual)
        if driven:
            leave_out(model, work.residual)
        work.counters[EVALUATIONS] += 1
        if touching:
            stale = stale or data.touch.pattern[0] != work.key[PATTERN]
        if stale:
            call_tangent(calls[TANGENT], model, data, (cq, cv, 1.0), work.system)
            branch_tangent(model, cq, cv, work.system)
            if driven:
                hold_still(model, work.system)
            work.counters[FACTORISATIONS] += 1
            work.key[CQ], work.key[CV] = cq, cv
            if touching:
                work.key[PATTERN] = data.touch.pattern[0]
            work.rate[0] = 1.0
            if not factor(model, work.system):
                return give_up(problem, SINGULAR)
            if closing != 0 and call_close(closing, problem, FACTOR, cq, 0.0) != CONVERGED:
                return give_up(problem, SINGULAR)
            stale = False
            refreshed = iteration
        solve(model, work.system, work.residual)
        if closing != 0:
            call_close(closing, problem, CORRECT, 0.0, 0.0)
        for i in range(n):
            work.a[i] -= work.residual[i]
        size = cv * largest(model.weight, work.residual)
        work.counters[ITERATIONS] += 1
        work.measure[CORRECTION] = size
        if not math.isfinite(size):
            return give_up(problem, NOT_FINITE)
        # remaining error if the contraction stays the same
        if iteration == 0:
            rate = max(work.rate[0], FASTEST)
            left = size * rate / (1.0 - rate) if rate < 0.5 else size
            work.rate[0] = min(1.0, rate * AGEING)
        else:
            rate = size / before if before > 0.0 else 0.0
            left = size * rate / (1.0 - rate) if rate < 1.0 else math.inf
            if closing != 0 and max(size, before) <= STILL * goal:
                left = size
            if iteration > refreshed:
                known = 0.8 * work.rate[0] if work.rate[0] < 1.0 else 0.0
                work.rate[0] = min(1.0, max(rate, known))
        # multipliers jump in the first correction, and what that leaves shows in the second
        if left <= goal and iteration >= judged:
            for i in range(n):
                work.q[i] = work.start_q[i] + cq * work.a[i]
                work.v[i] = work.start_v[i] + cv * work.a[i]
            if driven:
                follow_drives(model, data, work)
            relax(model, work, cq, cv)
            if driven:  # once more, where Newton's method has come to: the forces that it takes
                call_residual(calls[0], model, data, work.q, work.v, work.a, work.residual)
                branch_forces(model, work.v, work.residual)
                note_forces(model, data, work.residual)
            elif touching and data.touch.pattern[0] != 0.0 and size > SETTLED * goal:
                # bristles as of where Newton's method has come to
                call_residual(calls[RESIDUAL], model, data, work.q, work.v, work.a, work.residual)
            return admissible(model, data)
        if iteration > judged and rate > SLOW:
            if refreshed >= 0 and iteration > refreshed + 2 and rate > 2.0:
                break  # diverges with exact factors
            stale = True
        before = size
    return give_up(problem, TOO_MANY)


def called(problem: Problem) -> list[Call]:
    """Return the calls of inverse_dynamics, tangent, solve_stage and uphold (None: not needed)."""
    work, arguments = problem.work, (problem.model, problem.data)
    state = (work.q, work.v, work.a, work.residual)
    # a free base has a rotation vector too; a scene without any does not compile this kernel
    charts = len(problem.model.chart) > 0
    closed = len(problem.model.closures.node) > 0
    return [
        (closed_dynamics if closed else inverse_dynamics, *arguments, *state),
        (tangent, *arguments, (1.0, 1.0, 1.0), work.system),
        (solve_stage, problem, 1.0, 1.0, 1.0),
        (uphold, *arguments, work, 1.0, work.q, work.v) if charts else None,
    ]
