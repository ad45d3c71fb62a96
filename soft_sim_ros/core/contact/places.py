"""Places on bodies that touch one another: stations, and what is nearest to them on a cell.

A rod is, between two nodes, the cubic curve that passes through both along their axes, with a
radius that is a cubic too. So it has no kinks, and all of it is a function of the two nodes: a
place is Σ w p + R o over them, in which w and o depend on where along the curve it is.
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
    mul,
    scale,
    sub,
    transpose,
)
from soft_sim_ros.core.backend.jit import kernel, unit
from soft_sim_ros.core.model.pairs import CURVE, STICK

from .shapes import distance

TINY = 1e-300
ROUNDS = 60
AXIS = (1.0, 0.0, 0.0)


@kernel
def cubic(t):
    """Return the four functions of Hermite: values and slopes at both ends."""
    u = 1.0 - t
    return (1.0 + 2.0 * t) * u * u, t * t * (3.0 - 2.0 * t), t * u * u, -t * t * u


@kernel
def cubic_slope(t):
    """Return their derivatives."""
    a = 6.0 * t * (1.0 - t)
    return -a, a, (1.0 - t) * (1.0 - 3.0 * t), t * (3.0 * t - 2.0)


@kernel
def cubic_bend(t):
    """Return their second derivatives."""
    return 12.0 * t - 6.0, 6.0 - 12.0 * t, 6.0 * t - 4.0, 6.0 * t - 2.0


@kernel
def axis_at(data, node, length):
    """Return the axis of a node in base axes, times a length."""
    r = data.rotation[node]
    return (length * r[0], length * r[3], length * r[6])


@kernel
def mixed(h, p0, p1, a0, a1):
    """Return the sum of values and slopes of both ends, weighed by h (4,)."""
    x = add(scale(h[0], p0), scale(h[1], p1))
    return add(x, add(scale(h[2], a0), scale(h[3], a1)))


@kernel
def station_place(model, data, q):
    """Return the centre of station q in the base frame."""
    pairs = model.pairs
    c = pairs.cell[q]
    one, two = pairs.node[c, 0], pairs.node[c, 1]
    arm = load_vec(pairs.arm[q])
    at = scale(pairs.weight[q, 0], load_vec(data.position[one]))
    at = add(at, apply(load_mat(data.rotation[one]), arm))
    if two != one:
        at = add(at, scale(pairs.weight[q, 1], load_vec(data.position[two])))
        other = load_vec(pairs.arm[q, 3:])
        at = add(at, apply(load_mat(data.rotation[two]), other))
    return at


@kernel
def curve_ends(model, data, c):
    """Return places and slopes (along the curve's parameter) of both ends of a CURVE."""
    pairs = model.pairs
    one, two, length = pairs.node[c, 0], pairs.node[c, 1], pairs.size[c, 0]
    p0, p1 = load_vec(data.position[one]), load_vec(data.position[two])
    return p0, p1, axis_at(data, one, length), axis_at(data, two, length)


@kernel
def stick_ends(model, data, c):
    """Return both ends of a STICK."""
    pairs = model.pairs
    node = pairs.node[c, 0]
    rotation, p = load_mat(data.rotation[node]), load_vec(data.position[node])
    p0 = add(p, apply(rotation, load_vec(pairs.centre[c])))
    return p0, add(p, apply(rotation, load_vec(pairs.far[c])))


@kernel
def radius_at(taper, t):
    """Return the radius of a cell at t."""
    h = cubic(t)
    return h[0] * taper[0] + h[1] * taper[1] + h[2] * taper[2] + h[3] * taper[3]


@kernel
def radius_slope(h, taper):
    """Return the derivative of the radius, or its second one, of those of the cubic."""
    return h[0] * taper[0] + h[1] * taper[1] + h[2] * taper[2] + h[3] * taper[3]


@kernel
def opening(x, p0, p1, a0, a1, taper, t):
    """Return how the gap between x and a curve grows along t, and how that grows."""
    slope, bend = cubic_slope(t), cubic_bend(t)
    d = sub(x, mixed(cubic(t), p0, p1, a0, a1))
    size = max(math.sqrt(dot(d, d)), TINY)
    n = scale(1.0 / size, d)
    c1, c2 = mixed(slope, p0, p1, a0, a1), mixed(bend, p0, p1, a0, a1)
    along = dot(n, c1)
    grows = (dot(c1, c1) - along * along) / size - dot(n, c2) - radius_slope(bend, taper)
    return -along - radius_slope(slope, taper), grows


@unit
def nearest_on_curve(model, data, c, x):
    """Return where on a CURVE the gap to x is least, −1 if it is at an end that goes on.

    Within a cell there is one place at most: cells are short. An end belongs to the cell before.
    """
    pairs = model.pairs
    taper = pairs.taper[c]
    p0, p1, a0, a1 = curve_ends(model, data, c)
    low, _ = opening(x, p0, p1, a0, a1, taper, 0.0)
    if low >= 0.0:
        return 0.0 if pairs.end[c, 0] != 0 else -1.0
    high, _ = opening(x, p0, p1, a0, a1, taper, 1.0)
    if high < 0.0:
        return 1.0 if pairs.end[c, 1] != 0 else -1.0
    below, above = 0.0, 1.0
    t = low / (low - high)
    for _ in range(ROUNDS):
        f, slope = opening(x, p0, p1, a0, a1, taper, t)
        if f < 0.0:
            below = t
        else:
            above = t
        new = t - f / slope if slope > 0.0 else 0.5 * (below + above)
        if not below <= new <= above:
            new = 0.5 * (below + above)
        moved = abs(new - t)
        t = new
        if moved <= 1e-15:
            break
    return t


@kernel
def nearest_on_stick(model, data, c, x):
    """Return where on a STICK x is nearest to, between 0 and 1."""
    p0, p1 = stick_ends(model, data, c)
    e = sub(p1, p0)
    size = dot(e, e)
    return min(1.0, max(0.0, dot(sub(x, p0), e) / size)) if size > 0.0 else 0.0


@kernel
def distance_to(model, data, c, x):
    """Return d, n, H of a cell that is a shape, at x in the base frame."""
    node = model.pairs.node[c, 0]
    rotation = load_mat(data.rotation[node])
    own = apply_t(rotation, sub(x, load_vec(data.position[node])))
    d, n, curved = distance(model.pairs, c, own)
    return d, apply(rotation, n), mul(rotation, mul(curved, transpose(rotation)))


@kernel
def gap_of(model, data, c, x, radius):
    """Return gap of a ball to a cell, its normal, and where on the cell (−1: not here)."""
    kind = model.pairs.kind[c]
    if kind == CURVE:
        t = nearest_on_curve(model, data, c, x)
        if t < 0.0:
            return math.inf, AXIS, t
        p0, p1, a0, a1 = curve_ends(model, data, c)
        d = sub(x, mixed(cubic(t), p0, p1, a0, a1))
    elif kind == STICK:
        t = nearest_on_stick(model, data, c, x)
        p0, p1 = stick_ends(model, data, c)
        d = sub(x, add(p0, scale(t, sub(p1, p0))))
    else:
        off, n, _ = distance_to(model, data, c, x)
        return off - radius, n, 0.0
    size = math.sqrt(dot(d, d))
    n = scale(1.0 / size, d) if size > TINY else AXIS
    return size - radius - radius_at(model.pairs.taper[c], t), n, t


@kernel
def pair_motion(w, a, arm, data, node):
    """Return arm of a node in base axes, and what it adds to place, velocity and spin."""
    rotation = load_mat(data.rotation[node])
    b = apply(rotation, arm)
    omega = apply(rotation, load_vec(data.eta[node]))
    v = apply(rotation, load_vec(data.eta[node, 3:]))
    u = add(scale(w, v), cross(omega, b))
    return b, add(scale(w, load_vec(data.position[node])), b), u, scale(a, omega)
