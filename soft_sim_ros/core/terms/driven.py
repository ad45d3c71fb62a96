"""Driven coordinates: known functions of time, with their rates and accelerations.

A program works on a stack of jets (value, first and second derivative by t), so a formula comes
with its exact derivatives. A driven coordinate leaves Newton's method: its correction is zero, and
its row of the residual is the force that it takes to drive it.
"""

import math

import numpy as np

from soft_sim_ros.core.algebra.search import row_of
from soft_sim_ros.core.backend.jit import bare, kernel, unit

NAMES = (
    "number", "t", "+", "-", "*", "/", "**", "negative", "sin", "cos", "tan", "exp", "log",
    "sqrt", "sinh", "cosh", "tanh", "atan",
)  # fmt: skip
OPERATIONS = {name: i for i, name in enumerate(NAMES)}
NUMBER, TIME, PLUS, MINUS, TIMES, OVER, POWER, NEGATIVE = range(8)
SIN, COS, TAN, EXP, LOG, SQRT, SINH, COSH, TANH, ATAN = range(8, 18)
TABLE, COMMANDED = len(NAMES), len(NAMES) + 1
# columns of Live.course
SINCE, LASTS, COURSE, RATE = 0, 1, 2, 8
DEEPEST = 64  # of the stack: formulas nest less deeply
# What the diagonal of a driven coordinate is multiplied by: its row then says that it keeps still.
HELD = 1e30


@kernel
def product(x, y):
    """Return the jet of a product."""
    return x[0] * y[0], x[1] * y[0] + x[0] * y[1], x[2] * y[0] + 2.0 * x[1] * y[1] + x[0] * y[2]


@kernel
def chained(x, f, f1, f2):
    """Return the jet of f(x), given f and its derivatives at x[0]."""
    return f, f1 * x[1], f2 * x[1] * x[1] + f1 * x[2]


@kernel
def power(x, y):
    """Return the jet of x to the power of y."""
    if y[1] == 0.0 and y[2] == 0.0:
        c = y[0]
        first = c * x[0] ** (c - 1.0) if c != 0.0 else 0.0
        second = c * (c - 1.0) * x[0] ** (c - 2.0) if c != 0.0 and c != 1.0 else 0.0
        return chained(x, x[0] ** c, first, second)
    log = chained(x, math.log(x[0]), 1.0 / x[0], -1.0 / (x[0] * x[0]))
    z = product(y, log)
    e = math.exp(z[0])
    return chained(z, e, e, e)


@kernel
def of_function(which, x):
    """Return the jet of a function of x."""
    u = x[0]
    if which == SIN:
        return chained(x, math.sin(u), math.cos(u), -math.sin(u))
    if which == COS:
        return chained(x, math.cos(u), -math.sin(u), -math.cos(u))
    if which == TAN:
        f = math.tan(u)
        return chained(x, f, 1.0 + f * f, 2.0 * f * (1.0 + f * f))
    if which == EXP:
        f = math.exp(u)
        return chained(x, f, f, f)
    if which == LOG:
        return chained(x, math.log(u), 1.0 / u, -1.0 / (u * u))
    if which == SQRT:
        f = math.sqrt(u)
        return chained(x, f, 0.5 / f, -0.25 / (f * u))
    if which == SINH:
        return chained(x, math.sinh(u), math.cosh(u), math.sinh(u))
    if which == COSH:
        return chained(x, math.cosh(u), math.sinh(u), math.cosh(u))
    if which == TANH:
        f = math.tanh(u)
        return chained(x, f, 1.0 - f * f, -2.0 * f * (1.0 - f * f))
    d = 1.0 / (1.0 + u * u)
    return chained(x, math.atan(u), d, -2.0 * u * d * d)


@kernel
def of_table(table, first, last, t):
    """Return the jet of the cubics in rows ``first`` … ``last`` − 1 at time t in s."""
    row = row_of(table, first, last, t)
    c1, c2, c3, c4 = table[row, 1], table[row, 2], table[row, 3], table[row, 4]
    if c2 == 0.0 and c3 == 0.0 and c4 == 0.0:
        return c1, 0.0, 0.0
    x = t - table[row, 0]
    return (
        c1 + x * (c2 + x * (c3 + x * c4)),
        c2 + x * (2.0 * c3 + x * 3.0 * c4),
        2.0 * c3 + 6.0 * x * c4,
    )


@kernel
def of_course(course, d, t):
    """Return the jet of what driven coordinate d was last commanded, at time t in s."""
    lasts, since = course[d, LASTS], t - course[d, SINCE]
    if not since < lasts:
        end = 0.0
        for i in range(6):
            end += course[d, COURSE + i]
        return end + course[d, RATE] * (since - lasts), course[d, RATE], 0.0
    x = since / lasts
    p, p1, p2 = 0.0, 0.0, 0.0
    for i in range(5, -1, -1):  # Horner's rule, with its derivatives
        p2 = p2 * x + 2.0 * p1
        p1 = p1 * x + p
        p = p * x + course[d, COURSE + i]
    return p, p1 / lasts, p2 / (lasts * lasts)


@unit
def known_motion(drives, course, d, t, out):
    """Fill out (3,) with position, rate and acceleration of driven coordinate d at time t in s."""
    out = bare(out)
    stack = np.zeros((DEEPEST, 3))
    top = -1
    for i in range(drives.ptr[d], drives.ptr[d + 1]):
        which = drives.operation[i]
        if which == NUMBER:
            top += 1
            jet = (drives.operand[i], 0.0, 0.0)
        elif which == TIME:
            top += 1
            jet = (t, 1.0, 0.0)
        elif which == TABLE:
            top += 1
            k = int(drives.operand[i])
            jet = of_table(drives.table, drives.table_ptr[k], drives.table_ptr[k + 1], t)
        elif which == COMMANDED:
            top += 1
            jet = of_course(course, d, t)
        else:
            x = (stack[top, 0], stack[top, 1], stack[top, 2])
            if which == NEGATIVE:
                jet = (-x[0], -x[1], -x[2])
            elif which >= SIN:
                jet = of_function(which, x)
            else:
                top -= 1
                y, x = x, (stack[top, 0], stack[top, 1], stack[top, 2])
                if which == PLUS:
                    jet = (x[0] + y[0], x[1] + y[1], x[2] + y[2])
                elif which == MINUS:
                    jet = (x[0] - y[0], x[1] - y[1], x[2] - y[2])
                elif which == TIMES:
                    jet = product(x, y)
                elif which == OVER:
                    r = 1.0 / y[0]
                    jet = product(x, chained(y, r, -r * r, 2.0 * r * r * r))
                else:
                    jet = power(x, y)
        stack[top, 0], stack[top, 1], stack[top, 2] = jet[0], jet[1], jet[2]
    out[0], out[1], out[2] = stack[0, 0], stack[0, 1], stack[0, 2]


@unit
def known_motions(drives, course, t, out):
    """Fill the first three columns of out (D, 4) with what all driven coordinates do at t in s."""
    out = bare(out)
    for d in range(len(drives.column)):
        known_motion(drives, course, d, t, out[d])


@unit
def bring(drives, course, t, q, v):
    """Set driven coordinates and rates among q, v (≥ n,) to what they are told at t in s."""
    q, v = bare(q), bare(v)
    now = np.zeros(3)
    for d in range(len(drives.column)):
        known_motion(drives, course, d, t, now)
        q[drives.column[d]], v[drives.column[d]] = now[0], now[1]


@kernel
def follow_drives(model, data, work):
    """Set driven coordinates of a stage to what they are told."""
    for d in range(len(model.driven)):
        c = model.driven[d, 0]
        work.q[c], work.v[c], work.a[c] = data.driven[d, 0], data.driven[d, 1], data.driven[d, 2]


@kernel
def leave_out(model, residual):
    """Take driven coordinates out of a residual (n,)."""
    for d in range(len(model.driven)):
        residual[model.driven[d, 0]] = 0.0


@kernel
def note_forces(model, data, residual):
    """Note the forces that it takes: the residual (n,) of driven coordinates."""
    for d in range(len(model.driven)):
        data.driven[d, 3] = residual[model.driven[d, 0]]


@unit
def hold_still(model, system):
    """Let the matrix of a system say that driven coordinates keep still."""
    for d in range(len(model.driven)):
        c, b = model.driven[d, 0], model.driven[d, 1]
        begin, end = model.block_col[b], model.block_col[b + 1]
        at = system.offset[b] + (c - begin) * (end - begin + 1)
        system.diagonal[at] = HELD * max(1.0, abs(system.diagonal[at]))


@kernel
def drive_power(data):
    """Return the power in W that drives put into the arm."""
    total = 0.0
    for d in range(len(data.driven)):
        total += data.driven[d, 3] * data.driven[d, 1]
    return total
