"""The energy ledger: what is stored, and what came in and went out."""

from .actuators import port_motion
from .jit import kernel, unit
from .output import energies
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

    The efforts have been constant since State.settled, so their work is effort times way, exactly.
    """
    kinetic, elastic, weight = energies(model, data, q, v, v)
    port_motion(model, data, q, v, state.position, state.rate, state.acting)
    work = state.account[BOOKED]
    for i in range(len(held.effort)):
        if model.winch[i, 0] == 0.0:  # a winch that holds a length does no work
            work += held.effort[i] * (state.position[i] - state.settled[i])
    return kinetic, elastic, weight, work


@kernel
def residual(state, stored, work, ledger):
    """Return the energy in J that is there and should not be."""
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
