"""Coulomb friction of a tendon in its channel: the capstan law, lumped between stations.

Between two stations the path turns by φ, and the tension drops to exp(−μ φ σ) of itself in the
direction in which the tendon slips through: u is the slip speed there, towards where it is pulled,
and σ = u/√(u² + v₀²) is a smooth sign of u. Sticking is thus a creep slower than v₀, and the loss
Σ (T₋ − T₊) u is never negative, whatever the motion.

data.station (P, 2, 4) holds, per station: rate of shortening in m/s, wrap in rad/m, tension in N,
and φ dσ/du of the passage before it.
"""

import math

import numpy as np

from soft_sim_ros.core.backend.jit import kernel, unit

from .tendons import ROOT3, add_length, add_length_rate, add_wrap, path_tangent, tangent_rate, wrap

SHORTENING, WRAP, TENSION, SLIPPERY = 0, 1, 2, 3


@kernel
def shares(half, g):
    """Return the arc lengths in m of a segment before and after station g that count to it."""
    near, far = half / ROOT3, half * (1.0 - 1.0 / ROOT3)
    return (far, near) if g == 0 else (near, far)


@kernel
def creep(speed, model, i):
    """Return σ and dσ/du of a slip speed u in m/s."""
    v0 = model.friction[i, 1]
    root = math.sqrt(speed * speed + v0 * v0)
    return speed / root, v0 * v0 / root**3


@unit
def capstan(model, data, i, tension):
    """Fill data.station for actuator i, pulled with a tension in N; return the loss in W."""
    station = data.station
    speed = 0.0
    for p in range(model.tendon_ptr[i], model.tendon_ptr[i + 1]):
        half = model.half[model.tendon_seg[p]]
        for g in range(2):
            t, norm, _ = path_tangent(model, data, p, g)
            rate = tangent_rate(model, data, p, g)
            station[p, g, SHORTENING] = (
                -half / norm * (t[0] * rate[0] + t[1] * rate[1] + t[2] * rate[2])
            )
            station[p, g, WRAP] = wrap(model, data, i, p, g)
            speed += station[p, g, SHORTENING]
    loss, carried = 0.0, 0.0
    for p in range(model.tendon_ptr[i], model.tendon_ptr[i + 1]):
        half = model.half[model.tendon_seg[p]]
        for g in range(2):
            before, after = shares(half, g)
            turn = carried + before * station[p, g, WRAP]
            carried = after * station[p, g, WRAP]
            sign, slope = creep(speed, model, i)
            beyond = tension * math.exp(-model.friction[i, 0] * turn * sign)
            loss += (tension - beyond) * speed
            tension = beyond
            station[p, g, TENSION] = tension
            station[p, g, SLIPPERY] = turn * slope
            speed -= station[p, g, SHORTENING]
    return loss


@unit
def capstan_tangent(model, data, i, alpha, first, system):
    """Add the change of friction with shape and rates to the system.

    The tension of a station depends on the wrap of all stations before it, and through the slip on
    the rates of all others. Within a block that is an entry of its diagonal block. Towards all
    blocks before, and towards all after, it is a product of two vectors: columns ``first``, … of
    the coupling (terms/couplings.py), two for every block but one.
    """
    n = system.left.shape[1]  # model.weight holds dashpots too
    mu = model.friction[i, 0]
    station = data.station
    # ∂(log T)/∂x, ∂(slip)/∂x and ∂(length) of one station, x = α₀ q + α₁ q̇
    change, slip, push = np.zeros(n), np.zeros(n), np.zeros(n)
    speed = 0.0
    begin, end = model.tendon_ptr[i], model.tendon_ptr[i + 1]
    for p in range(begin, end):
        for g in range(2):
            add_length_rate(model, data, p, g, alpha, -1.0, slip)
            speed += station[p, g, SHORTENING]
    below, above, last, steep = first - 2, first + 1, model.couple_ptr[i + 1], 0.0
    for p in range(begin, end):
        k = model.tendon_seg[p]
        b = model.seg_block[k]
        low, high = model.block_col[b], model.block_col[b + 1]
        m = high - low
        block = system.diagonal[system.offset[b] : system.offset[b + 1]].reshape((m, m))
        for g in range(2):
            sign, _ = creep(speed, model, i)
            if alpha[0] != 0.0:
                before, _ = shares(model.half[k], g)
                add_wrap(model, data, i, p, g, -alpha[0] * mu * sign * before, change)
                if p > begin or g > 0:
                    q, h = (p, 0) if g == 1 else (p - 1, 1)
                    _, after = shares(model.half[model.tendon_seg[q]], h)
                    add_wrap(model, data, i, q, h, -alpha[0] * mu * sign * after, change)
            steep -= mu * station[p, g, SLIPPERY]
            for j in range(n):
                change[j] -= mu * station[p, g, SLIPPERY] * slip[j]
            for j in range(low, high):
                push[j] = 0.0
            add_length(model, data, p, g, station[p, g, TENSION], push)
            for a in range(low, high):
                for j in range(low, high):
                    block[a - low, j - low] += push[a] * change[j]
                if below >= first:
                    system.left[below, a] += push[a]
                if above < last:
                    system.left[above, a] += steep * push[a]
            add_length_rate(model, data, p, g, alpha, 1.0, slip)
            speed -= station[p, g, SHORTENING]
        if p + 1 == end or model.seg_block[model.tendon_seg[p + 1]] != b:
            if below >= first:
                for j in range(low):
                    system.right[below, j] = change[j]
            if above < last:
                for j in range(high, n):
                    system.right[above, j] = slip[j]
            below, above = below + 2, above + 2
