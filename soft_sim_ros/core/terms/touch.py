"""Bristles of friction through the stages of a step.

They are integrated like coordinates, by the same tableau, but outside of Newton's unknowns: what a
stage makes of them is found with its forces (contact/force.py). Methods that use them end a step
with its last stage. While nothing touches they are all zero, ``alive`` says so, and nothing is
done. Without shapes nothing here runs.
"""

from soft_sim_ros.core.backend.jit import kernel

CODE, WIDE = 3, 4  # model/contact.py
SPAN = 0
# Touch.alive: now, and when the rows of Touch.kept_back were written
NOW, SAVED, BEFORE = 0, 1, 2
# rows of Touch.ends
FIRST, LAST = 0, 1


@kernel
def first_stage(touch, base, base_row):
    """Give a stage the bristles that a step begins with, to which earlier stages are added."""
    stations, slots, _ = touch.start.shape
    for e in range(stations):
        kept = 0
        for k in range(slots):
            for c in range(WIDE):
                value = base[base_row, e, k, c]
                touch.start[e, k, c] = value
                if value != 0.0:
                    kept = 1
        touch.kept[e] = kept


@kernel
def begin_stage(touch, base, row, tableau, i, h):
    """Give stage i of a step of h in s the bristles that it begins with; base[row]: of the step."""
    if touch.alive[NOW] == 0:
        return
    first_stage(touch, base, row)
    stations, slots, _ = touch.start.shape
    for j in range(i):
        part = h * tableau[i, j]
        for e in range(stations):
            for k in range(slots):
                for c in range(CODE):
                    more = part * touch.rates[j, e, k, c]
                    touch.start[e, k, c] += more
                    if more != 0.0:
                        touch.kept[e] = 1


@kernel
def end_stage(touch, i, span):
    """Note the rates of the bristles in stage i, in which they could move for span in s."""
    if touch.pattern[0] != 0.0:
        touch.met[0] = 1
    if touch.alive[NOW] == 0:
        if touch.pattern[0] == 0.0:
            return
        touch.alive[NOW] = 1
        touch.rates[:] = 0.0
    stations, slots, _ = touch.start.shape
    for e in range(stations):
        for k in range(slots):
            for c in range(CODE):
                rate = (touch.after[e, k, c] - touch.start[e, k, c]) / span
                touch.rates[i, e, k, c] = rate


@kernel
def explicit_stage(touch):
    """Let the first stage of a step be the end of the last one."""
    if touch.alive[NOW] == 0:
        return
    stations, slots, _ = touch.start.shape
    for e in range(stations):
        for k in range(slots):
            for c in range(CODE):
                touch.rates[0, e, k, c] = touch.final[e, k, c]


@kernel
def take_over(touch, out, row):
    """Put the bristles that the last stage of a step ended with into out[row].

    Return whether one sticks now that did not before, or does no more.
    """
    if touch.alive[NOW] == 0:
        return False
    stations, slots, _ = touch.start.shape
    changed, any_left = False, 0
    for e in range(stations):
        for k in range(slots):
            changed = changed or touch.after[e, k, CODE] != touch.start[e, k, CODE]
            for c in range(WIDE):
                value = touch.after[e, k, c]
                out[row, e, k, c] = value
                if value != 0.0:
                    any_left = 1
    if any_left == 0 and touch.pattern[0] == 0.0:
        lull(touch)
    return changed


@kernel
def lull(touch):
    """Note that nothing touches any more."""
    touch.alive[NOW] = 0
    touch.start[:], touch.kept[:] = 0.0, 0
    touch.ends[:], touch.final[:] = 0.0, 0.0


@kernel
def keep_back(touch, row):
    """Keep the bristles of the state, to be put back if the step is refused."""
    touch.alive[row] = touch.alive[NOW]
    if touch.alive[NOW] != 0:
        touch.kept_back[row - 1] = touch.bristle[0]


@kernel
def put_back(touch, row):
    """Put back what was kept."""
    if touch.alive[row] == 0:
        touch.bristle[:] = 0.0
        lull(touch)
    else:
        touch.alive[NOW] = 1
        touch.bristle[0] = touch.kept_back[row - 1]


@kernel
def before_step(touch):
    """Return the bristles (P, K, 4) that a piece of a step began with, from ``keep_back``."""
    if touch.alive[BEFORE] == 0:
        touch.kept_back[BEFORE - 1] = 0.0
    return touch.kept_back[BEFORE - 1]


@kernel
def adopt(touch, last):
    """Let the present step of the adaptive method be the one just made, of ``last`` + 1 stages."""
    if touch.alive[NOW] == 0:
        return False
    touch.ends[FIRST] = touch.ends[LAST]
    touch.final[:] = touch.rates[last]
    return take_over(touch, touch.ends, LAST)


@kernel
def between(touch, x):
    """Set the bristles of the state at a part x of the present step of the adaptive method."""
    stations, slots, _ = touch.start.shape
    for e in range(stations):
        for k in range(slots):
            for c in range(CODE):
                early, late = touch.ends[FIRST, e, k, c], touch.ends[LAST, e, k, c]
                touch.bristle[0, e, k, c] = early + x * (late - early)
            code = touch.ends[LAST if x >= 1.0 else FIRST, e, k, CODE]
            touch.bristle[0, e, k, CODE] = code


@kernel
def touch_power(data):
    """Return the power in W that contact dissipates, at the last sweep."""
    return data.touch.power[0]
