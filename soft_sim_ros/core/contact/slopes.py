"""Exact derivatives of the wrenches of bodies that touch, place by place.

The place on the cell moves along with the bodies, and so do the normal, levers and bristles.
"""

import math

from soft_sim_ros.core.algebra.dual import add, apply, cross, dot, load_mat, load_vec, scale, sub
from soft_sim_ros.core.backend.jit import kernel, unit
from soft_sim_ros.core.model.contact import ACROSS, CODE, DISSIPATION, KINETIC, STATIC, TANGENT
from soft_sim_ros.core.model.pairs import CURVE, GAP, NORMAL, STICK

from .law import along, gripped, pushed, weighed, weighed_rate
from .meeting import ZERO, home_of, levers, load_four, other_side, station_axis
from .places import (
    cubic_bend,
    cubic_slope,
    curve_ends,
    distance_to,
    mixed,
    pair_motion,
    radius_slope,
    station_place,
    stick_ends,
)

NODES = 5  # two of the station, two of the cell, one that turns the bristle


@kernel
def basis(j, part):
    """Return unit vector j − 3 part, or zero if j is not of this part of twelve."""
    c = j - 3 * part
    return (1.0 if c == 0 else 0.0, 1.0 if c == 1 else 0.0, 1.0 if c == 2 else 0.0)


@kernel
def spin_of(data, node):
    """Return the angular velocity of a node along base axes."""
    return apply(load_mat(data.rotation[node]), load_vec(data.eta[node]))


@kernel
def sliding(model, data, e, x, n, size, t):
    """Return (c′, P c′, slope of the opening, w′, o′ of both nodes, u′) of where a cell is pressed.

    Derivatives along the cell of its skeleton, of shares and arms of its nodes, of its velocity;
    zero where the place on it cannot move: at its ends, and on shapes.
    """
    pairs = model.pairs
    kind = pairs.kind[e]
    if kind == CURVE and 0.0 < t < 1.0:
        h, hh = cubic_slope(t), cubic_bend(t)
        p0, p1, a0, a1 = curve_ends(model, data, e)
        c1, c2 = mixed(h, p0, p1, a0, a1), mixed(hh, p0, p1, a0, a1)
        flat = along(n, c1)
        grows = dot(flat, flat) / size - dot(n, c2) - radius_slope(hh, pairs.taper[e])
        o0, o1 = scale(h[2], a0), scale(h[3], a1)
        one, two = pairs.node[e, 0], pairs.node[e, 1]
        r0, r1 = load_mat(data.rotation[one]), load_mat(data.rotation[two])
        v0, v1 = apply(r0, load_vec(data.eta[one, 3:])), apply(r1, load_vec(data.eta[two, 3:]))
        u0 = add(scale(h[0], v0), cross(spin_of(data, one), o0))
        u1 = add(scale(h[1], v1), cross(spin_of(data, two), o1))
        return c1, flat, grows, h[0], h[1], o0, o1, add(u0, u1)
    if kind == STICK and 0.0 < t < 1.0:
        p0, p1 = stick_ends(model, data, e)
        c1 = sub(p1, p0)
        flat = along(n, c1)
        u = cross(spin_of(data, pairs.node[e, 0]), c1)
        return c1, flat, dot(flat, flat) / size, 0.0, 0.0, c1, ZERO, u
    return ZERO, ZERO, 0.0, 0.0, 0.0, ZERO, ZERO, ZERO


@unit
def add_hit(model, data, i, site, matrix, sums):
    """Add the derivatives of the wrenches of hit i to matrix (6S, 12S), them to sums (S, 6).

    By small turns and shifts of the nodes of the sites, and by their ω and velocities, along base
    axes. site : (nodes,) number of the site of a node, −1 where it cannot move
    """
    pairs, touch, meet = model.pairs, data.touch, data.meet
    q, e, slot = meet.hit[i, 0], meet.hit[i, 1], meet.hit[i, 2]
    t, gap, n = meet.spot[i], meet.report[i, GAP], load_vec(meet.report[i, NORMAL:])
    g = pairs.cell[q]
    law = pairs.law[pairs.group[g], pairs.group[e]]
    radius, share = pairs.radius[q], pairs.share[q]
    shaped = pairs.kind[e] != CURVE and pairs.kind[e] != STICK
    x = station_place(model, data, q)
    size, part = levers(model, q, e, gap, t)
    one, two = pairs.node[g, 0], pairs.node[g, 1]
    three, four = pairs.node[e, 0], pairs.node[e, 1]
    w1, w2, a1, a2 = load_four(pairs.weight[q])
    b1, _, u1, s1 = pair_motion(w1, a1, load_vec(pairs.arm[q]), data, one)
    b2, _, u2, s2 = pair_motion(w2, a2, load_vec(pairs.arm[q, 3:]), data, two)
    b3, u3, s3, w3, a3 = other_side(model, data, q, e, x, n, t, 0)
    b4, u4, s4, w4, a4 = other_side(model, data, q, e, x, n, t, 1)
    speed = sub(add(u1, u2), add(u3, u4))
    omega = add(scale(part, add(s1, s2)), scale(1.0 - part, add(s3, s4)))
    push, stiff, slope, factor, _ = pushed(law, share, radius, n, -gap, speed)
    axis, near = station_axis(model, data, q)
    across = law[ACROSS]
    raw, grip, hold, most, mu, resist = ZERO, ZERO, 0.0, 0.0, 0.0, 0.0
    sticks, start, kappa, home_node = True, ZERO, law[TANGENT] * share, 0
    if slot >= 0:
        row = len(model.contact.node) + q
        code = int(touch.start[row, slot, CODE])
        home_node = pairs.node[home_of(touch.after[row, slot, CODE]), 0]
        start = apply(load_mat(data.rotation[home_node]), load_vec(touch.start[row, slot]))
        mu = law[STATIC] if code == 0 or code % 2 == 1 else law[KINETIC]
        _, _, raw, resist = gripped(law, share, size, touch, n, omega, speed, axis, start)
        hold, most = math.sqrt(dot(raw, raw)), mu * push
        sticks = hold <= most
        grip = raw if sticks else scale(most / hold, raw)
    flat_slide = sub(along(n, speed), scale(size, cross(omega, n)))
    spread = weighed(across, axis, grip)
    total = sub(scale(push, n), along(n, spread))
    arm1, arm2 = scale(-part * size, n), scale((1.0 - part) * size, n)
    twist, other = cross(arm1, total), cross(arm2, total)
    nodes = (one, two, three, four, home_node)
    arms, shares, spins = (b1, b2, b3, b4), (w1, w2, w3, w4), (a1, a2, a3, a4)
    signs = (1.0, 1.0, -1.0, -1.0)
    count = (2 if two != one else 1), (2 if four != three else 1)
    for k in range(4):
        if (k == 1 and count[0] == 1) or (k == 3 and count[1] == 1) or site[nodes[k]] < 0:
            continue
        lever = twist if k < 2 else other
        moment = add(cross(arms[k], total), scale(spins[k], lever))
        for c in range(3):
            sums[site[nodes[k]], c] += signs[k] * moment[c]
            sums[site[nodes[k]], 3 + c] += signs[k] * shares[k] * total[c]
    c1, flat, grows, dw3, dw4, o3, o4, du = sliding(model, data, e, x, n, size, t)
    moving = grows > 0.0
    curved = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if shaped:
        _, _, curved = distance_to(model, data, e, x)
    vn = dot(n, speed)
    for k in range(NODES):
        if (k == 1 and count[0] == 1) or (k == 3 and count[1] == 1):
            continue
        if site[nodes[k]] < 0 or (k == 4 and slot < 0):
            continue
        b = arms[k] if k < 4 else ZERO
        w = shares[k] if k < 4 else 0.0
        spun = spins[k] if k < 4 else 0.0
        whirl = spin_of(data, nodes[k])
        for j in range(12):
            turn, shift, spin, fly = basis(j, 0), basis(j, 1), basis(j, 2), basis(j, 3)
            d_b = cross(turn, b)
            d_u = add(scale(w, fly), add(cross(spin, b), cross(whirl, d_b)))
            d_c = add(scale(w, shift), d_b)
            d_s = scale(spun, spin)
            d_start, d_axis = ZERO, ZERO
            d_x, d_y, d_v, d_spin = ZERO, ZERO, ZERO, ZERO  # place and motion, both sides
            d_n, d_gap, d_size, d_t, d_arm = ZERO, 0.0, 0.0, 0.0, ZERO
            if k < 2:
                d_x, d_v, d_spin = d_c, d_u, scale(part, d_s)
                if k == near:
                    d_axis = cross(turn, axis)
            elif k < 4:
                d_y, d_v, d_spin = d_c, scale(-1.0, d_u), scale(1.0 - part, d_s)
            else:
                d_start = cross(turn, start)
            if shaped:
                if k == 2:  # the shape moves: as if the station moved the other way, and turned
                    from_node = sub(x, load_vec(data.position[three]))
                    d_point = scale(-1.0, add(shift, cross(turn, from_node)))
                    d_n = add(apply(curved, d_point), cross(turn, n))
                    d_gap = dot(n, d_point)
                    d_arm = sub(scale(-radius, d_n), shift)
                    whirled = add(cross(spin, b), cross(whirl, d_arm))
                    d_v = scale(-1.0, add(fly, whirled))
                elif k < 2:
                    d_n = apply(curved, d_x)
                    d_gap = dot(n, d_x)
                    d_arm = sub(d_x, scale(radius, d_n))
                    d_v = sub(d_v, cross(s3, d_arm))
            else:
                d_d = sub(d_x, d_y)
                d_gap = dot(n, d_d)
                if moving:
                    d_t = dot(flat, d_d) / size
                    if k == 2 or k == 3:
                        o, dw = (o3, dw3) if k == 2 else (o4, dw4)
                        d_t += dot(n, add(scale(dw, shift), cross(turn, o)))
                    d_t /= grows
                    d_d = sub(d_d, scale(d_t, c1))
                    d_v = sub(d_v, scale(d_t, du))
                    if pairs.kind[e] == CURVE:
                        turned = sub(spin_of(data, four), spin_of(data, three))
                        d_spin = add(d_spin, scale((1.0 - part) * d_t, turned))
                d_size = dot(n, d_d)
                d_n = scale(1.0 / size, along(n, d_d))
            d_vn = dot(d_n, speed) + dot(n, d_v)
            d_push = -slope * factor * d_gap
            if factor > 0.0:
                d_push -= stiff * law[DISSIPATION] * d_vn
            d_total = add(scale(d_push, n), scale(push, d_n))
            if slot >= 0:
                d_slide = sub(d_v, add(scale(vn, d_n), scale(d_vn, n)))
                rolled = add(cross(d_spin, n), cross(omega, d_n))
                d_slide = sub(d_slide, add(scale(size, rolled), scale(d_size, cross(omega, n))))
                y = weighed(across, axis, flat_slide)
                d_w = weighed_rate(across, axis, d_axis, flat_slide, d_slide)
                off = dot(d_n, y) + dot(n, d_w)
                d_w = sub(d_w, add(scale(dot(n, y), d_n), scale(off, n)))
                d_held = along_rate(n, d_n, start, d_start)
                d_g = add(scale(kappa, d_held), scale(resist, d_w))
                if not sticks:
                    way = scale(1.0 / hold, raw)
                    d_g = scale(most / hold, sub(d_g, scale(dot(way, d_g), way)))
                    d_g = add(d_g, scale(mu * d_push, way))
                d_spread = weighed_rate(across, axis, d_axis, grip, d_g)
                d_total = sub(d_total, along_rate(n, d_n, spread, d_spread))
            d_out = add(scale(d_size, n), scale(size, d_n))
            d_twist = add(cross(scale(-part, d_out), total), cross(arm1, d_total))
            d_other = add(cross(scale(1.0 - part, d_out), total), cross(arm2, d_total))
            column = 12 * site[nodes[k]] + j
            for m in range(4):
                if (m == 1 and count[0] == 1) or (m == 3 and count[1] == 1):
                    continue
                if site[nodes[m]] < 0:
                    continue
                d_lever = d_twist if m < 2 else d_other
                d_mine = d_b if m == k else ZERO
                d_share, d_spun = 0.0, 0.0
                if m >= 2 and shaped:
                    d_mine = d_arm
                elif m >= 2 and d_t != 0.0:
                    d_mine = add(d_mine, scale(d_t, o3 if m == 2 else o4))
                    d_share = d_t * (dw3 if m == 2 else dw4)
                    if pairs.kind[e] == CURVE:
                        d_spun = d_t * (-1.0 if m == 2 else 1.0)
                d_force = scale(shares[m], d_total)
                d_force = add(d_force, scale(d_share, total))
                d_moment = add(cross(d_mine, total), cross(arms[m], d_total))
                lever = twist if m < 2 else other
                d_moment = add(d_moment, add(scale(spins[m], d_lever), scale(d_spun, lever)))
                first = 6 * site[nodes[m]]
                for c in range(3):
                    matrix[first + c, column] += signs[m] * d_moment[c]
                    matrix[first + 3 + c, column] += signs[m] * d_force[c]


@kernel
def along_rate(n, d_n, x, dx):
    """Return the change of ``along``."""
    return sub(dx, add(scale(dot(n, x), d_n), scale(dot(d_n, x) + dot(n, dx), n)))
