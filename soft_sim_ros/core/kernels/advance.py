"""Many steps in one call.

Load switches hit exactly, failed steps retried smaller, nothing accepted by hope.
"""

from .alpha import alpha_step
from .dirk import dirk_step
from .forcing import slack
from .jit import bare, call_uphold, kernel, unit
from .newton import CONVERGED, REFUSED, TOO_FAR

# A step is cut in half at most this many times, into at most this many pieces, before it is
# refused for good: nobody waits for ever.
HALVINGS = 12
PIECES = 300
# No piece of a step may move the tip further than this, in arm lengths (or a hinge, in radians):
# Newton's method then has gone to another solution, or the step is far too long for the motion.
REACH = 1.0


@kernel
def next_switch(loads, t, h):
    """Return the time from t to the first load switch inside (t, t + h), else h; ends excluded."""
    near = slack(t, h)
    for s in loads.switches:
        if near < s - t < h - near:
            return s - t
    return h


@kernel
def switches_at(loads, t, h):
    """Return whether a load switches at t, where a step of h ends."""
    near = slack(t, h)
    for s in loads.switches:
        if abs(s - t) <= near:
            return True
    return False


@kernel
def too_far(model, work, q):
    """Return whether q is further from where the piece of the step began than REACH."""
    for i in range(len(q)):
        if not abs(q[i] - work.before[0, i]) * model.weight[i] <= REACH:
            return True
    return False


@kernel
def safe_step(
    calls, model, loads, data, work, method, tip, tip_follows, tolerance, limit, t, h, q, v, ledger
):
    """Advance by exactly h in s; on failure nothing has changed and the reason is returned.

    method (tableau (s + 1, s + 1), rho): a tableau of one row means the generalised-α method with
    this rho.
    """
    tableau, rho = method
    n = len(q)
    for i in range(n):
        work.saved[0, i], work.saved[1, i], work.saved[2, i] = q[i], v[i], work.a[i]
    saved = (ledger[0], ledger[1])
    done, size, halvings, pieces = 0.0, h, 0, 0
    while done < h * (1.0 - 1e-9):
        pieces += 1
        here = t + done
        for i in range(n):
            work.before[0, i], work.before[1, i] = q[i], v[i]
        booked = (ledger[0], ledger[1])
        if calls[3] != 0:
            call_uphold(calls[3], model, data, work, 0.0, q, v)
        until = next_switch(loads, here, h - done)
        step = min(size, until)
        if h - done - step < 1e-9 * h:
            step = h - done
        if tableau.shape[0] > 1:
            status = dirk_step(
                calls,
                model,
                loads,
                data,
                work,
                tableau,
                tip,
                tip_follows,
                tolerance,
                limit,
                here,
                step,
                q,
                v,
                ledger,
            )
        else:
            status = alpha_step(
                calls,
                model,
                loads,
                data,
                work,
                rho,
                tip,
                tip_follows,
                tolerance,
                limit,
                here,
                step,
                q,
                v,
                ledger,
            )
        if status == CONVERGED and too_far(model, work, q):
            status = TOO_FAR
            for i in range(n):
                q[i], v[i] = work.before[0, i], work.before[1, i]
            ledger[0], ledger[1] = booked
        if status == CONVERGED:
            done += step
            if calls[3] != 0 and call_uphold(calls[3], model, data, work, step, q, v):
                work.restart[0] = 1
            if switches_at(loads, t + done, h):
                work.restart[0] = 1
            if size < h:
                size *= 2.0
                halvings -= 1
            continue
        work.counters[REFUSED] += 1
        halvings += 1
        size = 0.5 * min(size, step)
        for i in range(n):
            work.a[i] = 0.0
        work.restart[0] = 1
        if halvings > HALVINGS or pieces > PIECES:
            for i in range(n):
                q[i], v[i], work.a[i] = work.saved[0, i], work.saved[1, i], work.saved[2, i]
            ledger[0], ledger[1] = saved
            return status
    return CONVERGED


@unit
def advance(
    calls,
    model,
    loads,
    data,
    work,
    method,
    tip,
    tip_follows,
    tolerance,
    limit,
    start_ns,
    step_ns,
    steps,
    q,
    v,
    ledger,
):
    """Make up to ``steps`` steps from start_ns.

    Return (steps made, status of the one that failed or CONVERGED).
    """
    model, loads, data, work = bare(model), bare(loads), bare(data), bare(work)
    tip, q, v, ledger = bare(tip), bare(q), bare(v), bare(ledger)
    h = step_ns * 1e-9
    for s in range(steps):
        t = (start_ns + s * step_ns) * 1e-9
        status = safe_step(
            calls,
            model,
            loads,
            data,
            work,
            method,
            tip,
            tip_follows,
            tolerance,
            limit,
            t,
            h,
            q,
            v,
            ledger,
        )
        if status != CONVERGED:
            return s, status
    return steps, CONVERGED
