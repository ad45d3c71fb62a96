"""Many steps in one call.

Switching times of loads are hit exactly, and steps that fail are tried again in smaller ones.
"""

from soft_sim_ros.core.backend.jit import (
    call_close,
    call_made,
    call_step,
    call_uphold,
    kernel,
    unit,
)
from soft_sim_ros.core.terms.driven import bring
from soft_sim_ros.core.terms.forcing import next_switch, switches_at
from soft_sim_ros.core.terms.touch import BEFORE, SAVED, before_step, keep_back, put_back

from .newton import CONVERGED, MADE, TOO_FAR
from .problem import (
    ADAPTIVE,
    AFTER_PIECE,
    BEFORE_PIECE,
    CLOSE,
    DISSIPATED,
    EVALUATIONS,
    LOAD_WORK,
    REFUSED,
    STEP,
    UPHOLD,
    Q,
    V,
)

# A step is halved at most this many times, into at most this many pieces, before it is refused, so
# that a call always ends.
HALVINGS = 12
PIECES = 300
# and at most this many times because a contact makes energy: it is very little then
CUTS = 7
# No piece of a step may move the tip further than this, in arm lengths (or a hinge, in radians):
# Newton's method then has gone to another solution, or the step is far too long for the motion.
REACH = 1.0


@kernel
def too_far(model, before, q):
    """Return whether q is further from where the piece of the step began than REACH."""
    for i in range(len(q)):
        if not abs(q[i] - before[i]) * model.weight[i] <= REACH:
            return True
    return False


@kernel
def made_energy(problem, booked):
    """Return whether the last piece of a step made energy where something touched.

    booked : the ledger before it
    """
    touch, ledger, work = problem.data.touch, problem.state.ledger, problem.work
    worked, lost = ledger[LOAD_WORK] - booked[1], ledger[DISSIPATED] - booked[0]
    whole = abs(ledger[LOAD_WORK]) + abs(ledger[DISSIPATED])
    made = call_made(
        touch.call[4],
        problem.model,
        problem.data,
        problem.held.effort,
        work.before[Q],
        work.before[V],
        before_step(touch),
        problem.state.q,
        problem.state.v,
        touch.bristle[0],
        worked,
        lost,
        whole,
    )
    return not made <= 1.0


@unit
def fixed_step(problem, t, h):
    """Make one step of h in s from t, in pieces if need be.

    On failure nothing has changed but the scratch, and the reason is returned.
    """
    model, work, state, loads = problem.model, problem.work, problem.state, problem.loads
    data, uphold, closing = problem.data, problem.calls[UPHOLD], problem.calls[CLOSE]
    q, v, ledger = state.q, state.v, state.ledger
    n = len(q)
    for i in range(n):
        work.saved[Q, i], work.saved[V, i] = q[i], v[i]
    saved = (ledger[DISSIPATED], ledger[LOAD_WORK])
    touching = len(model.contact.node) > 0
    if touching:
        keep_back(data.touch, SAVED)
        data.touch.met[0] = 0
    done, size, halvings, pieces = 0.0, h, 0, 0
    while done < h * (1.0 - 1e-9):
        pieces += 1
        here = t + done
        if closing != 0:
            unmet = call_close(closing, problem, BEFORE_PIECE, here, h)
            if unmet != CONVERGED:
                for i in range(n):
                    q[i], v[i] = work.saved[Q, i], work.saved[V, i]
                ledger[DISSIPATED], ledger[LOAD_WORK] = saved
                return unmet
        for i in range(n):
            work.before[Q, i], work.before[V, i] = q[i], v[i]
        booked = (ledger[DISSIPATED], ledger[LOAD_WORK])
        if touching:
            keep_back(data.touch, BEFORE)
        if uphold != 0:
            call_uphold(uphold, model, data, work, 0.0, q, v)
        until = next_switch(loads, here, h - done)
        step = min(size, until)
        if h - done - step < 1e-9 * h:
            step = h - done
        status = call_step(problem.calls[STEP], problem, here, step)
        if status == CONVERGED and len(model.driven) > 0:
            bring(loads.drives, data.live.course, here + step, q, v)
        if status == CONVERGED and closing != 0:
            status = call_close(closing, problem, AFTER_PIECE, here + step, step)
        if status == CONVERGED and too_far(model, work.before[Q], q):
            status = TOO_FAR
        met = touching and status == CONVERGED and data.touch.met[0] != 0
        if met and halvings < CUTS and made_energy(problem, booked):
            status = MADE
        if status == CONVERGED:
            done += step
            if uphold != 0 and call_uphold(uphold, model, data, work, step, q, v):
                work.restart[0] = 1
            if switches_at(loads, t + done, h):
                work.restart[0] = 1
            if size < h:
                size *= 2.0
                halvings -= 1
            continue
        for i in range(n):
            q[i], v[i], work.a[i] = work.before[Q, i], work.before[V, i], 0.0
        ledger[DISSIPATED], ledger[LOAD_WORK] = booked
        if touching:
            put_back(data.touch, BEFORE)
        work.counters[REFUSED] += 1
        work.restart[0] = 1
        halvings += 1
        size = 0.5 * min(size, step)
        if halvings > HALVINGS or pieces > PIECES:
            for i in range(n):
                q[i], v[i] = work.saved[Q, i], work.saved[V, i]
            ledger[DISSIPATED], ledger[LOAD_WORK] = saved
            if touching:
                put_back(data.touch, SAVED)
            return status
    return CONVERGED


@kernel
def hand_over(given, live):
    """Copy what is commanded to where kernels look for it."""
    for w in range(len(given.follows)):
        live.follows[w] = given.follows[w]
        for c in range(6):
            live.push[w, c] = given.push[w, c]
    for d in range(len(given.course)):
        for c in range(len(given.course[d])):
            live.course[d, c] = given.course[d, c]


@unit
def advance(problem, step_ns, steps, most):
    """Make ``steps`` steps, fewer if they take more than ``most`` evaluations of the residual.

    Each is counted in State.steps as soon as it is made: state and time change together, whatever
    happens to the caller. Return the status of the step that failed, or CONVERGED.
    """
    data, held, made = problem.data, problem.held, problem.state.steps
    counters = problem.work.counters
    for c in range(3):
        data.gravity[c] = held.gravity[c]
    for i in range(len(held.effort)):
        data.effort[i] = held.effort[i]
    hand_over(held.live, data.live)
    h = step_ns * 1e-9
    last, enough = made[0] + steps, counters[EVALUATIONS] + most
    while made[0] < last:
        t = (made[0] * step_ns) * 1e-9
        if problem.method.kind == ADAPTIVE:
            status = call_step(problem.calls[STEP], problem, t, h)
        else:
            status = fixed_step(problem, t, h)
        if status != CONVERGED:
            return status
        made[0] += 1
        if counters[EVALUATIONS] >= enough:
            break
    return CONVERGED
