"""A high-order method whose steps follow the motion, not the grid.

The scene's step stays the grid on which inputs change and states are given; the steps of the method
reach as far beyond it as the error allows. Between their ends the motion is a polynomial through
q, q̇ and q̈ at both ends (q̇ its derivative). Where an input jumps, the present step is
cut: the next one starts from the polynomial's state on the grid.

A step of an ESDIRK method begins with the acceleration at the end of the last one. After a jump
that is meaningless, and the exact one, M q̈ = −r, belongs to the fastest strains only. The first
step is therefore one of an SDIRK method with the same coefficient on the diagonal, which asks
for no acceleration and uses the same factors; its polynomial does without q̈ at the start.

Times are counted from the last jump, so the same motion has the same bits whenever it starts.
"""

from soft_sim_ros.core.backend.jit import (
    call_bristles,
    call_close,
    call_made,
    call_stage,
    call_uphold,
    kernel,
    unit,
)
from soft_sim_ros.core.terms.driven import bring
from soft_sim_ros.core.terms.forcing import (
    apply_loads,
    damping_power,
    inside,
    load_power,
    next_switch,
    switches_at,
)
from soft_sim_ros.core.terms.touch import (
    adopt,
    begin_stage,
    between,
    end_stage,
    explicit_stage,
)

from .newton import CONVERGED, MADE, TOO_FAR, TOO_ROUGH
from .problem import (
    A0,
    A1,
    AFTER_PIECE,
    AFTER_TRIAL,
    BEFORE_NEXT,
    CLOSE,
    DISSIPATED,
    END,
    LOAD_WORK,
    LOST,
    POWER,
    Q0,
    Q1,
    QN,
    REJECTED,
    STAGE,
    START,
    STEPS,
    TIME_ERROR,
    TRIAL,
    UPHOLD,
    V0,
    V1,
    VN,
)

# Work.clock: start and length of the present step in s after the last jump of an input, the length
# to try next, the error of the last step over the permitted one, grid steps since that jump;
# whether something jumped at the end of the present step, whether something jumped at its start;
# the length that the last step after a jump should have had
BEGIN, LENGTH, NEXT, ERROR, SINCE, JUMPED, FIRST, FRESH = 0, 1, 2, 3, 4, 5, 6, 7
# Newton's method may leave this share of the error permitted to a step.
NEWTON = 0.02
# The step length is kept if the optimal one is longer by less than this: then factors are kept too.
WORTH = 1.3
SAFETY, SHRINK, GROW = 0.9, 0.1, 5.0
# A step may not move the tip further than this, in arm lengths (or a hinge, in radians).
REACH = 1.0
# bounds of a step in grid steps
SHORTEST, LONGEST = 1e-6, 1e4
SMALL = 1e-2  # no shorter one is cut because a contact makes energy


@unit
def adaptive_step(problem, t, h):
    """Bring the state from t to t + h in s; return CONVERGED or why not."""
    work, state = problem.work, problem.state
    clock, span, booked = work.clock, work.span, work.booked
    n = len(state.q)
    if work.restart[0] != 0:
        clock[BEGIN] = clock[LENGTH] = clock[SINCE] = 0.0
        clock[JUMPED] = 1.0
        for i in range(n):
            span[QN, i], span[VN, i] = state.q[i], state.v[i]
        booked[END, DISSIPATED] = state.ledger[DISSIPATED]
        booked[END, LOAD_WORK] = state.ledger[LOAD_WORK]
        if len(problem.model.contact.node) > 0:
            problem.data.touch.ends[1] = problem.data.touch.bristle[0]
        work.restart[0] = 0
    anchor = t - clock[SINCE] * h
    target = (clock[SINCE] + 1.0) * h
    while clock[BEGIN] + clock[LENGTH] < target - 1e-9 * h:
        status = next_step(problem, anchor, h)
        if status != CONVERGED:
            return status
    interpolate(work, state, target)
    if len(problem.model.contact.node) > 0:
        if problem.data.touch.alive[0] != 0:
            between(problem.data.touch, (target - clock[BEGIN]) / clock[LENGTH])
        else:
            problem.data.touch.bristle[:] = 0.0
    if len(problem.model.driven) > 0:
        bring(problem.loads.drives, problem.data.live.course, t + h, state.q, state.v)
    if problem.calls[CLOSE] != 0:
        status = call_close(problem.calls[CLOSE], problem, AFTER_PIECE, t + h, h)
        if status != CONVERGED:
            return status
    clock[SINCE] += 1.0
    return CONVERGED


@unit
def next_step(problem, anchor, h):
    """Make the next step of the method, however long; on failure the present one stays."""
    model, data, work, method = problem.model, problem.data, problem.work, problem.method
    uphold, closing = problem.calls[UPHOLD], problem.calls[CLOSE]
    clock, span, booked = work.clock, work.span, work.booked
    n = len(work.a)
    begin = clock[BEGIN] + clock[LENGTH]
    first = clock[JUMPED] != 0.0
    size = min(clock[NEXT], LONGEST * h)
    if first:  # as after the last jump
        size = clock[FRESH] if clock[FRESH] > 0.0 else 0.1 * h
    status = TOO_ROUGH
    if uphold != 0:
        call_uphold(uphold, model, data, work, 0.0, span[QN], span[VN])
    if closing != 0:
        failed = call_close(closing, problem, BEFORE_NEXT, anchor + begin, h)
        if failed != CONVERGED:
            return failed
    while size >= SHORTEST * h:
        here = anchor + begin
        until = next_switch(problem.loads, here, 2.0 * size)
        length = size
        if until < 2.0 * size:  # avoids a tiny step before a switch
            length = until if until <= size * (1.0 + 1e-9) else 0.5 * until
        status, error = attempt(problem, here, length, first)
        if status == CONVERGED and closing != 0 and error <= 1.0:
            status = call_close(closing, problem, AFTER_TRIAL, here + length, length)
        if status != CONVERGED:
            size = 0.25 * length
            for i in range(n):
                work.a[i] = 0.0  # those of a failed Newton iteration are no first guess
            work.counters[REJECTED] += 1
            continue
        worth = len(model.contact.node) > 0 and error <= 1.0 and length > SMALL * h
        if worth and made_energy(problem):
            status = MADE
            size = 0.5 * length
            work.counters[REJECTED] += 1
            continue
        # of order k + 1 in the length, k the order of the embedded method
        k = 1.0 / method.order
        if not error <= 1.0:
            status = TOO_ROUGH
            size = length * max(SHRINK, SAFETY * error ** (-k))
            work.counters[REJECTED] += 1
            continue
        error = max(error, 1e-6)
        factor = SAFETY * error ** (-0.7 * k)
        if clock[ERROR] > 0.0 and not first:
            factor *= clock[ERROR] ** (0.4 * k)
        factor = min(GROW, max(SHRINK, factor))
        if 1.0 <= factor <= WORTH:
            factor = 1.0
        # a step shortened for a switch says little about the length of the next
        clock[NEXT] = max(size, length * factor) if length < size else length * factor
        clock[ERROR] = error
        if first:
            clock[FRESH] = clock[NEXT]
        regripped = False
        if len(model.contact.node) > 0:
            # both tableaux end with their last stage
            last = (len(method.starter_embedded) if first else len(method.embedded)) - 1
            regripped = adopt(data.touch, last)
        clock[BEGIN], clock[LENGTH], clock[FIRST] = begin, length, 1.0 if first else 0.0
        for i in range(n):
            span[Q0, i], span[V0, i], span[A0, i] = span[QN, i], span[VN, i], span[A1, i]
            span[Q1, i], span[V1, i], span[A1, i] = work.q[i], work.v[i], work.a[i]
            span[QN, i], span[VN, i] = work.q[i], work.v[i]
        for c in range(4):
            booked[START, c], booked[END, c] = booked[END, c], booked[TRIAL, c]
        clock[JUMPED] = 1.0 if switches_at(problem.loads, here + length, length) else 0.0
        if regripped:  # friction jumps
            clock[JUMPED] = 1.0
        # a change of chart does not affect the polynomial of the present step
        if uphold != 0 and call_uphold(uphold, model, data, work, length, span[QN], span[VN]):
            clock[JUMPED] = 1.0
        work.measure[TIME_ERROR] += error * method.error
        work.counters[STEPS] += 1
        return CONVERGED
    return status


@kernel
def made_energy(problem):
    """Return whether the step just tried makes energy, in a scene with contact."""
    touch, booked, work = problem.data.touch, problem.work.booked, problem.work
    worked = booked[TRIAL, LOAD_WORK] - booked[END, LOAD_WORK]
    lost = booked[TRIAL, DISSIPATED] - booked[END, DISSIPATED]
    whole = abs(booked[TRIAL, LOAD_WORK]) + abs(booked[TRIAL, DISSIPATED])
    made = call_made(
        touch.call[4],
        problem.model,
        problem.data,
        problem.held.effort,
        work.span[QN],
        work.span[VN],
        touch.ends[1],
        work.q,
        work.v,
        touch.after,
        worked,
        lost,
        whole,
    )
    return not made <= 1.0


@unit
def attempt(problem, t, h, first):
    """Try a step of h in s from the end of the present one, at t.

    Return (CONVERGED or why not, its error over the permitted one). Its end is in Work.q, v, a and
    booked[TRIAL].
    """
    model, data, work, method = problem.model, problem.data, problem.work, problem.method
    span, booked, held, loads = work.span, work.booked, problem.held, problem.loads
    tableau = method.starter if first else method.tableau
    embedded = method.starter_embedded if first else method.embedded
    stages, n = len(embedded), len(work.a)
    q, v, goal = span[QN], span[VN], NEWTON * method.error / h
    stage_v, stage_a = work.stage_v, work.stage_a
    dissipated, worked = 0.0, 0.0
    for i in range(stages):
        diagonal = tableau[i, i] * h
        if diagonal == 0.0:  # the first stage of an ESDIRK method: the end of the last step
            for c in range(n):
                stage_v[i, c], stage_a[i, c] = v[c], span[A1, c]
            lost, power = booked[END, LOST], booked[END, POWER]
            if len(model.contact.node) > 0:
                explicit_stage(data.touch)
        else:
            for c in range(n):
                x, u = q[c], v[c]
                for j in range(i):
                    x += h * tableau[i, j] * stage_v[j, c]
                    u += h * tableau[i, j] * stage_a[j, c]
                work.start_v[c] = u
                work.start_q[c] = x + diagonal * u
            now = inside(t, h, tableau[i, stages])
            apply_loads(loads, held.tip, held.follows[0] != 0, now, 1.0, data)
            guess(work, tableau, i, h, first)
            if len(model.contact.node) > 0:
                begin_stage(data.touch, data.touch.ends, 1, tableau, i, h)
            status = call_stage(problem.calls[STAGE], problem, diagonal * diagonal, diagonal, goal)
            if status != CONVERGED:
                return status, 0.0
            if len(model.contact.node) > 0:
                end_stage(data.touch, i, diagonal)
            for c in range(n):
                stage_v[i, c], stage_a[i, c] = work.v[c], work.a[c]
            lost, power = damping_power(model, data, work.v), load_power(model, data)
        dissipated += h * tableau[stages, i] * lost
        worked += h * tableau[stages, i] * power
    if len(model.contact.node) > 0 and data.touch.alive[0] != 0:
        where = data.touch.call[3]
        dissipated += call_bristles(where, model, data, data.touch.ends[1])
        dissipated -= call_bristles(where, model, data, data.touch.after)
    booked[TRIAL, DISSIPATED] = booked[END, DISSIPATED] + dissipated
    booked[TRIAL, LOAD_WORK] = booked[END, LOAD_WORK] + worked
    booked[TRIAL, LOST], booked[TRIAL, POWER] = lost, power
    error, way = 0.0, 0.0
    for c in range(n):
        x, u = 0.0, 0.0
        for i in range(stages):
            x += embedded[i] * stage_v[i, c]
            u += embedded[i] * stage_a[i, c]
        error = max(error, h * model.weight[c] * max(abs(x), h * abs(u)))
        way = max(way, model.weight[c] * abs(work.q[c] - q[c]))
    return (CONVERGED if way <= REACH else TOO_FAR), error / method.error


@kernel
def guess(work, tableau, i, h, first):
    """Set work.a, the guess of stage i, on a parabola through the last three accelerations.

    These are those of earlier stages and, but for a first step, of the start of the last step.
    """
    stages = tableau.shape[0] - 1
    start = 0 if first else -1
    count = min(3, i - start)
    if count == 0:
        return
    t = tableau[i, stages]
    for c in range(len(work.a)):
        work.a[c] = 0.0
    for k in range(count):
        j = i - 1 - k
        share, tj = 1.0, node_of(work, tableau, j, h)
        for m in range(count):
            if m != k:
                tm = node_of(work, tableau, i - 1 - m, h)
                share *= (t - tm) / (tj - tm)
        known = work.span[A0] if j < 0 else work.stage_a[j]
        for c in range(len(work.a)):
            work.a[c] += share * known[c]


@kernel
def node_of(work, tableau, j, h):
    """Return when stage j of a step of h in s is, over h; −1: the start of the last step."""
    return -work.clock[LENGTH] / h if j < 0 else tableau[j, tableau.shape[0] - 1]


@kernel
def interpolate(work, state, target):
    """Set the state at a time in the present step, in s after the last jump."""
    clock, span, booked = work.clock, work.span, work.booked
    h = clock[LENGTH]
    x = (target - clock[BEGIN]) / h
    x2, x3, x4, x5 = x * x, x**3, x**4, x**5
    for i in range(len(state.q)):
        q, v, a = span[Q0, i], span[V0, i], span[A0, i]
        way, dv, a1 = span[Q1, i] - q - h * v, h * (span[V1, i] - v), h * h * span[A1, i]
        if clock[FIRST] != 0.0:
            c2, c3 = 6.0 * way - 3.0 * dv + 0.5 * a1, 5.0 * dv - 8.0 * way - a1
            c4, c5 = 0.5 * a1 - 2.0 * dv + 3.0 * way, 0.0
        else:
            c2 = 0.5 * h * h * a
            way, dv, a1 = way - c2, dv - 2.0 * c2, a1 - 2.0 * c2
            c3 = 10.0 * way - 4.0 * dv + 0.5 * a1
            c4 = -15.0 * way + 7.0 * dv - a1
            c5 = 6.0 * way - 3.0 * dv + 0.5 * a1
        state.q[i] = q + h * v * x + c2 * x2 + c3 * x3 + c4 * x4 + c5 * x5
        slope = 2.0 * c2 * x + 3.0 * c3 * x2 + 4.0 * c4 * x3 + 5.0 * c5 * x4
        state.v[i] = v + slope / h
    for c in range(2):
        old, more = booked[START, c], booked[END, c] - booked[START, c]
        early, late = h * booked[START, LOST + c], h * booked[END, LOST + c]
        if clock[FIRST] != 0.0:
            state.ledger[c] = old + more * (2.0 * x - x2) + late * (x2 - x)
        else:
            state.ledger[c] = (
                old + more * (3.0 * x2 - 2.0 * x3) + early * (x - 2.0 * x2 + x3) + late * (x3 - x2)
            )
