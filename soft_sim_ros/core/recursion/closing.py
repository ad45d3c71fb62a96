"""Constraints in Newton's system: a small dense one beside the elimination of the forest.

Newton's matrix K₀ of the forest is solved at a cost linear in the blocks. With F nodes that
constraints push, their 6F columns Jᵀ and the motion (J; Z; Y) x that the blocks hand to their ends
(tangent.py), one correction x and the change δλ of the multipliers obey

    K₀ x + Jᵀ (A J x − w δλ) = −r,        L (J; Z; Y) x = −c,

c accelerations of the rows, w their wrenches, L and A their exact derivatives (terms/closures.py).
So x = −K₀⁻¹ r + K₀⁻¹ Jᵀ z with 6F unknowns z, and δλ comes from as many equations as there are
rows. Rows that others imply are left out: their multipliers are zero.

After a step, places and velocities are put back onto the constraints by wrenches on the same nodes,
K₀⁻¹ Jᵀ w μ: the shift that is least in the metric of the step.
"""

import numpy as np

from soft_sim_ros.core.algebra.linalg import lu_factor, lu_solve, row_dot
from soft_sim_ros.core.backend.jit import bare, kernel, unit
from soft_sim_ros.core.terms.closures import (
    TURN,
    bends,
    let_go,
    lever,
    look_at_frames,
    push_frames,
    senses,
)

from .elimination import before, rows, solve
from .rnea import coordinate_forces, kinematics, place, project, strains

# A row is left out if what others do not hold of it moves less than this, over what it moves …
DEPENDENT = 1e-10
# … or if it moves less than this, over the row that moves most.
STILL = 1e-13
# of the length, or rad; of the length per s, or rad/s: nearer than this a state meets its
# constraints, and further off than FAR it does not
NEAR, SLOW, FAR = 1e-12, 1e-10, 1e-10
MOST = 12  # corrections of a state


@unit
def closed_dynamics(model, data, q, v, a, r):
    """Fill r with the residual of ``inverse_dynamics``, the multipliers in data.closed acting."""
    q, v, a, r = bare(q), bare(v), bare(a), bare(r)
    for i in range(len(r)):
        r[i] = 0.0
    strains(model, data, q, v, a)
    kinematics(model, data)
    place(model, data)
    look_at_frames(model.closures, data)
    push_frames(model.closures, data)
    project(model, data, r)
    let_go(model.closures, data)
    coordinate_forces(model, data, q, v, r)


@unit
def sense(model, system, x, out):
    """Fill out (18F,) with (J; Z; Y) x of the sites."""
    x, out = bare(x), bare(out)
    site = model.closures.site
    out[:] = 0.0
    for f in range(len(site)):
        b = site[f, 1]
        while b >= 0:
            begin, end = model.block_col[b], model.block_col[b + 1]
            motion = rows(system, system.motion, 18, b)
            for c in range(18):
                total = 0.0
                for j in range(end - begin):
                    total += motion[c, j] * x[begin + j]
                out[18 * f + c] += total
            b = before(model, b)


@kernel
def times(a, b, out):
    """Fill out with the product of two matrices."""
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = 0.0
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            out[i, j] = total


@unit
def invert_independent(closures, on, matrix, inverse, kept):
    """Fill inverse (R, R) with that of the rows of a matrix (R, R) that no others imply.

    kept (R,) says which they are; the others have zeros. on (R,): rows that act. The first row of
    those with a pivot of a tenth of the largest is taken next, so which are left out does not hang
    on round-off. Return False if what is kept is singular.
    """
    matrix, inverse, kept, on = bare(matrix), bare(inverse), bare(kept), bare(on)
    count = matrix.shape[0]
    square = closures.length[0] * closures.length[0]
    largest = 0.0
    size = np.zeros(count)
    for i in range(count):
        kept[i] = 0.0
        size[i] = abs(matrix[i, i]) * (square if closures.rule[i] == TURN else 1.0) * on[i]
        largest = max(largest, size[i])
    inverse[:] = 0.0
    if not largest > 0.0:
        return count == 0 or largest == 0.0
    work, waits = np.zeros((count, count)), np.zeros(count)
    for i in range(count):
        waits[i] = 1.0 if size[i] > STILL * largest else 0.0
        for j in range(count):
            scale = np.sqrt(abs(matrix[i, i] * matrix[j, j]))
            work[i, j] = matrix[i, j] / scale if scale > 0.0 else 0.0
    found = 0
    for _ in range(count):
        most = 0.0
        for i in range(count):
            if waits[i] > 0.0:
                most = max(most, abs(work[i, i]))
        if not most > DEPENDENT:
            break
        p = 0
        while not (waits[p] > 0.0 and abs(work[p, p]) >= 0.1 * most):
            p += 1
        waits[p], kept[p] = 0.0, 1.0
        found += 1
        for i in range(count):
            if waits[i] > 0.0:
                factor = work[i, p] / work[p, p]
                for j in range(count):
                    work[i, j] -= factor * work[p, j]
    chosen, pivot = np.zeros(found, dtype=np.int64), np.zeros(found, dtype=np.int64)
    small, column = np.zeros((found, found)), np.zeros(found)
    at = 0
    for i in range(count):
        if kept[i] > 0.0:
            chosen[at] = i
            at += 1
    for i in range(found):
        for j in range(found):
            small[i, j] = matrix[chosen[i], chosen[j]]
    if not lu_factor(small, pivot):
        return False
    for j in range(found):
        column[:] = 0.0
        column[j] = 1.0
        lu_solve(small, pivot, column)
        for i in range(found):
            inverse[chosen[i], chosen[j]] = column[i]
    return True


@unit
def acting(closures, closed, out):
    """Fill out (R,) with 1 for rows that act, else 0."""
    out = bare(out)
    for k in range(len(closures.node)):
        for i in range(closures.ptr[k], closures.ptr[k + 1]):
            out[i] = closed.on[k]


@unit
def close_factor(model, data, system, a0):
    """Factor the small system, after ``factor`` of the tangent (a0, …) at the last residual."""
    closures, closed = model.closures, data.closed
    count, wide = len(closures.rule), 6 * len(closures.site)
    reach = bare(system.close_reach)
    for f in range(len(closures.site)):
        for c in range(6):
            x = reach[6 * f + c]
            x[:] = 0.0
            b = closures.site[f, 1]
            while b >= 0:
                begin, end = model.block_col[b], model.block_col[b + 1]
                motion = rows(system, system.motion, 18, b)
                for j in range(end - begin):
                    x[begin + j] = motion[c, j]
                b = before(model, b)
            solve(model, system, x)
    whole, seen = np.zeros((3 * wide, wide)), np.zeros(3 * wide)
    for s in range(wide):
        sense(model, system, reach[s], seen)
        for i in range(3 * wide):
            whole[i, s] = seen[i]
    for f in range(len(closures.site)):
        for c in range(6):
            for s in range(wide):
                system.close_comply[6 * f + c, s] = whole[18 * f + c, s]
    on = np.zeros(count)
    acting(closures, closed, on)
    bend, turned, pivot = np.zeros((wide, wide)), np.zeros((wide, wide)), np.zeros(wide, np.int64)
    bends(closures, data, bend)
    times(bend, system.close_comply, turned)
    for i in range(wide):
        for j in range(wide):
            turned[i, j] = a0 * turned[i, j] + (1.0 if i == j else 0.0)
    if not lu_factor(turned, pivot):
        return False
    arms, column = np.zeros((wide, count)), np.zeros(wide)
    lever(closures, data, arms)
    for j in range(count):
        for i in range(wide):
            column[i] = arms[i, j]
        lu_solve(turned, pivot, column)
        for i in range(wide):
            system.close_arms[i, j] = column[i]
    for j in range(wide):
        for i in range(wide):
            column[i] = -a0 * bend[i, j]
        lu_solve(turned, pivot, column)
        for i in range(wide):
            system.close_bend[i, j] = column[i]
    felt = system.close_sense
    senses(closures, data, a0, felt)
    first, small, more = np.zeros((count, wide)), np.zeros((count, count)), np.zeros((count, wide))
    times(felt, whole, first)
    times(first, system.close_arms, small)
    times(first, system.close_bend, more)
    for i in range(count):
        for f in range(len(closures.site)):
            for c in range(6):
                felt[i, 18 * f + c] += more[i, 6 * f + c]
    if not invert_independent(closures, on, small, system.close_inverse, system.close_kept):
        return False
    for i in range(count):
        if system.close_kept[i] == 0.0:
            closed.multiplier[i] = 0.0
    return True


@unit
def close_solve(model, data, system, x):
    """Turn x (≥ n,) = K₀⁻¹ r into the correction that heeds constraints; correct multipliers."""
    x = bare(x)
    closed, site = data.closed, model.closures.site
    count, wide = len(model.closures.rule), 6 * len(site)
    seen, by, z = np.zeros(3 * wide), np.zeros(count), np.zeros(wide)
    sense(model, system, x, seen)
    for i in range(count):
        by[i] = row_dot(system.close_sense[i], seen, 0, 3 * wide) - closed.acceleration[i]
    for i in range(wide):
        for f in range(len(site)):
            for c in range(6):
                z[i] -= system.close_bend[i, 6 * f + c] * seen[18 * f + c]
    for j in range(count):
        change = row_dot(system.close_inverse[j], by, 0, count)
        closed.multiplier[j] += change
        for i in range(wide):
            z[i] += system.close_arms[i, j] * change
    add_reach(model, system, z, -1.0, x)


@kernel
def add_reach(model, system, z, factor, x):
    """Add the motion of wrenches z (6F,) on the sites to x, times a factor."""
    n = model.block_col[len(model.block_col) - 1]
    for s in range(len(z)):
        push = factor * z[s]
        if push != 0.0:
            for i in range(n):
                x[i] += push * system.close_reach[s, i]


@kernel
def farthest(closures, on, values):
    """Return the largest of values (R,) of rows that act, over the length (turns as they are)."""
    most = 0.0
    for i in range(len(values)):
        size = abs(values[i]) / (1.0 if closures.rule[i] == TURN else closures.length[0])
        if on[i] > 0.0 and not size <= most:
            most = size
    return most


@unit
def meet(model, data, system, q, v, zero):
    """Put q and v back onto the constraints; return whether they are met. zero: (n,) zeros.

    By the last factors, so the cost is some sweeps outwards.
    """
    q, v, zero = bare(q), bare(v), bare(zero)
    closures, closed = model.closures, data.closed
    count, wide = len(closures.rule), 6 * len(closures.site)
    on = np.zeros(count)
    acting(closures, closed, on)
    arms, moved = np.zeros((wide, count)), np.zeros((wide, count))
    small, inverse, kept = np.zeros((count, count)), np.zeros((count, count)), np.zeros(count)
    shift, push = np.zeros(wide), np.zeros(wide)
    best = np.inf
    for _ in range(MOST):
        strains(model, data, q, v, zero)
        kinematics(model, data)
        place(model, data)
        look_at_frames(closures, data)
        off, fast = farthest(closures, on, closed.value), farthest(closures, on, closed.speed)
        if off <= NEAR and fast <= SLOW:
            return True
        if not off < 1.0:
            return False
        # rows that others imply are not corrected, and round-off may be larger than NEAR
        if off <= FAR and fast <= 100.0 * SLOW and not off + fast < 0.5 * best:
            return True
        best = off + fast
        lever(closures, data, arms)
        times(system.close_comply, arms, moved)
        for i in range(count):
            for j in range(count):
                small[i, j] = 0.0
                for s in range(wide):
                    small[i, j] += arms[s, i] * moved[s, j]
        if not invert_independent(closures, on, small, inverse, kept):
            return False
        shift[:], push[:] = 0.0, 0.0
        for j in range(count):
            way, change = 0.0, 0.0
            for i in range(count):
                way -= inverse[j, i] * closed.value[i] * on[i]
                change -= inverse[j, i] * closed.speed[i] * on[i]
            for s in range(wide):
                shift[s] += arms[s, j] * way
                push[s] += arms[s, j] * change
        add_reach(model, system, shift, 1.0, q)
        add_reach(model, system, push, 1.0, v)
    return off <= FAR


@unit
def stop_short(model, data, system, q, v, zero):
    """Give v (n,) the jump by which bodies stop at constraints that are made; return its loss in J.

    The factors are those of the mass matrix.
    """
    q, v, zero = bare(q), bare(v), bare(zero)
    closures, closed = model.closures, data.closed
    count, wide = len(closures.rule), 6 * len(closures.site)
    on, loss = np.zeros(count), 0.0
    acting(closures, closed, on)
    arms, moved = np.zeros((wide, count)), np.zeros((wide, count))
    small, inverse, kept = np.zeros((count, count)), np.zeros((count, count)), np.zeros(count)
    strains(model, data, q, v, zero)
    kinematics(model, data)
    place(model, data)
    look_at_frames(closures, data)
    lever(closures, data, arms)
    times(system.close_comply, arms, moved)
    for i in range(count):
        for j in range(count):
            for s in range(wide):
                small[i, j] += arms[s, i] * moved[s, j]
    if not invert_independent(closures, on, small, inverse, kept):
        return np.nan
    push = np.zeros(wide)
    for j in range(count):
        impulse = 0.0
        for i in range(count):
            impulse -= inverse[j, i] * closed.speed[i] * on[i]
        loss -= 0.5 * impulse * closed.speed[j]
        for s in range(wide):
            push[s] += arms[s, j] * impulse
    add_reach(model, system, push, 1.0, v)
    return loss
