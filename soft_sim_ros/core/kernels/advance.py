"""Many steps in one call.

Load switches hit exactly, failed steps retried smaller, nothing accepted by hope.
"""

from .alpha import alpha_step
from .dirk import dirk_step
from .jit import kernel
from .newton import CONVERGED, REFUSED

# A step is cut in half at most this many times before it is refused for good.
HALVINGS = 12


@kernel
def next_switch(loads, t, h):
    """Return the time from t to the first load switch strictly inside (t, t + h), else h."""
    for s in loads.switches:
        if s > t + 1e-9 * h and s < t + h * (1.0 - 1e-9):
            return s - t
    return h


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
    done, size, halvings = 0.0, h, 0
    while done < h * (1.0 - 1e-9):
        here = t + done
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
        if status == CONVERGED:
            done += step
            if step == until and done < h * (1.0 - 1e-9):
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
        if halvings > HALVINGS:
            for i in range(n):
                q[i], v[i], work.a[i] = work.saved[0, i], work.saved[1, i], work.saved[2, i]
            ledger[0], ledger[1] = saved
            return status
    return CONVERGED


@kernel
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
