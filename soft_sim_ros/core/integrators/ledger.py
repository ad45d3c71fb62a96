"""The energy ledger: stored energy, work done on the arm, energy dissipated."""

import math

from soft_sim_ros.core.backend.jit import bare, kernel, unit
from soft_sim_ros.core.recursion.output import energies
from soft_sim_ros.core.recursion.rnea import strains
from soft_sim_ros.core.terms.actuators import port_motion, tendon_energy

from .problem import (
    ACTUATOR_WORK,
    BOOKED,
    DISSIPATED,
    ELASTIC,
    GRAVITY,
    KINETIC,
    LOAD_WORK,
    REFERENCE,
)


@kernel
def stock(model, data, held, state, q, v):
    """Return kinetic, elastic and gravity energy, and the work of the actuators up to q, in J.

    The efforts have been constant since State.settled, so their work is effort times displacement,
    exactly.
    """
    kinetic, elastic, weight = energies(model, data, q, v, v)
    port_motion(model, data, q, v, state.position, state.rate, state.acting)
    return kinetic, elastic, weight, actuator_work(model, held, state)


@kernel
def actuator_work(model, held, state):
    """Return the work of the actuators in J up to the port positions in ``state``."""
    work = state.account[BOOKED]
    for i in range(len(held.effort)):
        if model.length_control[i, 0] == 0.0:  # a commanded length that is held does no work
            work += held.effort[i] * (state.position[i] - state.settled[i])
    return work


@kernel
def residual(state, stored, work, ledger):
    """Return the residual of the energy balance in J."""
    put_in = work + ledger[LOAD_WORK] - ledger[DISSIPATED]
    return stored - state.account[REFERENCE] - put_in


@unit
def take_stock(problem):
    """Bring State.account, position, rate and acting up to the present state."""
    data, held, state = problem.data, problem.held, problem.state
    for c in range(3):
        data.gravity[c] = held.gravity[c]
    for i in range(len(held.effort)):
        data.effort[i] = held.effort[i]
    kinetic, elastic, weight, work = stock(problem.model, data, held, state, state.q, state.v)
    state.account[KINETIC], state.account[ELASTIC] = kinetic, elastic
    state.account[GRAVITY], state.account[ACTUATOR_WORK] = weight, work


@unit
def hold(problem, efforts):
    """Hold efforts (A,) from the present state on; return False if they are not finite.

    The work of those held so far is booked: exactly, since they were constant.
    """
    efforts = bare(efforts)
    model, data, held, state = problem.model, problem.data, problem.held, problem.state
    same = True
    for i in range(len(efforts)):
        if not math.isfinite(efforts[i]):
            return False
        same = same and efforts[i] == held.effort[i]
    if same:
        return True
    for i in range(len(efforts)):
        data.effort[i] = held.effort[i]
    if len(model.tendon_seg) > 0:
        strains(model, data, state.q, state.v, state.v)
    port_motion(model, data, state.q, state.v, state.position, state.rate, state.acting)
    state.account[BOOKED] = actuator_work(model, held, state)
    stored = tendon_energy(model, data)
    for i in range(len(efforts)):
        state.settled[i] = state.position[i]
        held.effort[i] = data.effort[i] = efforts[i]
    # a jump of a commanded length stretches the tendon
    state.account[BOOKED] += tendon_energy(model, data) - stored
    problem.work.restart[0] = 1
    return True
