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
def across_of(quadratic, v):
    """Return what resists a flow across a rod besides its friction, and the velocity across."""
    friction = quadratic[0]
    return (0.0, quadratic[1] - friction, quadratic[2] - friction), (0.0, v[1], v[2])


@kernel
def resistance(quadratic, viscous, split, v):
    """Return what resists a velocity v: quadratic · |v| v + viscous · v, along each axis.

    split: of a rod along x. Friction is the same in all directions, and the rest of what resists
    across goes with the speed across (Taylor 1952).
    """
    speed = math.sqrt(dot(v, v))
    if not split:
        return times(add(scale(speed, quadratic), viscous), v)
    rest, n = across_of(quadratic, v)
    own = scale(math.sqrt(dot(n, n)), times(rest, n))
    return add(own, add(scale(quadratic[0] * speed, v), times(viscous, v)))


@kernel
def resistance_slope(quadratic, viscous, split, v):
    """Return the derivative of ``resistance`` by v."""
    if not split:
        return madd(diagonal(viscous), slope_of(quadratic, v))
    rest, n = across_of(quadratic, v)
    friction = (quadratic[0], quadratic[0], quadratic[0])
    return madd(diagonal(viscous), madd(slope_of(friction, v), slope_of(rest, n)))


@kernel
def slope_of(d, v):
    """Return the derivative of diag(d) |v| v by v."""
    speed = math.sqrt(dot(v, v))
    out = diagonal(scale(speed, d))
    if speed > 0.0:
        out = madd(out, mscale(1.0 / speed, outer(times(d, v), v)))
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
