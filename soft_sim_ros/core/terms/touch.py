"""Bristles of friction through the stages of a step.

They are integrated like coordinates, behind these (and behind dashpots) in every array of a solver:
q holds their deflection, q̇ its rate, q̈ = 0. What a stage makes of them is found with its forces
(contact/force.py), outside of Newton's unknowns. Without shapes nothing here runs.
"""

from soft_sim_ros.core.backend.jit import kernel

CODE, WIDE = 3, 4  # model/contact.py
SPAN = 0


@kernel
def begin_touch(data, work, cv):
    """Give the bristles that a stage begins with to the forces; cv is ∂q̇/∂q̈ of the stage."""
    touch = data.touch
    touch.mode[SPAN] = cv
    stations, slots, _ = touch.start.shape
    at = len(work.q) - WIDE * stations * slots
    for e in range(stations):
        kept = 0
        for k in range(slots):
            for c in range(WIDE):
                # without what the rate at the end of the last step has put in
                value = work.start_q[at] - cv * work.start_v[at]
                if c == CODE:
                    value = float(round(value))
                touch.start[e, k, c] = value
                if value != 0.0:
                    kept = 1
                at += 1
        touch.kept[e] = kept


@kernel
def end_touch(data, work, cv):
    """Take over the bristles of a stage, and their rates."""
    touch = data.touch
    stations, slots, _ = touch.start.shape
    at = len(work.q) - WIDE * stations * slots
    for e in range(stations):
        for k in range(slots):
            for c in range(WIDE):
                start = touch.start[e, k, c]
                end = start if c == CODE else touch.after[e, k, c]
                work.q[at], work.v[at] = end, (end - start) / cv
                at += 1


@kernel
def settle_touch(data, q):
    """Put the bristles that the last stage of a step ended with into q.

    Return whether one sticks now that did not before, or does no more.
    """
    touch = data.touch
    stations, slots, _ = touch.start.shape
    at = len(q) - WIDE * stations * slots
    changed = False
    for e in range(stations):
        for k in range(slots):
            changed = changed or touch.after[e, k, CODE] != touch.start[e, k, CODE]
            for c in range(WIDE):
                q[at] = touch.after[e, k, c]
                at += 1
    return changed


@kernel
def touch_power(data):
    """Return the power in W that contact dissipates, at the last sweep."""
    return data.touch.power[0]
