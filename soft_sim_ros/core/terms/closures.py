"""Constraints between two frames: how far they are from being met, and the wrenches that meet them.

Every row of a constraint is a function f of the places of its two frames. Along spatial twists V₁
and V₂ of the frames (in the base frame, about its origin),

    ḟ = W · (V₁ − V₂),   Ẇ = H (V₁ − V₂) + V₂ × W,

so a multiplier λ is the wrench λ W on the first frame and −λ W on the second. W and H are known in
closed form for three kinds of row: a component of the distance of two points along an axis of the
second frame, their distance, and products of axes of both frames (sines and cosines of angles).
"""

import numpy as np

from soft_sim_ros.core.algebra.dual import (
    add,
    apply,
    cross,
    dot,
    load_mat,
    load_vec,
    mul,
    scale,
    sub,
)
from soft_sim_ros.core.backend.jit import bare, kernel, unit

ALONG, DISTANCE, TURN = 0, 1, 2  # Closures.rule
FREED, HELD, TIMED = 0.0, 1.0, 2.0  # Closed.held[:, MODE]
MODE, TARGET = 0, 1  # columns of Closed.held
ZERO = (0.0, 0.0, 0.0)


@kernel
def placed(node_rotation, node_position, offset, frame):
    """Fill frame (12,), rotation by rows and position, at an offset (12,) from a node."""
    turn, at = load_mat(node_rotation), load_vec(node_position)
    own = mul(turn, load_mat(offset))
    spot = add(at, apply(turn, (offset[9], offset[10], offset[11])))
    for c in range(9):
        frame[c] = own[c]
    for c in range(3):
        frame[9 + c] = spot[c]


@kernel
def axis_of(frame, own):
    """Return a vector (3,) of a frame (12,) in base axes."""
    return apply(load_mat(frame), load_vec(own))


@kernel
def cross_wrench(twist, wrench):
    """Return (ω; v) × (M; N) = (ω × M + v × N; ω × N)."""
    moment = add(cross(twist[0], wrench[0]), cross(twist[1], wrench[1]))
    return moment, cross(twist[0], wrench[1])


@kernel
def twofold(a, b):
    """Return the sum of products of two twists or wrenches."""
    return dot(a[0], b[0]) + dot(a[1], b[1])


@kernel
def split(row):
    """Return (6,) as two vectors."""
    return (row[0], row[1], row[2]), (row[3], row[4], row[5])


@kernel
def keep(row, pair):
    """Fill (6,) with two vectors."""
    for c in range(3):
        row[c], row[3 + c] = pair[0][c], pair[1][c]


@kernel
def row_value(rule, vector, one, two):
    """Return f of a row, and its wrench W, for frames one and two (12,)."""
    p1, p2 = (one[9], one[10], one[11]), (two[9], two[10], two[11])
    if rule == ALONG:
        n = axis_of(two, vector[0])
        return dot(n, sub(p1, p2)), (cross(p1, n), n)
    if rule == DISTANCE:
        d = sub(p1, p2)
        size = np.sqrt(dot(d, d))
        n = scale(1.0 / size, d)
        return size - vector[0, 0], (cross(p1, n), n)
    u, w = axis_of(two, vector[0]), axis_of(one, vector[1])
    x, y = axis_of(two, vector[2]), axis_of(one, vector[3])
    return dot(u, w) - dot(x, y), (sub(cross(w, u), cross(y, x)), ZERO)


@kernel
def row_bend(rule, vector, one, two, twist):
    """Return H of a row times a twist."""
    p1, p2 = (one[9], one[10], one[11]), (two[9], two[10], two[11])
    moved = add(twist[1], cross(twist[0], p1))
    if rule == ALONG:
        return cross(moved, axis_of(two, vector[0])), ZERO
    if rule == DISTANCE:
        d = sub(p1, p2)
        size = np.sqrt(dot(d, d))
        n = scale(1.0 / size, d)
        turned = scale(1.0 / size, sub(moved, scale(dot(n, moved), n)))
        return add(cross(moved, n), cross(p1, turned)), turned
    u, w = axis_of(two, vector[0]), axis_of(one, vector[1])
    x, y = axis_of(two, vector[2]), axis_of(one, vector[3])
    bent = sub(cross(cross(twist[0], w), u), cross(cross(twist[0], y), x))
    return bent, ZERO


@unit
def look_at_frames(closures, data):
    """Fill Closed.frame, twist, pull, value, speed, acceleration and wrench from the last sweep.

    Data.rotation and Data.position must be of it.
    """
    closed = data.closed
    gravity = load_vec(data.gravity)
    for k in range(len(closures.node)):
        for j in range(2):
            node = closures.node[k, j]
            offset = closures.offset[k] if j == 0 else bare(closed.held)[k, TARGET:]
            placed(data.rotation[node], data.position[node], offset, closed.frame[k, j])
            turn, at = load_mat(data.rotation[node]), load_vec(data.position[node])
            eta, acc = split(data.eta[node]), split(data.acc[node])
            omega, alpha = apply(turn, eta[0]), apply(turn, acc[0])
            v = add(apply(turn, eta[1]), cross(at, omega))
            a = add(add(apply(turn, acc[1]), gravity), cross(at, alpha))
            keep(closed.twist[k, j], (omega, v))
            keep(closed.pull[k, j], (alpha, a))
        v1, v2 = split(closed.twist[k, 0]), split(closed.twist[k, 1])
        a1, a2 = split(closed.pull[k, 0]), split(closed.pull[k, 1])
        dv = sub(v1[0], v2[0]), sub(v1[1], v2[1])
        da = sub(a1[0], a2[0]), sub(a1[1], a2[1])
        one, two = closed.frame[k, 0], closed.frame[k, 1]
        for i in range(closures.ptr[k], closures.ptr[k + 1]):
            rule, vector = closures.rule[i], closures.vector[i]
            value, wrench = row_value(rule, vector, one, two)
            bend = row_bend(rule, vector, one, two, dv)
            closed.value[i], closed.speed[i] = value, twofold(wrench, dv)
            carried = twofold(bend, dv) + twofold(cross_wrench(v2, wrench), dv)
            closed.acceleration[i] = twofold(wrench, da) + carried
            keep(closed.wrench[i], wrench)


@kernel
def add_wrench(data, node, factor, wrench):
    """Add a spatial wrench to the dead wrench of a node."""
    force = scale(factor, wrench[1])
    moment = sub(scale(factor, wrench[0]), cross(load_vec(data.position[node]), force))
    for c in range(3):
        data.dead[node, c] += moment[c]
        data.dead[node, 3 + c] += force[c]


@unit
def push_frames(closures, data):
    """Add the wrenches of all constraints to the dead ones, from the last look_at_frames.

    Those of the nodes are kept, for ``let_go``.
    """
    closed = data.closed
    for f in range(len(closures.site)):
        for c in range(6):
            closed.dead[f, c] = data.dead[closures.site[f, 0], c]
    closed.active[0] = data.active[0]
    data.active[0] = 1
    for k in range(len(closures.node)):
        for i in range(closures.ptr[k], closures.ptr[k + 1]):
            if closed.multiplier[i] != 0.0:
                wrench = split(closed.wrench[i])
                add_wrench(data, closures.node[k, 0], closed.multiplier[i], wrench)
                if closures.place[k, 1] >= 0:
                    add_wrench(data, closures.node[k, 1], -closed.multiplier[i], wrench)


@unit
def let_go(closures, data):
    """Put the dead wrenches of the nodes back to what they were before ``push_frames``."""
    closed = data.closed
    for f in range(len(closures.site)):
        for c in range(6):
            data.dead[closures.site[f, 0], c] = closed.dead[f, c]
    data.active[0] = closed.active[0]


@kernel
def in_force(closures, held, k, t, slack):
    """Return whether constraint k acts just after t in s."""
    if held[k, MODE] != TIMED:
        return held[k, MODE] == HELD
    return closures.schedule[k, 0] <= t + slack and t + slack < closures.schedule[k, 1]


@unit
def in_force_now(closures, held, k, t):
    """Return whether constraint k acts at t in s."""
    return in_force(closures, held, k, t, 1e-12)


@unit
def bends(closures, data, matrix):
    """Fill matrix (6F, 6F) with the derivative of −Jᵀ λ W by spatial turns of the sites.

    Of what the turning of the parts beyond does not account for: −(H − ×W), H − ×W; H, −H.
    """
    matrix = bare(matrix)
    closed = data.closed
    matrix[:] = 0.0
    column = np.zeros(6)
    for k in range(len(closures.node)):
        first, second = 6 * closures.place[k, 0], 6 * closures.place[k, 1]
        one, two = closed.frame[k, 0], closed.frame[k, 1]
        for i in range(closures.ptr[k], closures.ptr[k + 1]):
            weight = closed.multiplier[i]
            if weight == 0.0:
                continue
            rule, vector, wrench = closures.rule[i], closures.vector[i], split(closed.wrench[i])
            for j in range(6):
                for c in range(6):
                    column[c] = 1.0 if c == j else 0.0
                twist = split(column)
                bend = row_bend(rule, vector, one, two, twist)
                turn = cross_wrench(twist, wrench)
                for c in range(6):
                    h = bend[c // 3][c % 3]
                    x = turn[c // 3][c % 3]
                    if first >= 0:
                        matrix[first + c, first + j] -= weight * (h - x)
                    if second >= 0:
                        matrix[second + c, second + j] -= weight * h
                    if first >= 0 and second >= 0:
                        matrix[first + c, second + j] += weight * (h - x)
                        matrix[second + c, first + j] += weight * h


@unit
def senses(closures, data, a0, matrix):
    """Fill matrix (R, 18F): how accelerations of rows follow (J; Z; Y) x of the sites.

    Z and Y as in the tangent: first and second rates of J x along the variation. Exact up to terms
    of second order in the velocities.
    """
    matrix = bare(matrix)
    closed = data.closed
    matrix[:] = 0.0
    column = np.zeros(6)
    for k in range(len(closures.node)):
        first, second = 18 * closures.place[k, 0], 18 * closures.place[k, 1]
        one, two = closed.frame[k, 0], closed.frame[k, 1]
        v1, v2 = split(closed.twist[k, 0]), split(closed.twist[k, 1])
        b1, b2 = split(closed.pull[k, 0]), split(closed.pull[k, 1])
        dv = sub(v1[0], v2[0]), sub(v1[1], v2[1])
        da = sub(b1[0], b2[0]), sub(b1[1], b2[1])
        for i in range(closures.ptr[k], closures.ptr[k + 1]):
            rule, vector, wrench = closures.rule[i], closures.vector[i], split(closed.wrench[i])
            ahead, across, back = np.zeros(6), np.zeros(6), np.zeros(6)
            keep(ahead, row_bend(rule, vector, one, two, dv))
            for j in range(6):
                for c in range(6):
                    column[c] = 1.0 if c == j else 0.0
                bend = row_bend(rule, vector, one, two, split(column))
                across[j] = twofold(bend, da)
                back[j] = twofold(bend, dv)
            carried = np.zeros(6)
            keep(carried, cross_wrench(v2, wrench))
            for c in range(6):
                carried[c] += ahead[c] + back[c]
            slope = split(carried)
            own = np.zeros((2, 6))
            if first >= 0:
                keep(own[0], cross_wrench(b1, wrench))
                keep(own[1], cross_wrench(v1, slope))
                turn = np.zeros(6)
                keep(turn, cross_wrench(v1, wrench))
                for c in range(6):
                    matrix[i, first + c] += a0 * (own[0, c] + own[1, c] + across[c])
                    matrix[i, first + 6 + c] += turn[c] + carried[c]
                    matrix[i, first + 12 + c] += closed.wrench[i, c]
            if second >= 0:
                led = np.zeros(6)
                keep(led, cross_wrench(dv, wrench))
                slope = split(carried + led)
                keep(own[0], cross_wrench(b2, wrench))
                keep(own[1], cross_wrench(v2, slope))
                turn, fell = np.zeros(6), np.zeros(6)
                keep(turn, cross_wrench(v2, wrench))
                keep(fell, cross_wrench(da, wrench))
                for c in range(6):
                    along = own[0, c] + own[1, c] + across[c] + fell[c]
                    matrix[i, second + c] -= a0 * along
                    matrix[i, second + 6 + c] -= turn[c] + carried[c] + led[c]
                    matrix[i, second + 12 + c] -= closed.wrench[i, c]


@unit
def lever(closures, data, matrix):
    """Fill matrix (6F, R): the spatial wrenches on the sites per multiplier."""
    matrix = bare(matrix)
    matrix[:] = 0.0
    for k in range(len(closures.node)):
        first, second = 6 * closures.place[k, 0], 6 * closures.place[k, 1]
        for i in range(closures.ptr[k], closures.ptr[k + 1]):
            for c in range(6):
                if first >= 0:
                    matrix[first + c, i] += data.closed.wrench[i, c]
                if second >= 0:
                    matrix[second + c, i] -= data.closed.wrench[i, c]
