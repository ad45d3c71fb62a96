"""Signed distances to shapes, with their first two derivatives.

Of a point x outside, d is the distance to the nearest point of the surface, n = ∇d the unit vector
from there to x, and H = ∇²d the curvature of the surface at distance d. Inside d is negative. With
the sign −1 a shape is hollow, and bodies are inside: all three change their sign.

Shapes of revolution have their axis along z. A plane is z = 0, its free side above.
"""

import math

from soft_sim_ros.core.algebra.dual import (
    apply,
    apply_t,
    dot,
    load_mat,
    load_vec,
    madd,
    mscale,
    mul,
    outer,
    scale,
    spherical,
    sub,
    transpose,
)
from soft_sim_ros.core.backend.jit import bare, kernel, unit
from soft_sim_ros.core.model.contact import BOX, CAPSULE, CYLINDER, PLANE, SPHERE

UP = (0.0, 0.0, 1.0)
NOTHING = 1e-300  # a length: what is nearer to an axis has no direction
ROUNDS = 60


@kernel
def of_ball(x, radius):
    """Return d, n, H of a ball about the origin."""
    r = math.sqrt(dot(x, x))
    n = scale(1.0 / r, x) if r > NOTHING else UP
    curved = mscale(1.0 / max(r, NOTHING), madd(spherical(1.0), mscale(-1.0, outer(n, n))))
    return r - radius, n, curved


@kernel
def of_rod(x, radius):
    """Return d, n, H of an endless cylinder along z."""
    r = math.sqrt(x[0] * x[0] + x[1] * x[1])
    n = (x[0] / r, x[1] / r, 0.0) if r > NOTHING else (1.0, 0.0, 0.0)
    t = (-n[1], n[0], 0.0)
    return r - radius, n, mscale(1.0 / max(r, NOTHING), outer(t, t))


@kernel
def of_cylinder(x, radius, half):
    """Return d, n, H of a cylinder with flat ends."""
    side, n, curved = of_rod(x, radius)
    sign = 1.0 if x[2] >= 0.0 else -1.0
    top = sign * x[2] - half
    if side > 0.0 and top > 0.0:  # nearest to the rim
        d = math.sqrt(side * side + top * top)
        m = (side / d * n[0], side / d * n[1], sign * top / d)
        across = (sign * top / d * n[0], sign * top / d * n[1], -side / d)
        t = (-n[1], n[0], 0.0)
        round_it = side / d / (side + radius)
        return d, m, madd(mscale(1.0 / d, outer(across, across)), mscale(round_it, outer(t, t)))
    if top > side:
        return top, (0.0, 0.0, sign), spherical(0.0)
    return side, n, curved


@kernel
def of_box(x, size):
    """Return d, n, H of a box with half edges ``size``."""
    sx, sy, sz = math.copysign(1.0, x[0]), math.copysign(1.0, x[1]), math.copysign(1.0, x[2])
    q = (abs(x[0]) - size[0], abs(x[1]) - size[1], abs(x[2]) - size[2])
    if q[0] <= 0.0 and q[1] <= 0.0 and q[2] <= 0.0:
        if q[0] >= q[1] and q[0] >= q[2]:
            return q[0], (sx, 0.0, 0.0), spherical(0.0)
        if q[1] >= q[2]:
            return q[1], (0.0, sy, 0.0), spherical(0.0)
        return q[2], (0.0, 0.0, sz), spherical(0.0)
    a, b, c = q[0] > 0.0, q[1] > 0.0, q[2] > 0.0
    w = (q[0] if a else 0.0, q[1] if b else 0.0, q[2] if c else 0.0)
    d = math.sqrt(dot(w, w))
    n = (sx * w[0] / d, sy * w[1] / d, sz * w[2] / d)
    ea, eb, ec = 1.0 if a else 0.0, 1.0 if b else 0.0, 1.0 if c else 0.0
    free = (ea, 0.0, 0.0, 0.0, eb, 0.0, 0.0, 0.0, ec)
    return d, n, mscale(1.0 / d, madd(free, mscale(-1.0, outer(n, n))))


@kernel
def nearest(x, size):
    """Return t with Σ (aᵢ xᵢ / (aᵢ² + t))² = 1: the nearest point is aᵢ² xᵢ / (aᵢ² + t)."""
    least = min(size[0], min(size[1], size[2]))
    longest = max(size[0], max(size[1], size[2]))
    # the root lies above where the nearest pole ends and below where all terms are small
    low = -least * least + 1e-14 * least * least
    high = longest * math.sqrt(dot(x, x)) + longest * longest
    t = 0.0
    for _ in range(ROUNDS):
        f, slope = -1.0, 0.0
        for i in range(3):
            a2 = size[i] * size[i]
            part = size[i] * x[i] / (a2 + t)
            f += part * part
            slope -= 2.0 * part * part / (a2 + t)
        if f > 0.0:
            low = t
        else:
            high = t
        # f is convex and falls: Newton's method, kept between the bounds
        new = t - f / slope if slope < 0.0 else 0.5 * (low + high)
        if not low <= new <= high:
            new = 0.5 * (low + high)
        if abs(new - t) <= 1e-15 * least * least + 1e-16 * abs(t):
            t = new
            break
        t = new
    return t


@kernel
def of_ellipsoid(x, size):
    """Return d, n, H of an ellipsoid: by its nearest point, to round-off."""
    t = nearest(x, size)
    a2, b2, c2 = size[0] * size[0], size[1] * size[1], size[2] * size[2]
    y = (a2 * x[0] / (a2 + t), b2 * x[1] / (b2 + t), c2 * x[2] / (c2 + t))
    g = (y[0] / a2, y[1] / b2, y[2] / c2)
    length = math.sqrt(dot(g, g))
    n = scale(1.0 / length, g)
    d = dot(n, sub(x, y))
    # W of the surface at y, then at the distance d along the normal: W (1 + d W)⁻¹
    cut = madd(spherical(1.0), mscale(-1.0, outer(n, n)))
    own = (1.0 / a2, 0.0, 0.0, 0.0, 1.0 / b2, 0.0, 0.0, 0.0, 1.0 / c2)
    bend = mscale(1.0 / length, mul(cut, mul(own, cut)))
    return d, n, mul(bend, inverse(madd(spherical(1.0), mscale(d, bend))))


@kernel
def inverse(m):
    """Return the inverse of a matrix (3, 3)."""
    c = (
        m[4] * m[8] - m[5] * m[7],
        m[2] * m[7] - m[1] * m[8],
        m[1] * m[5] - m[2] * m[4],
        m[5] * m[6] - m[3] * m[8],
        m[0] * m[8] - m[2] * m[6],
        m[2] * m[3] - m[0] * m[5],
        m[3] * m[7] - m[4] * m[6],
        m[1] * m[6] - m[0] * m[7],
        m[0] * m[4] - m[1] * m[3],
    )
    return mscale(1.0 / (m[0] * c[0] + m[1] * c[3] + m[2] * c[6]), c)


@kernel
def distance(contact, s, point):
    """Return d, n, H of shape s at a point of the base frame."""
    rotation, size = load_mat(contact.rotation[s]), load_vec(contact.size[s])
    x = apply_t(rotation, sub(point, load_vec(contact.centre[s])))
    kind = contact.kind[s]
    if kind == PLANE:
        d, n, curved = x[2], UP, spherical(0.0)
    elif kind == SPHERE:
        d, n, curved = of_ball(x, size[0])
    elif kind == CAPSULE:
        beyond = abs(x[2]) > size[1]
        if beyond:
            d, n, curved = of_ball((x[0], x[1], x[2] - math.copysign(size[1], x[2])), size[0])
        else:
            d, n, curved = of_rod(x, size[0])
    elif kind == CYLINDER:
        d, n, curved = of_cylinder(x, size[0], size[1])
    elif kind == BOX:
        d, n, curved = of_box(x, size)
    else:
        d, n, curved = of_ellipsoid(x, size)
    sign = contact.sign[s]
    turned = mul(rotation, mul(curved, transpose(rotation)))
    return sign * d, scale(sign, apply(rotation, n)), mscale(sign, turned)


@unit
def distances(contact, s, points, out):
    """Fill out (N, 13) with d, n, H by rows of shape s at points (N, 3) of the base frame."""
    points, out = bare(points), bare(out)
    for i in range(len(points)):
        d, n, curved = distance(contact, s, load_vec(points[i]))
        out[i, 0] = d
        for c in range(3):
            out[i, 1 + c] = n[c]
        for c in range(9):
            out[i, 4 + c] = curved[c]
