"""Wrenches on the nodes at a given time."""

from soft_sim_ros.core.backend.jit import bare, kernel, unit

from .actuators import actuator_loss
from .custom import custom_power
from .driven import drive_power, known_motions
from .fluid import fluid_loss, fluid_work
from .mass_damping import mass_damping_power
from .maxwell import branch_power
from .touch import touch_power


@unit
def schedule_factor(start, end, ramp, t):
    """Return the fraction of a load at time t in s (scene.Schedule.factor, the same law)."""
    if not (start <= t < end):
        return 0.0
    if ramp == 0.0:
        return 1.0
    return min(1.0, (t - start) / ramp, (end - t) / ramp)


@kernel
def slack(t, h):
    """Return the difference in s below which two times are equal: round-off of t, or h / 10⁹."""
    return 1e-9 * h + 1e-15 * abs(t)


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
def inside(t, h, c):
    """Return t + c h, kept off the ends of the step.

    A load that jumps at an end of the step must be evaluated on the side of the step.
    """
    near = 2.0 * slack(t, h)
    return min(max(t + h * c, t + near), t + h - near)


@unit
def apply_loads(loads, tip, tip_follows, t, share, data):
    """Fill data.dead, data.follower, data.driven and data.current at time t in s.

    Share times the scheduled loads and the tip wrench (6,).
    """
    tip = bare(tip)
    data.now[0], data.now[1] = t, share
    count = len(loads.follows)
    last = data.dead.shape[0] - 1
    acting = False
    for c in range(6):
        acting = acting or tip[c] != 0.0
    data.active[0] = 1 if acting and not tip_follows else 0
    data.active[1] = 1 if acting and tip_follows else 0
    for p in range(len(loads.node)):
        for c in range(6):
            data.dead[loads.node[p], c] = 0.0
            data.follower[loads.node[p], c] = 0.0
    for w in range(len(loads.push)):
        for c in range(6):
            data.dead[loads.push[w], c] = 0.0
            data.follower[loads.push[w], c] = 0.0
    for c in range(6):
        data.dead[last, c] = 0.0 if tip_follows else share * tip[c]
        data.follower[last, c] = share * tip[c] if tip_follows else 0.0
    for i in range(count):
        factor = share * schedule_factor(
            loads.schedule[i, 0], loads.schedule[i, 1], loads.schedule[i, 2], t
        )
        if factor == 0.0:
            continue
        target = data.follower if loads.follows[i] else data.dead
        data.active[1 if loads.follows[i] else 0] = 1
        for p in range(loads.ptr[i], loads.ptr[i + 1]):
            for c in range(6):
                target[loads.node[p], c] += factor * loads.wrench[p, c]
    for w in range(len(loads.push)):
        follows = data.live.follows[w]
        target = data.follower if follows else data.dead
        for c in range(6):
            if data.live.push[w, c] != 0.0:
                data.active[1 if follows else 0] = 1
                target[loads.push[w], c] += share * data.live.push[w, c]
    if len(loads.drives.column) > 0:
        known_motions(loads.drives, data.live.course, t, data.driven)
    if len(loads.current.column) > 0:
        known_motions(loads.current, data.live.course, t, data.current)


@kernel
def load_power(model, data):
    """Return the power in W of all node wrenches but weight, and of drives, at the last sweep."""
    total = drive_power(data) + custom_power(data) + fluid_work(data)
    if data.active[0] == 0 and data.active[1] == 0:
        return total
    for k in range(data.dead.shape[0]):
        for c in range(3):
            # body components of the dead wrench
            moment = data.follower[k, c]
            force = data.follower[k, c + 3]
            if data.active[0] != 0:
                for i in range(3):
                    moment += data.rotation[k, 3 * i + c] * data.dead[k, i]
                    force += data.rotation[k, 3 * i + c] * data.dead[k, i + 3]
            total += moment * data.eta[k, c] + force * data.eta[k, c + 3]
    return total


@kernel
def damping_power(model, data, v):
    """Return q̇ᵀ R q̇ in W with mass damping and losses of tendons, at the last sweep."""
    total = actuator_loss(model, data)
    for i in range(len(model.law_ptr) - 1):
        for e in range(model.law_ptr[i], model.law_ptr[i + 1]):
            total += v[i] * model.damping[e] * v[model.law_col[e]]
    total += fluid_loss(data)
    if len(model.contact.node) > 0:
        total += touch_power(data)
    return total + mass_damping_power(model, data) + branch_power(model, v)
