"""Contact of bodies with one another: equal and opposite wrenches on their nodes, stored energy.

A station of one body presses on a cell of another by the law of law.py. Both forces act at one
point, on the line from the cell to the station, so momentum and angular momentum stay what they
are. Bristles of friction turn with the body that is pressed upon: they are kept along the axes of
the node that their cell begins at. These units are called by address (backend/late.py).
"""

import math

from soft_sim_ros.core.algebra.dual import (
    add,
    apply,
    apply_t,
    cross,
    dot,
    load_mat,
    load_vec,
    scale,
    store_vec,
    sub,
)
from soft_sim_ros.core.backend.jit import kernel, unit
from soft_sim_ros.core.model.contact import (
    ACROSS,
    CODE,
    KINETIC,
    PRESENT,
    SPAN,
    STATIC,
    TIME,
    WIDE,
)
from soft_sim_ros.core.model.pairs import (
    CURVE,
    GAP,
    KIN,
    NORMAL,
    POINT,
    PULL,
    PUSH,
    SLIDE,
    SOURCE,
    STICK,
    STICKS,
    TARGET,
)

from .law import along, bristle, gripped, pushed, weighed
from .nearby import MANY, clear_of, look_for_near, put_in_balls
from .places import cubic, gap_of, pair_motion, station_place

ZERO = (0.0, 0.0, 0.0)
NO_LENGTH = 1e-30  # m: a bristle that is deflected by less is free
REPEAT = 8388593.0  # as in force.py
# arc length over the sum of both radii, along one rod: what is nearer cannot touch without bending
# to the radius of the rod, and is left out
NEIGHBOUR = 0.5 * math.pi


@kernel
def home_of(code):
    """Return the cell that a bristle is at home on, by its code; −1: none."""
    return int(code) // 2 - 1


@kernel
def pair_slot(model, touch, row, e, taken):
    """Return the bristle of a row that is nearest to cell e, or one that is free; −1: none."""
    body = model.pairs.body
    best, found = 1 << 40, -1
    for k in range(model.pairs.slots[0]):
        home = home_of(touch.start[row, k, CODE])
        ours = home >= 0 and (taken >> k) & 1 == 0 and body[home] == body[e]
        if ours and abs(home - e) < best:
            best, found = abs(home - e), k
    if found >= 0:
        return found
    for k in range(model.pairs.slots[0]):
        if touch.start[row, k, CODE] == 0.0 and (taken >> k) & 1 == 0:
            return k
    return -1


@kernel
def other_side(model, data, q, e, x, n, t, k):
    """Return arm, velocity, spin of node k (0, 1) of cell e, pressed on by station q, and shares.

    x : centre of the station; n: normal; t: where on the cell
    """
    pairs = model.pairs
    node = pairs.node[e, k]
    if pairs.kind[e] == CURVE:
        h, length = cubic(t), pairs.size[e, 0]
        w, s = (h[0], h[2]) if k == 0 else (h[1], h[3])
        a = 1.0 - t if k == 0 else t
        b, _, u, omega = pair_motion(w, a, (s * length, 0.0, 0.0), data, node)
        return b, u, omega, w, a
    if k == 1:
        return ZERO, ZERO, ZERO, 0.0, 0.0
    if pairs.kind[e] == STICK:
        p0, p1 = load_vec(pairs.centre[e]), load_vec(pairs.far[e])
        arm = add(p0, scale(t, sub(p1, p0)))
        b, _, u, omega = pair_motion(1.0, 1.0, arm, data, node)
        return b, u, omega, 1.0, 1.0
    rotation = load_mat(data.rotation[node])
    b = sub(sub(x, scale(pairs.radius[q], n)), load_vec(data.position[node]))
    omega = apply(rotation, load_vec(data.eta[node]))
    u = add(apply(rotation, load_vec(data.eta[node, 3:])), cross(omega, b))
    return b, u, omega, 1.0, 0.0


@kernel
def levers(model, q, e, gap, t):
    """Return the distance of the skeletons of station q and cell e, and the station's part of it.

    A shape has no skeleton: all of it is the station's.
    """
    pairs = model.pairs
    radius = pairs.radius[q]
    if pairs.kind[e] != CURVE and pairs.kind[e] != STICK:
        return radius, 1.0
    h, taper = cubic(t), pairs.taper[e]
    other = h[0] * taper[0] + h[1] * taper[1] + h[2] * taper[2] + h[3] * taper[3]
    return gap + radius + other, radius / (radius + 0.5 * (taper[0] + taper[1]))


@kernel
def station_axis(model, data, q):
    """Return the axis of the rod at station q, that of its nearer node, and which that is."""
    pairs = model.pairs
    k = 0 if pairs.weight[q, 2] >= pairs.weight[q, 3] else 1
    r = data.rotation[pairs.node[pairs.cell[q], k]]
    return (r[0], r[3], r[6]), k


@kernel
def push_node(data, node, moment, force, sign):
    """Subtract a wrench along base axes, times a sign, from the wrench of a node."""
    rotation = load_mat(data.rotation[node])
    moment, force = apply_t(rotation, moment), apply_t(rotation, force)
    for c in range(3):
        data.wrench[node, c] -= sign * moment[c]
        data.wrench[node, 3 + c] -= sign * force[c]


@unit
def press(model, data, g, e, kin):
    """Let the stations of cell g press on cell e; add to power and pattern, note what touches."""
    pairs, touch, meet = model.pairs, data.touch, data.meet
    law = pairs.law[pairs.group[g], pairs.group[e]]
    span = touch.mode[SPAN]
    friction = pairs.slots[0] > 0 and span >= 0.0 and law[KINETIC] > 0.0
    away, room = load_vec(meet.ball[e]), meet.ball[e, 3]
    for q in range(pairs.ptr[g], pairs.ptr[g + 1]):
        x, radius, share = station_place(model, data, q), pairs.radius[q], pairs.share[q]
        if room >= 0.0:
            d, far = sub(x, away), radius + room
            if dot(d, d) > far * far:
                continue
        gap, n, t = gap_of(model, data, e, x, radius)
        if not (gap < 0.0 and t >= 0.0):
            continue
        size, part = levers(model, q, e, gap, t)
        if kin != 0:
            arc = pairs.reach[e, 0] + t * (pairs.reach[e, 1] - pairs.reach[e, 0])
            if abs(pairs.arc[q] - arc) < NEIGHBOUR * (size - gap):
                continue
        hit = meet.counts[1]
        if hit == len(meet.hit):  # no step is accepted with it
            data.wrench[0, 0] = data.wrench[pairs.node[g, 0], 0] = math.nan
            return
        meet.counts[1] = hit + 1
        one, two = pairs.node[g, 0], pairs.node[g, 1]
        w1, w2, a1, a2 = load_four(pairs.weight[q])
        b1, _, u1, s1 = pair_motion(w1, a1, load_vec(pairs.arm[q]), data, one)
        b2, u2, s2 = ZERO, ZERO, ZERO
        if two != one:
            b2, _, u2, s2 = pair_motion(w2, a2, load_vec(pairs.arm[q, 3:]), data, two)
        b3, u3, s3, w3, a3 = other_side(model, data, q, e, x, n, t, 0)
        b4, u4, s4, w4, a4 = other_side(model, data, q, e, x, n, t, 1)
        speed = sub(add(u1, u2), add(u3, u4))
        omega = add(scale(part, add(s1, s2)), scale(1.0 - part, add(s3, s4)))
        push, stiff, _, factor, _ = pushed(law, share, radius, n, -gap, speed)
        touch.power[0] -= (push - stiff) * dot(n, speed)
        total, pull, sticks, slot = scale(push, n), ZERO, False, -1
        axis, _ = station_axis(model, data, q)
        row = len(model.contact.node) + q
        seen = 1.0
        if friction:
            slot = pair_slot(model, touch, row, e, meet.taken[q])
        if slot >= 0:
            meet.taken[q] |= 1 << slot
            code = int(touch.start[row, slot, CODE])
            home = home_of(code) if code != 0 else e
            turn = load_mat(data.rotation[pairs.node[home, 0]])
            start = apply(turn, load_vec(touch.start[row, slot]))
            held, w, grip, _ = gripped(law, share, size, touch, n, omega, speed, axis, start)
            hold = math.sqrt(dot(grip, grip))
            most = (law[STATIC] if code == 0 or code % 2 == 1 else law[KINETIC]) * push
            sticks = hold <= most and not (span == 0.0 and code > 0 and code % 2 == 0)
            if not sticks and hold > 0.0:
                grip = scale(most / hold, grip)
            u = bristle(law, share, touch, held, w, grip, sticks)
            store_vec(touch.after[row, slot], apply_t(turn, u))
            touch.after[row, slot, CODE] = 2.0 * (home + 1.0) + (1.0 if sticks else 0.0)
            pull = grip
            if law[ACROSS] != 1.0:
                pull = along(n, weighed(law[ACROSS], axis, grip))
            total = sub(total, pull)
            touch.power[0] += dot(grip, w)
            seen = 3.0 if sticks else 2.0
        if factor == 0.0:
            seen += 3.0
        meet.hit[hit, 0], meet.hit[hit, 1], meet.hit[hit, 2] = q, e, slot
        meet.spot[hit] = t
        arm1, arm2 = scale(-part * size, n), scale((1.0 - part) * size, n)
        twist, other = cross(arm1, total), cross(arm2, total)
        push_node(data, one, add(cross(b1, total), scale(a1, twist)), scale(w1, total), 1.0)
        if two != one:
            push_node(data, two, add(cross(b2, total), scale(a2, twist)), scale(w2, total), 1.0)
        three, four = pairs.node[e, 0], pairs.node[e, 1]
        push_node(data, three, add(cross(b3, total), scale(a3, other)), scale(w3, total), -1.0)
        if four != three:
            moment = add(cross(b4, total), scale(a4, other))
            push_node(data, four, moment, scale(w4, total), -1.0)
        slide = sub(along(n, speed), scale(size, cross(omega, n)))
        report = meet.report[hit]
        report[GAP], report[PUSH], report[STICKS] = gap, push, 1.0 if sticks else 0.0
        point = add(x, arm1)
        for c in range(3):
            report[NORMAL + c], report[POINT + c] = n[c], point[c]
            report[PULL + c], report[SLIDE + c] = -pull[c], slide[c]
        mark = 6.0 * (q + 1009.0 * e) + seen
        touch.pattern[0] = (touch.pattern[0] * 31.0 + mark) % REPEAT


@kernel
def load_four(row):
    """Return the four numbers of a row."""
    return row[0], row[1], row[2], row[3]


@kernel
def relax_free(model, data):
    """Let bristles that touch nothing relax."""
    pairs, touch, meet = model.pairs, data.touch, data.meet
    span, slots = touch.mode[SPAN], pairs.slots[0]
    for q in range(len(pairs.cell)):
        row = len(model.contact.node) + q
        for k in range(slots):
            if (meet.taken[q] >> k) & 1 != 0:
                continue
            code = touch.start[row, k, CODE]
            home = home_of(code)
            if home < 0 or not span > 0.0:
                for c in range(WIDE):
                    touch.after[row, k, c] = 0.0
                continue
            law = pairs.law[pairs.group[pairs.cell[q]], pairs.group[home]]
            u = load_vec(touch.start[row, k])
            left = scale(law[TIME] / (span + law[TIME]), u)
            if dot(left, left) < NO_LENGTH * NO_LENGTH:
                left = ZERO
            store_vec(touch.after[row, k], left)
            touch.after[row, k, CODE] = code - code % 2.0 if dot(left, left) > 0.0 else 0.0


@unit
def pair_wrenches(model, data):
    """Subtract the wrenches of bodies on one another from data.wrench; note bristles and power.

    To be called after ``contact_wrenches``, whose power and pattern it adds to.
    """
    pairs, touch, meet = model.pairs, data.touch, data.meet
    meet.counts[1] = 0
    if touch.mode[PRESENT] == 0.0:
        return
    for q in range(len(pairs.cell)):
        meet.taken[q] = 0
    if put_in_balls(model, data):
        look_for_near(model, data)
    if meet.counts[0] == MANY:
        for k in range(len(pairs.pair)):
            one, two = pairs.pair[k, SOURCE], pairs.pair[k, TARGET]
            for g in range(pairs.first[one], pairs.first[one + 1]):
                for e in range(pairs.first[two], pairs.first[two + 1]):
                    if g != e and not clear_of(meet.ball, g, e, 0.0):
                        press(model, data, g, e, pairs.pair[k, KIN])
    for i in range(meet.counts[0]):
        g, e = meet.near[i, 0], meet.near[i, 1]
        if not clear_of(meet.ball, g, e, 0.0):
            press(model, data, g, e, meet.near[i, 2])
    if touch.alive[0] != 0 or meet.counts[1] > 0:
        relax_free(model, data)
