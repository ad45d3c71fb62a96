"""One step of the generalised-α method of Chung and Hulbert, in the form of Arnold and Brüls."""

from .dirk import DISSIPATED, LOAD_WORK
from .forcing import apply_loads, damping_power, inside, load_power
from .jit import call_stage, kernel
from .newton import CONVERGED, STEPS


@kernel
def alpha_step(
    calls, model, loads, data, work, rho, tip, tip_follows, tolerance, limit, t, h, q, v, ledger
):
    """Advance q, v by h in s from t; rho ∈ [0, 1]: spectral radius at infinite frequency.

    The method remembers an acceleration; where an input jumped (work.restart), it is that of one
    backward Euler step: the exact one, M q̈ = −r, would ring on in every stiff strain. Dissipation
    is booked with the mean velocity of the step, so ringing is not counted.
    """
    n = len(q)
    apply_loads(loads, tip, tip_follows, inside(t, h, 1.0), 1.0, data)
    if work.restart[0] != 0:
        for i in range(n):
            work.start_q[i], work.start_v[i] = q[i] + h * v[i], v[i]
        status = call_stage(calls[2], calls, model, data, work, h * h, h, tolerance, limit)
        if status != CONVERGED:
            return status
        for i in range(n):
            work.memory[0, i] = work.memory[1, i] = work.a[i]
    am, af = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 - am + af
    beta = 0.25 * (1.0 - am + af) ** 2
    share = (1.0 - af) / (1.0 - am)
    for i in range(n):
        old = work.memory[0, i]
        carried = (af * work.memory[1, i] - am * old) / (1.0 - am)
        work.start_q[i] = q[i] + h * v[i] + h * h * ((0.5 - beta) * old + beta * carried)
        work.start_v[i] = v[i] + h * ((1.0 - gamma) * old + gamma * carried)
    cq, cv = h * h * beta * share, h * gamma * share
    status = call_stage(calls[2], calls, model, data, work, cq, cv, tolerance, limit)
    if status != CONVERGED:
        return status
    for i in range(n):
        work.start_v[i] = (work.q[i] - q[i]) / h
    ledger[DISSIPATED] += h * damping_power(model, data, work.start_v)
    power = load_power(model, data)
    before = power if work.restart[0] != 0 else work.last[0]
    ledger[LOAD_WORK] += 0.5 * h * (before + power)
    work.last[0] = power
    for i in range(n):
        carried = af * work.memory[1, i] - am * work.memory[0, i]
        work.memory[0, i] = share * work.a[i] + carried / (1.0 - am)
        change = work.a[i] - work.memory[1, i]
        work.memory[1, i] = work.a[i]
        # guess for the next step, on a line through the last two
        work.a[i] += change
        q[i], v[i] = work.q[i], work.v[i]
    work.restart[0] = 0
    work.counters[STEPS] += 1
    return CONVERGED
