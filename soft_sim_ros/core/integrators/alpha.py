"""One step of the generalised-α method of Chung and Hulbert, in the form of Arnold and Brüls."""

from soft_sim_ros.core.backend.jit import call_stage, unit
from soft_sim_ros.core.terms.forcing import apply_loads, damping_power, inside, load_power

from .newton import CONVERGED
from .predictor import judge, predict, remember
from .problem import DISSIPATED, END, LOAD_WORK, POWER, STAGE, STEPS

# Work.span: the acceleration that the method carries, and that of the equation of motion
ALGORITHMIC, TRUE = 0, 1


@unit
def alpha_step(problem, t, h):
    """Advance by h in s from t; method.rho ∈ [0, 1] is the spectral radius at infinite frequency.

    The method remembers an acceleration, ALGORITHMIC and TRUE. Where an input jumped these are that
    of one implicit stage ahead: the exact one, M q̈ = −r, would ring on in every stiff strain.
    Dissipation is booked with the mean velocity of the step, so ringing is not counted.
    """
    model, data, work, state = problem.model, problem.data, problem.work, problem.state
    held, calls, goal = problem.held, problem.calls, problem.method.tolerance
    q, v, rho = state.q, state.v, problem.method.rho
    n = len(q)
    am, af = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 - am + af
    beta = 0.25 * (1.0 - am + af) ** 2
    share = (1.0 - af) / (1.0 - am)
    cq, cv = h * h * beta * share, h * gamma * share
    algorithmic, true = work.span[ALGORITHMIC], work.span[TRUE]
    apply_loads(problem.loads, held.tip, held.follows[0] != 0, inside(t, h, 1.0), 1.0, data)
    fresh = work.restart[0] != 0
    if fresh:
        for i in range(n):
            work.start_q[i], work.start_v[i] = q[i] + cv * v[i], v[i]
        status = call_stage(calls[STAGE], problem, cq, cv, goal)
        if status != CONVERGED:
            return status
        for i in range(n):
            algorithmic[i] = true[i] = work.a[i]
    for i in range(n):
        old = algorithmic[i]
        carried = (af * true[i] - am * old) / (1.0 - am)
        work.start_q[i] = q[i] + h * v[i] + h * h * ((0.5 - beta) * old + beta * carried)
        work.start_v[i] = v[i] + h * ((1.0 - gamma) * old + gamma * carried)
    predict(work, 0, h, 1.0)
    status = call_stage(calls[STAGE], problem, cq, cv, goal)
    if status != CONVERGED:
        return status
    judge(model, work, 0)
    for i in range(n):
        work.start_v[i] = (work.q[i] - q[i]) / h
        carried = (af * true[i] - am * algorithmic[i]) / (1.0 - am)
        algorithmic[i] = share * work.a[i] + carried
        true[i] = work.stage_a[0, i] = work.a[i]
        q[i], v[i] = work.q[i], work.v[i]
    state.ledger[DISSIPATED] += h * damping_power(model, data, work.start_v)
    power = load_power(model, data)
    before = power if fresh else work.booked[END, POWER]
    state.ledger[LOAD_WORK] += 0.5 * h * (before + power)
    work.booked[END, POWER] = power
    remember(work, h)
    work.counters[STEPS] += 1
    return CONVERGED
