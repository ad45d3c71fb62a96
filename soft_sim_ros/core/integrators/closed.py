"""Steps of scenes with constraints: what Newton's method and the methods in time call for them.

Accelerations and multipliers are unknowns of every stage, which asks that *accelerations* obey the
constraints: then a method solves the ordinary differential equation on their manifold, with its
full order and its error estimate. What it is off the manifold after a step is of the size of its
error, and is taken back (``recursion/closing.py``), so nothing drifts.
"""

from soft_sim_ros.core.backend.jit import call_residual, call_tangent, kernel, unit
from soft_sim_ros.core.recursion.closing import close_factor, close_solve, meet, stop_short
from soft_sim_ros.core.recursion.elimination import factor
from soft_sim_ros.core.recursion.output import energies
from soft_sim_ros.core.recursion.rnea import kinematics, place, strains
from soft_sim_ros.core.terms.closures import TARGET, in_force, look_at_frames
from soft_sim_ros.core.terms.driven import hold_still

from .newton import CONVERGED, SINGULAR, UNMET
from .problem import (
    AFTER_TRIAL,
    BEFORE_NEXT,
    BEFORE_PIECE,
    CORRECT,
    CQ,
    DISSIPATED,
    END,
    FACTOR,
    LOAD_WORK,
    NO_FACTORS,
    QN,
    RESIDUAL,
    TANGENT,
    VN,
)

GAP = 1e-4  # of the length, or rad: further apart frames cannot be while a constraint is made


@unit
def close(problem, what, t, h):
    """Do one of these; return CONVERGED or why not. FACTOR: t is the ∂q/∂a of the stage."""
    model, data, work, state = problem.model, problem.data, problem.work, problem.state
    if what == FACTOR:
        return CONVERGED if close_factor(model, data, work.system, t) else SINGULAR
    if what == CORRECT:
        close_solve(model, data, work.system, work.residual)
        return CONVERGED
    if what == BEFORE_PIECE:
        return make_and_release(problem, t, h, state.q, state.v, state.ledger)
    if what == BEFORE_NEXT:
        return make_and_release(problem, t, h, work.span[QN], work.span[VN], work.booked[END])
    if what == AFTER_TRIAL:
        met = meet(model, data, work.system, work.q, work.v, work.zero)
    else:
        met = meet(model, data, work.system, state.q, state.v, work.zero)
    return CONVERGED if met else UNMET


@unit
def make_and_release(problem, t, h, q, v, ledger):
    """Let constraints act that do from t in s on, in a piece of a step of about h; v may jump.

    What that loses, and what drives that keep their rates give, goes into a ledger.
    """
    model, data, work = problem.model, problem.data, problem.work
    closures, closed = model.closures, data.closed
    changed, made = False, False
    for k in range(len(closures.node)):
        now = 1.0 if in_force(closures, closed.held, k, t, 1e-9 * h + 1e-15 * abs(t)) else 0.0
        if now != closed.on[k]:
            changed = True
            made = made or now > 0.0
    if not changed:
        return CONVERGED
    strains(model, data, q, v, work.zero)
    kinematics(model, data)
    place(model, data)
    look_at_frames(closures, data)
    if made:
        catch(problem, t, h)
        look_at_frames(closures, data)
    for k in range(len(closures.node)):
        now = 1.0 if in_force(closures, closed.held, k, t, 1e-9 * h + 1e-15 * abs(t)) else 0.0
        if now == closed.on[k]:
            continue
        for i in range(closures.ptr[k], closures.ptr[k + 1]):
            closed.multiplier[i] = 0.0
            length = closures.length[0] if closures.rule[i] < 2 else 1.0
            if now > 0.0 and not abs(closed.value[i]) <= GAP * length:
                return UNMET
    for k in range(len(closures.node)):
        now = in_force(closures, closed.held, k, t, 1e-9 * h + 1e-15 * abs(t))
        closed.on[k] = 1.0 if now else 0.0
    work.key[CQ] = NO_FACTORS
    if not made:
        return CONVERGED
    call_residual(problem.calls[RESIDUAL], model, data, q, v, work.zero, work.residual)
    call_tangent(problem.calls[TANGENT], model, data, (0.0, 0.0, 1.0), work.system)
    if len(model.driven) > 0:
        hold_still(model, work.system)
    if not factor(model, work.system) or not close_factor(model, data, work.system, 0.0):
        return SINGULAR
    before = 0.0
    if len(model.driven) > 0:
        before = energies(model, data, q, v, work.zero)[0]
    loss = stop_short(model, data, work.system, q, v, work.zero)
    if not loss >= 0.0:
        return SINGULAR
    ledger[DISSIPATED] += loss
    if len(model.driven) > 0:
        ledger[LOAD_WORK] += energies(model, data, q, v, work.zero)[0] - before + loss
    return CONVERGED if meet(model, data, work.system, q, v, work.zero) else UNMET


@kernel
def catch(problem, t, h):
    """Let constraints that are made where the frames are hold the second frame at the first."""
    model, closed = problem.model, problem.data.closed
    closures = model.closures
    for k in range(len(closures.node)):
        now = in_force(closures, closed.held, k, t, 1e-9 * h + 1e-15 * abs(t))
        if now and closed.on[k] == 0.0 and closures.catches[k] != 0:
            hold_here(closures, problem.data, k)


@kernel
def hold_here(closures, data, k):
    """Set the second frame of constraint k to where its first is."""
    closed = data.closed
    one, node = closed.frame[k, 0], closures.node[k, 1]
    turn, at = data.rotation[node], data.position[node]
    for i in range(3):
        spot = 0.0
        for c in range(3):
            spot += turn[3 * c + i] * (one[9 + c] - at[c])
            total = 0.0
            for d in range(3):
                total += turn[3 * d + i] * one[3 * d + c]
            closed.held[k, TARGET + 3 * i + c] = total
        closed.held[k, TARGET + 9 + i] = spot
