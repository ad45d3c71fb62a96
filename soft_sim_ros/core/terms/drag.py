"""What resists or lifts a body in a flow, as functions of its velocity relative to the fluid."""

import math

from soft_sim_ros.core.algebra.dual import add, cross, dot, madd, mscale, outer, scale, skew
from soft_sim_ros.core.backend.jit import algebra, kernel


@algebra
def times(d, a):
    """Return the components of a, each times that of d."""
    return (d[0] * a[0], d[1] * a[1], d[2] * a[2])


@algebra
def rows_by(d, m):
    """Return diag(d) times a matrix m."""
    return (
        d[0] * m[0], d[0] * m[1], d[0] * m[2],
        d[1] * m[3], d[1] * m[4], d[1] * m[5],
        d[2] * m[6], d[2] * m[7], d[2] * m[8],
    )  # fmt: skip


@algebra
def diagonal(d):
    """Return the matrix diag(d)."""
    return (d[0], 0.0, 0.0, 0.0, d[1], 0.0, 0.0, 0.0, d[2])


@kernel
def resistance(quadratic, viscous, split, v):
    """Return what resists a velocity v: all three by their common speed, or (split) x by its own.

    The wrench is quadratic · |v| v + viscous · v, along each axis.
    """
    if split:
        along, across = abs(v[0]), math.sqrt(v[1] * v[1] + v[2] * v[2])
        speed = (along, across, across)
    else:
        whole = math.sqrt(dot(v, v))
        speed = (whole, whole, whole)
    return add(times(quadratic, times(speed, v)), times(viscous, v))


@kernel
def resistance_slope(quadratic, viscous, split, v):
    """Return the derivative of ``resistance`` by v."""
    if split:
        along, across = abs(v[0]), math.sqrt(v[1] * v[1] + v[2] * v[2])
        speed = (2.0 * along, across, across)
        e, size = (0.0, v[1], v[2]), across
    else:
        size = math.sqrt(dot(v, v))
        speed, e = (size, size, size), v
    out = diagonal(add(times(quadratic, speed), viscous))
    if size > 0.0:
        out = madd(out, mscale(1.0 / size, outer(times(quadratic, e), e)))
    return out


@kernel
def lifting(lift, v):
    """Return the lift |v| v × lift: across the velocity v, so that it does no work on it."""
    return scale(math.sqrt(dot(v, v)), cross(v, lift))


@kernel
def lifting_slope(lift, v):
    """Return the derivative of ``lifting`` by v."""
    size = math.sqrt(dot(v, v))
    out = mscale(-size, skew(lift))
    if size > 0.0:
        out = madd(out, mscale(1.0 / size, outer(cross(v, lift), v)))
    return out
