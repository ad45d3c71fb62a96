"""Exponential of SE(3), its tangent map T, and the derivatives of T that are needed.

For Ω = ω + εv and x = Ω·Ω: exp Ω = 1 + c₁ Ω× + c₂ Ω×Ω×,  T(Ω) = c₁ 1 − c₂ Ω× + c₃ ΩΩᵀ  (g⁻¹dg =
T(Ω) dΩ), with the
Stumpff functions c_k(x) = Σ_j (−x)^j / (2j+k)!. They obey c_k = 1/k! − x c_{k+2} and dc_k/dx = (k
c_{k+2} − c_{k+1})/2, so
formulas built on them need no special case for small or large angles.
"""

import math

from soft_sim_ros.core.backend.jit import algebra

from .dual import (
    add,
    cross,
    dadd,
    dcross,
    ddot,
    dmadd,
    dmscale,
    dot,
    douter,
    dscale,
    dskew,
    dspherical,
    dsub,
    madd,
    mscale,
    outer,
    rmscale,
    rscale,
    sadd,
    scale,
    skew,
    smul,
    spherical,
)
from .simd import WIDTH, keep_one, lane, largest_lane, one

# Above this squared angle, beyond half a turn, the trigonometric start is accurate; below it the
# series of c8 and c9 converges fast.
SERIES_LIMIT = 10.0
TERMS = 13
EVEN = tuple(1.0 / ((2 * j + 7) * (2 * j + 8)) for j in range(TERMS + 1))
ODD = tuple(1.0 / ((2 * j + 8) * (2 * j + 9)) for j in range(TERMS + 1))


@algebra
def series(x, largest):
    """Return (c0 … c9) of numbers or lanes 0 ≤ x ≤ largest < SERIES_LIMIT."""
    # Horner form of the alternating series; as many terms as round-off at the largest asks for
    terms = 3 if largest < 1e-3 else (5 if largest < 0.1 else (8 if largest < 1.0 else TERMS))
    c8, c9 = 1.0 - x * EVEN[terms], 1.0 - x * ODD[terms]
    for j in range(terms - 1, 0, -1):
        c8 = 1.0 - x * EVEN[j] * c8
        c9 = 1.0 - x * ODD[j] * c9
    c8, c9 = c8 * (1.0 / 40320.0), c9 * (1.0 / 362880.0)
    c7 = 1.0 / 5040.0 - x * c9
    c6 = 1.0 / 720.0 - x * c8
    c5 = 1.0 / 120.0 - x * c7
    c4 = 1.0 / 24.0 - x * c6
    c3 = 1.0 / 6.0 - x * c5
    c2 = 0.5 - x * c4
    return (1.0 - x * c2, 1.0 - x * c3, c2, c3, c4, c5, c6, c7, c8, c9)


@algebra
def stumpff(x):
    """Return (c0 … c9)(x) for x ≥ 0."""
    if x < SERIES_LIMIT:
        return series(x, x)
    angle = math.sqrt(x)
    c0 = math.cos(angle)
    c1 = math.sin(angle) / angle
    c2 = (1.0 - c0) / x
    c3 = (1.0 - c1) / x
    c4 = (0.5 - c2) / x
    c5 = (1.0 / 6.0 - c3) / x
    c6 = (1.0 / 24.0 - c4) / x
    c7 = (1.0 / 120.0 - c5) / x
    c8 = (1.0 / 720.0 - c6) / x
    c9 = (1.0 / 5040.0 - c7) / x
    return (c0, c1, c2, c3, c4, c5, c6, c7, c8, c9)


@algebra
def stumpff_lanes(x, out, b):
    """Keep (c0 … c9) of four x ≥ 0 in row b of out (…, 40).

    The largest x selects the method for all four; the others may differ in round-off from
    ``stumpff`` of them alone.
    """
    largest = largest_lane(x)
    if largest < SERIES_LIMIT:
        c = series(x, largest)
        for j in range(10):
            keep_one(out, b, WIDTH * j, c[j])
    else:
        for i in range(WIDTH):
            alone = stumpff(lane(x, i))
            for j in range(10):
                out[b, WIDTH * j + i] = alone[j]


@algebra
def kept_stumpff(out, b):
    """Return what ``stumpff_lanes`` kept in row b."""
    return (
        one(out, b, 0), one(out, b, 4), one(out, b, 8), one(out, b, 12), one(out, b, 16),
        one(out, b, 20), one(out, b, 24), one(out, b, 28), one(out, b, 32), one(out, b, 36),
    )  # fmt: skip


@algebra
def first(k, c):
    """Return dc_k/dx."""
    return 0.5 * (k * c[k + 2] - c[k + 1])


@algebra
def second(k, c):
    """Return d²c_k/dx²."""
    return 0.5 * (k * first(k + 2, c) - first(k + 1, c))


@algebra
def third(k, c):
    """Return d³c_k/dx³."""
    return 0.5 * (k * second(k + 2, c) - second(k + 1, c))


@algebra
def rotation_exp(w, c):
    """Return exp(w×) as a matrix; c = stumpff(w·w)."""
    return madd(spherical(c[0]), madd(mscale(c[1], skew(w)), mscale(c[2], outer(w, w))))


@algebra
def exp_translation(w, v, c):
    """Return the translation of exp(w + εv); c = stumpff(w·w)."""
    return add(add(scale(c[1], v), scale(c[2], cross(w, v))), scale(c[3] * dot(w, v), w))


@algebra
def tangent_apply(o, u, z, c):
    """Return T(Ω)Ω̇ and its rate for the dual vectors Ω = o, Ω̇ = u, Ω̈ = z; c = stumpff(ω·ω)."""
    x1 = 2.0 * dot(o[0], o[1])
    a = (c[1], first(1, c) * x1)
    b = (c[2], first(2, c) * x1)
    g = (c[3], first(3, c) * x1)
    y = ddot(o, u)
    y_rate = sadd(ddot(u, u), ddot(o, z))
    x_rate = (2.0 * y[0], 2.0 * y[1])
    a_rate = smul((first(1, c), second(1, c) * x1), x_rate)
    b_rate = smul((first(2, c), second(2, c) * x1), x_rate)
    g_rate = smul((first(3, c), second(3, c) * x1), x_rate)
    gy = smul(g, y)
    ou = dcross(o, u)
    velocity = dadd(dsub(dscale(a, u), dscale(b, ou)), dscale(gy, o))
    rate = dadd(dscale(sadd(a_rate, gy), u), dscale(a, z))
    rate = dsub(rate, dadd(dscale(b_rate, ou), dscale(b, dcross(o, z))))
    rate = dadd(rate, dscale(sadd(smul(g_rate, y), smul(g, y_rate)), o))
    return velocity, rate


@algebra
def cotangent_apply(o, f, c):
    """Return T(Ω)ᵀΛ for the wrench f = N + εM: the force dual to Ω."""
    x1 = 2.0 * dot(o[0], o[1])
    a = (c[1], first(1, c) * x1)
    b = (c[2], first(2, c) * x1)
    g = (c[3], first(3, c) * x1)
    return dadd(dadd(dscale(a, f), dscale(b, dcross(o, f))), dscale(smul(g, ddot(o, f)), o))


@algebra
def cotangent_derivative(o, f, c):
    """Return the dual matrix Q with d(T(Ω)ᵀΛ) = Q dΩ at fixed Λ."""
    x1 = 2.0 * dot(o[0], o[1])
    b = (c[2], first(2, c) * x1)
    g = (c[3], first(3, c) * x1)
    a2 = (2.0 * first(1, c), 2.0 * second(1, c) * x1)
    b2 = (2.0 * first(2, c), 2.0 * second(2, c) * x1)
    g2 = (2.0 * first(3, c), 2.0 * second(3, c) * x1)
    of = ddot(o, f)
    column = dadd(dscale(a2, f), dadd(dscale(b2, dcross(o, f)), dscale(smul(g2, of), o)))
    q = dmadd(douter(column, o), dmscale((-b[0], -b[1]), dskew(f)))
    return dmadd(q, dmscale(g, dmadd(dspherical(of), douter(o, f))))


@algebra
def tangent_map(o, c):
    """Return T(Ω) as a dual matrix."""
    x1 = 2.0 * dot(o[0], o[1])
    a = (c[1], first(1, c) * x1)
    b = (c[2], first(2, c) * x1)
    g = (c[3], first(3, c) * x1)
    return dmadd(dmadd(dspherical(a), dskew(dscale((-b[0], -b[1]), o))), dmscale(g, douter(o, o)))


@algebra
def tangent_jet(o, u, z, c):
    """Return T(Ω) and its first and second time derivatives as dual matrices."""
    x1 = 2.0 * dot(o[0], o[1])
    y = ddot(o, u)
    uu = sadd(ddot(u, u), ddot(o, z))
    x_rate = (2.0 * y[0], 2.0 * y[1])
    x_rate2 = (2.0 * uu[0], 2.0 * uu[1])
    square = smul(x_rate, x_rate)
    a1 = (first(1, c), second(1, c) * x1)
    b1 = (first(2, c), second(2, c) * x1)
    g1 = (first(3, c), second(3, c) * x1)
    a = (c[1], a1[0] * x1)
    b = (-c[2], -b1[0] * x1)
    g = (c[3], g1[0] * x1)
    a_rate = smul(a1, x_rate)
    b_rate = smul((-b1[0], -b1[1]), x_rate)
    g_rate = smul(g1, x_rate)
    a_rate2 = sadd(smul((second(1, c), third(1, c) * x1), square), smul(a1, x_rate2))
    b_rate2 = sadd(
        smul((-second(2, c), -third(2, c) * x1), square), smul((-b1[0], -b1[1]), x_rate2)
    )
    g_rate2 = sadd(smul((second(3, c), third(3, c) * x1), square), smul(g1, x_rate2))
    oo = douter(o, o)
    uo = dmadd(douter(u, o), douter(o, u))
    t = dmadd(dmadd(dspherical(a), dskew(dscale(b, o))), dmscale(g, oo))
    t1 = dmadd(dspherical(a_rate), dskew(dadd(dscale(b_rate, o), dscale(b, u))))
    t1 = dmadd(t1, dmadd(dmscale(g_rate, oo), dmscale(g, uo)))
    vector = dadd(dadd(dscale(b_rate2, o), rscale(2.0, dscale(b_rate, u))), dscale(b, z))
    t2 = dmadd(dspherical(a_rate2), dskew(vector))
    t2 = dmadd(t2, dmadd(dmscale(g_rate2, oo), rmscale(2.0, dmscale(g_rate, uo))))
    zo = dmadd(dmadd(douter(z, o), douter(o, z)), rmscale(2.0, douter(u, u)))
    return t, t1, dmadd(t2, dmscale(g, zo))
