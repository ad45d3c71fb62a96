"""Contact in the equations of motion: wrenches on nodes, their derivatives, stored energy.

These units are called by address (backend/late.py), so that only scenes with shapes compile them.
The wrenches leave in Touch what friction makes of its bristles, the power that contact takes (what
bristles store of it is booked as stored at the end of a step, see balance.py), and the pattern of
what touches: when it changes, factors of the Newton matrix are void.
"""

import math

import numpy as np

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
from soft_sim_ros.core.backend.late import offer
from soft_sim_ros.core.model.contact import (
    ACROSS,
    CODE,
    DISSIPATION,
    FAR,
    KIND,
    KINETIC,
    NONE,
    PRESENT,
    SPAN,
    STATIC,
    TANGENT,
    TIME,
    WIDE,
)

from .law import along, bristle, centre_of, elastic, gripped, motion, pushed, weighed, weighed_rate
from .shapes import distance

ZERO = (0.0, 0.0, 0.0)
NO_LENGTH = 1e-30  # m: a bristle that is deflected by less is free
REPEAT = 8388593.0  # patterns are whole numbers below this prime, exact as doubles


@kernel
def apart(contact, s, centre, radius):
    """Return a lower bound of the gap in m between a ball and a shape; −1: none is known."""
    if contact.bound[s] < 0.0:
        return -1.0
    away = sub(centre, load_vec(contact.centre[s]))
    return math.sqrt(dot(away, away)) - contact.bound[s] - radius


@kernel
def slot_of(touch, e, s, taken):
    """Return the bristle of station e with shape s, or one that is free; −1: there is none.

    taken : bits of the bristles that other shapes use
    """
    slots = touch.start.shape[1]
    for k in range(slots):
        if int(touch.start[e, k, CODE]) // 2 == s + 1:
            return k
    for k in range(slots):
        if touch.start[e, k, CODE] == 0.0 and (taken >> k) & 1 == 0:
            return k
    return -1


@kernel
def limit_of(law, touch, e, k):
    """Return the coefficient of friction: that of sticking until it has slipped."""
    code = int(touch.start[e, k, CODE])
    return law[STATIC] if code == 0 or code % 2 == 1 else law[KINETIC]


@kernel
def let_go(law_time, touch, e, k):
    """Let a bristle that touches nothing relax."""
    span = touch.mode[SPAN]
    u = load_vec(touch.start[e, k])
    left = scale(law_time / (span + law_time) if span + law_time > 0.0 else 0.0, u)
    if dot(left, left) < NO_LENGTH * NO_LENGTH:
        left = ZERO
    store_vec(touch.after[e, k], left)
    code = touch.start[e, k, CODE]
    touch.after[e, k, CODE] = code - code % 2.0 if left[0] != 0.0 or dot(left, left) > 0.0 else 0.0


@unit
def contact_wrenches(model, data):
    """Subtract the wrenches of contact from data.wrench; note bristles, power and pattern."""
    contact, touch = model.contact, data.touch
    shapes, slots = len(contact.kind), touch.start.shape[1]
    friction = slots > 0 and touch.mode[SPAN] >= 0.0
    power, pattern = 0.0, 0.0
    for e in range(len(contact.node) if touch.mode[PRESENT] != 0.0 else 0):
        node, radius, share = contact.node[e], contact.radius[e], contact.share[e]
        near = touch.near[e]
        if touch.kept[e] == 0 and near[3] > 0.0:
            moved = sub(centre_of(model, data, e), load_vec(near))
            if dot(moved, moved) < near[3] * near[3]:
                continue
        arm, centre, omega, speed, axis = motion(model, data, e)
        clear, taken = FAR, 0
        moment, force = ZERO, ZERO
        for s in range(shapes):
            law = contact.law[contact.group[e], s]
            if law[KIND] == NONE:
                continue
            gap = apart(contact, s, centre, radius)
            if gap > 0.0:
                clear = min(clear, gap)
                continue
            d, n, _ = distance(contact, s, centre)
            depth = radius - d
            if depth <= 0.0:
                clear = min(clear, -depth)
                continue
            clear = 0.0
            push, stiff, _, factor, _ = pushed(law, share, radius, n, depth, speed)
            rate = -dot(n, speed)
            power += (push - stiff) * rate
            total = scale(push, n)
            seen = 1.0
            if friction and law[KINETIC] > 0.0:
                k = slot_of(touch, e, s, taken)
                if k >= 0:
                    taken |= 1 << k
                    start = load_vec(touch.start[e, k])
                    held, w, g, _ = gripped(law, share, radius, touch, n, omega, speed, axis, start)
                    size, most = math.sqrt(dot(g, g)), limit_of(law, touch, e, k) * push
                    sticks = size <= most
                    if not sticks:
                        g = scale(most / size, g)
                    u = bristle(law, share, touch, held, w, g, sticks)
                    store_vec(touch.after[e, k], u)
                    touch.after[e, k, CODE] = 2.0 * (s + 1.0) + (1.0 if sticks else 0.0)
                    pull = g
                    if law[ACROSS] != 1.0:
                        pull = along(n, weighed(law[ACROSS], axis, g))
                    total = sub(total, pull)
                    power += dot(g, w)
                    seen = 3.0 if sticks else 2.0
            if factor == 0.0:
                seen += 3.0
            force = add(force, total)
            moment = add(moment, cross(sub(arm, scale(radius, n)), total))
            pattern = (pattern * 31.0 + 6.0 * (e * shapes + s) + seen) % REPEAT
        for k in range(slots):
            if (taken >> k) & 1 == 0:
                s = int(touch.start[e, k, CODE]) // 2 - 1
                if 0 <= s < shapes and touch.mode[SPAN] > 0.0:
                    let_go(contact.law[contact.group[e], s, TIME], touch, e, k)
                else:
                    for c in range(WIDE):
                        touch.after[e, k, c] = 0.0
        store_vec(near, centre)
        near[3] = clear
        if clear == 0.0:
            rotation = load_mat(data.rotation[node])
            moment, force = apply_t(rotation, moment), apply_t(rotation, force)
            for c in range(3):
                data.wrench[node, c] -= moment[c]
                data.wrench[node, 3 + c] -= force[c]
    touch.power[0], touch.pattern[0] = power, pattern


@kernel
def basis(j, part):
    """Return unit vector j − 3 part, or zero if j is not of this part of twelve."""
    c = j - 3 * part
    return (1.0 if c == 0 else 0.0, 1.0 if c == 1 else 0.0, 1.0 if c == 2 else 0.0)


@kernel
def add_slopes(model, data, e, s, by, sums):
    """Add the derivatives of the wrench of station e and shape s to by (6, 12), it to sums (6,).

    By a small turn and shift of the node, and by its ω and velocity, all along base axes.
    """
    contact, touch = model.contact, data.touch
    law = contact.law[contact.group[e], s]
    radius, share = contact.radius[e], contact.share[e]
    arm, centre, omega, speed, axis = motion(model, data, e)
    d, n, curved = distance(contact, s, centre)
    depth = radius - d
    if depth <= 0.0:
        return 0
    push, stiff, slope, factor, _ = pushed(law, share, radius, n, depth, speed)
    across = law[ACROSS]
    k = -1
    if touch.start.shape[1] > 0 and touch.mode[SPAN] >= 0.0 and law[KINETIC] > 0.0:
        for i in range(touch.start.shape[1]):
            if int(touch.after[e, i, CODE]) // 2 == s + 1:
                k = i
    g, size, most, mu, resist, slide = ZERO, 0.0, 0.0, 0.0, 0.0, ZERO
    sticks, start, kappa = True, ZERO, law[TANGENT] * share
    raw = ZERO
    if k >= 0:
        start = load_vec(touch.start[e, k])
        mu = limit_of(law, touch, e, k)
        _, _, raw, resist = gripped(law, share, radius, touch, n, omega, speed, axis, start)
        slide = sub(along(n, speed), scale(radius, cross(omega, n)))
        size, most = math.sqrt(dot(raw, raw)), mu * push
        sticks = size <= most
        g = raw if sticks else scale(most / size, raw)
    spread = weighed(across, axis, g)
    total = sub(scale(push, n), along(n, spread))
    lever = sub(arm, scale(radius, n))
    moment = cross(lever, total)
    for c in range(3):
        sums[c] += moment[c]
        sums[3 + c] += total[c]
    vn = dot(n, speed)
    for j in range(12):
        turn, shift, spin, fly = basis(j, 0), basis(j, 1), basis(j, 2), basis(j, 3)
        d_arm = cross(turn, arm)
        d_n = apply(curved, add(shift, d_arm))
        d_depth = -dot(n, add(shift, d_arm))
        d_speed = add(add(fly, cross(spin, arm)), cross(omega, d_arm))
        d_vn = dot(d_n, speed) + dot(n, d_speed)
        d_push = slope * factor * d_depth
        if factor > 0.0:
            d_push -= stiff * law[DISSIPATION] * d_vn
        d_total = add(scale(d_push, n), scale(push, d_n))
        if k >= 0:
            d_slide = sub(d_speed, add(scale(vn, d_n), scale(d_vn, n)))
            rolled = add(cross(spin, n), cross(omega, d_n))
            d_slide = sub(d_slide, scale(radius, rolled))
            d_axis = cross(turn, axis)
            y = weighed(across, axis, slide)
            d_y = weighed_rate(across, axis, d_axis, slide, d_slide)
            d_w = sub(d_y, add(scale(dot(n, y), d_n), scale(dot(d_n, y) + dot(n, d_y), n)))
            d_held = scale(-1.0, add(scale(dot(n, start), d_n), scale(dot(d_n, start), n)))
            d_g = add(scale(kappa, d_held), scale(resist, d_w))
            if not sticks:
                way = scale(1.0 / size, raw)
                d_g = scale(most / size, sub(d_g, scale(dot(way, d_g), way)))
                d_g = add(d_g, scale(mu * d_push, way))
            d_spread = weighed_rate(across, axis, d_axis, g, d_g)
            tail = add(scale(dot(n, spread), d_n), scale(dot(d_n, spread) + dot(n, d_spread), n))
            d_total = sub(d_total, sub(d_spread, tail))
        d_lever = sub(d_arm, scale(radius, d_n))
        d_moment = add(cross(d_lever, total), cross(lever, d_total))
        for c in range(3):
            by[c, j] += d_moment[c]
            by[3 + c, j] += d_total[c]
    return 1


@unit
def contact_matrices(model, data, node, out):
    """Subtract the derivatives of contact on a node from its G and D in ``out``.

    out : rows of I, G, D with as many components as the model moves in, in the base frame, eight
        numbers each
    """
    contact, touch = model.contact, data.touch
    if touch.mode[PRESENT] == 0.0:
        return
    by, sums = np.zeros((6, 12)), np.zeros(6)
    found = 0
    for e in range(contact.ptr[node], contact.ptr[node + 1]):
        if touch.near[e, 3] != 0.0:
            continue
        for s in range(len(contact.kind)):
            if contact.law[contact.group[e], s, KIND] == NONE:
                continue
            if apart(contact, s, centre_of(model, data, e), contact.radius[e]) <= 0.0:
                found += add_slopes(model, data, e, s, by, sums)
    if found == 0:
        return
    rotation = load_mat(data.rotation[node])
    omega = apply(rotation, load_vec(data.eta[node]))
    speed = apply(rotation, load_vec(data.eta[node, 3:]))
    for i in range(6):
        for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            # velocities belong to the frame: B (θ × ω; θ × v)
            by[i, a] += by[i, 6 + c] * omega[b] - by[i, 6 + b] * omega[c]
            by[i, a] += by[i, 9 + c] * speed[b] - by[i, 9 + b] * speed[c]
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        # and so does the wrench: F × θ
        by[c, b] += sums[a]
        by[b, c] -= sums[a]
        by[3 + c, b] += sums[3 + a]
        by[3 + b, c] -= sums[3 + a]
    # δp = v − p × θ of a spatial twist (θ; v), and the wrench is carried to the origin likewise
    at = load_vec(data.position[node])
    carry = np.eye(6)
    carry[3, 1], carry[3, 2] = at[2], -at[1]
    carry[4, 0], carry[4, 2] = -at[2], at[0]
    carry[5, 0], carry[5, 1] = at[1], -at[0]
    size = len(contact.components)
    half = np.zeros((6, 6))
    for part in range(2):  # G by rates, D by places
        first = 6 * (1 - part)
        for i in range(6):
            for j in range(6):
                half[i, j] = 0.0
                for c in range(6):
                    half[i, j] += by[i, first + c] * carry[c, j]
        for i in range(size):
            for j in range(size):
                total = 0.0
                for c in range(6):
                    total += carry[c, contact.components[i]] * half[c, contact.components[j]]
                out[(1 + part) * size + i, j] -= total


@unit
def contact_energy(model, data):
    """Return the energy in J that contact stores, without bristles, at the last ``place``."""
    contact, touch = model.contact, data.touch
    total = 0.0
    for e in range(len(contact.node) if touch.mode[PRESENT] != 0.0 else 0):
        radius, share, group = contact.radius[e], contact.share[e], contact.group[e]
        centre = centre_of(model, data, e)
        for s in range(len(contact.kind)):
            law = contact.law[group, s]
            if law[KIND] == NONE or apart(contact, s, centre, radius) > 0.0:
                continue
            d, _, _ = distance(contact, s, centre)
            if d < radius:
                total += elastic(law, share, radius, radius - d)[2]
    return total


offer(
    "contact",
    (contact_wrenches, ()),
    (contact_matrices, (0, np.zeros((18, 8)))),
    (contact_energy, ()),
)
