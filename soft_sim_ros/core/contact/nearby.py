"""Cells that are near one another: what is further off costs next to nothing.

They are looked for again when a cell has moved by half of a margin, bodies first. Pairs are in the
order of the cells, so when that happens changes no bit of what touches.
"""

import math

from soft_sim_ros.core.algebra.dual import (
    add,
    apply,
    dot,
    load_mat,
    load_vec,
    scale,
    store_vec,
    sub,
)
from soft_sim_ros.core.backend.jit import kernel, unit
from soft_sim_ros.core.model.pairs import CURVE, KIN, SOURCE, STICK, TARGET

from .places import stick_ends

STRETCH = 0.15  # of the length of a cell: how far its curve may leave the ball about its ends
UNKNOWN, MANY = -1, -2  # Meet.counts[0]


@unit
def put_in_balls(model, data):
    """Fill Meet.ball; return whether cells have moved so that those near must be looked for."""
    pairs, meet = model.pairs, data.meet
    most = 0.25 * pairs.margin[0] * pairs.margin[0]
    moved = meet.counts[0] == UNKNOWN
    for c in range(len(pairs.kind)):
        one, radius = pairs.node[c, 0], pairs.bound[c]
        if pairs.kind[c] == CURVE:
            p0, p1 = load_vec(data.position[one]), load_vec(data.position[pairs.node[c, 1]])
            d, length = sub(p1, p0), pairs.size[c, 0]
            middle = scale(0.5, add(p0, p1))
            radius += 0.5 * max(math.sqrt(dot(d, d)), length) + STRETCH * length
        elif pairs.kind[c] == STICK:
            p0, p1 = stick_ends(model, data, c)
            middle = scale(0.5, add(p0, p1))
        else:
            own = apply(load_mat(data.rotation[one]), load_vec(pairs.centre[c]))
            middle = add(load_vec(data.position[one]), own)
        store_vec(meet.ball[c], middle)
        meet.ball[c, 3] = radius
        d = sub(middle, load_vec(meet.seen[c]))
        if not dot(d, d) <= most:
            moved = True
    return moved


@kernel
def clear_of(ball, g, e, margin):
    """Return whether the balls of two cells are further apart than a margin."""
    if ball[e, 3] < 0.0 or ball[g, 3] < 0.0:
        return False
    d = sub(load_vec(ball[g]), load_vec(ball[e]))
    far = ball[g, 3] + ball[e, 3] + margin
    return dot(d, d) > far * far


@kernel
def body_ball(model, data, b):
    """Return centre and radius of a ball about a body; a radius below zero: there is none."""
    pairs, ball = model.pairs, data.meet.ball
    first, last = pairs.first[b], pairs.first[b + 1]
    middle = (0.0, 0.0, 0.0)
    for c in range(first, last):
        middle = add(middle, load_vec(ball[c]))
    middle = scale(1.0 / (last - first), middle)
    radius = 0.0
    for c in range(first, last):
        if ball[c, 3] < 0.0:
            return middle, -1.0
        d = sub(load_vec(ball[c]), middle)
        radius = max(radius, math.sqrt(dot(d, d)) + ball[c, 3])
    return middle, radius


@unit
def look_for_near(model, data):
    """Fill Meet.near with pairs of cells that may touch before cells move by half of the margin."""
    pairs, meet = model.pairs, data.meet
    margin, found = pairs.margin[0], 0
    for c in range(len(pairs.kind)):
        store_vec(meet.seen[c], load_vec(meet.ball[c]))
    for k in range(len(pairs.pair)):
        one, two = pairs.pair[k, SOURCE], pairs.pair[k, TARGET]
        if one != two:
            m1, r1 = body_ball(model, data, one)
            m2, r2 = body_ball(model, data, two)
            d, far = sub(m1, m2), r1 + r2 + margin
            if r1 >= 0.0 and r2 >= 0.0 and dot(d, d) > far * far:
                continue
        for g in range(pairs.first[one], pairs.first[one + 1]):
            for e in range(pairs.first[two], pairs.first[two + 1]):
                if g == e or clear_of(meet.ball, g, e, margin):
                    continue
                if found == len(meet.near):
                    meet.counts[0] = MANY
                    return
                meet.near[found, 0], meet.near[found, 1] = g, e
                meet.near[found, 2] = pairs.pair[k, KIN]
                found += 1
    meet.counts[0] = found
