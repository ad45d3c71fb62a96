"""One tendon (or chamber): its path through the deformed rod, its tension, their derivatives.

A station is a Gauss point of a segment that the path runs through: t = Γ + K × d + d' is the
tangent of the path per arc length of the rod, n its direction, and half |t| the length of path
that the station stands for. Everything is a function of the strain at the station, except the
wrap, which also needs its slope along the segment.
"""

import math

from soft_sim_ros.core.algebra.dual import add, cross, dot, load_twist, load_vec, scale, sub
from soft_sim_ros.core.backend.jit import bare, kernel, unit

ROOT3 = math.sqrt(3.0)


@kernel
def path_tangent(model, data, p, g):
    """Return the tangent t of station g of piece p, |t| and the offset d."""
    path = model.tendon_path[p, g]
    d, slope = load_vec(path[0]), load_vec(path[1])
    strain = load_twist(data.xi[model.tendon_seg[p], g, 0])
    t = add(add(strain[1], cross(strain[0], d)), slope)
    return t, dot(t, t) ** 0.5, d


@kernel
def tangent_rate(model, data, p, g):
    """Return ṫ of a station."""
    u = load_twist(data.xi[model.tendon_seg[p], g, 1])
    return add(u[1], cross(u[0], load_vec(model.tendon_path[p, g, 0])))


@kernel
def dual_of(d, w):
    """Return ∂(w·t)/∂ξ as six numbers: the wrench on the section of a force w at the offset d."""
    m = cross(d, w)
    return (m[0], m[1], m[2], w[0], w[1], w[2])


@unit
def tendon_motion(model, data, i):
    """Return length in m of the path of actuator i, and its rate in m/s."""
    length, rate = 0.0, 0.0
    for p in range(model.tendon_ptr[i], model.tendon_ptr[i + 1]):
        half = model.half[model.tendon_seg[p]]
        for g in range(2):
            t, norm, _ = path_tangent(model, data, p, g)
            length += half * norm
            rate += half / norm * dot(t, tangent_rate(model, data, p, g))
    return length, rate


@kernel
def pull(model, data, i):
    """Return tension in N of actuator i where it is pulled, and ∂/∂ℓ, ∂/∂ℓ̇ of it.

    The effort itself (of a chamber: −pressure × area), or, of a tendon whose length is commanded,
    max(0, k e + c ė) with the elongation e = ℓ − (ℓ₀ − what is pulled in): a tendon cannot push.
    """
    stiffness, damping = model.length_control[i, 0], model.length_control[i, 1]
    if stiffness == 0.0:
        return -model.tendon_gain[i] * data.effort[i], 0.0, 0.0
    length, rate = tendon_motion(model, data, i)
    tension = stiffness * (length - model.tendon_rest[i] + data.effort[i]) + damping * rate
    if tension > 0.0:
        return tension, stiffness, damping
    return 0.0, 0.0, 0.0


@kernel
def stretch_energy(model, data, i):
    """Return the energy in J stored in a tendon whose length is commanded."""
    if model.length_control[i, 0] == 0.0:
        return 0.0
    length, _ = tendon_motion(model, data, i)
    elongation = max(0.0, length - model.tendon_rest[i] + data.effort[i])
    return 0.5 * model.length_control[i, 0] * elongation**2


@kernel
def stretch_loss(model, data, i):
    """Return the power in W that such a tendon turns into heat by stretching: never negative."""
    if model.length_control[i, 0] == 0.0:
        return 0.0
    length, rate = tendon_motion(model, data, i)
    elongation = max(0.0, length - model.tendon_rest[i] + data.effort[i])
    return (pull(model, data, i)[0] - model.length_control[i, 0] * elongation) * rate


@kernel
def spread(model, k, g, factor, w, out):
    """Add factor w·∂ξ/∂q to out (n,): w belongs to the strain at Gauss point g of segment k."""
    for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
        out[model.entry_col[e]] += factor * model.entry_phi[e, g] * w[model.entry_comp[e]]


@kernel
def add_length(model, data, p, g, factor, out):
    """Add factor times ∂ℓ/∂q of one station to out (n,)."""
    k = model.tendon_seg[p]
    t, norm, d = path_tangent(model, data, p, g)
    spread(model, k, g, factor * model.half[k], dual_of(d, scale(1.0 / norm, t)), out)


@kernel
def add_length_rate(model, data, p, g, alpha, factor, out):
    """Add factor (α₀ ∂ℓ̇/∂q + α₁ ∂ℓ̇/∂q̇) of one station to out (n,)."""
    k = model.tendon_seg[p]
    t, norm, d = path_tangent(model, data, p, g)
    n = scale(1.0 / norm, t)
    rate = tangent_rate(model, data, p, g)
    across = scale(1.0 / norm, sub(rate, scale(dot(n, rate), n)))
    w = add(scale(alpha[0], across), scale(alpha[1], n))
    spread(model, k, g, factor * model.half[k], dual_of(d, w), out)


@kernel
def length_hessian(model, data, p, g, factor, hessian):
    """Fill the part of hessian (12, 12) of Gauss point g with factor times ∂²ℓ/∂ξ²."""
    t, norm, d = path_tangent(model, data, p, g)
    n = scale(1.0 / norm, t)
    # ∂t/∂ξ = [−d× , 1] by columns; ∂²|t| = (1 − n nᵀ)/|t|
    columns = (
        (0.0, -d[2], d[1]),
        (d[2], 0.0, -d[0]),
        (-d[1], d[0], 0.0),
        (1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0),
    )
    scaled = factor * model.half[model.tendon_seg[p]] / norm
    for a in range(6):
        across = sub(columns[a], scale(dot(n, columns[a]), n))
        for b in range(6):
            hessian[6 * g + a, 6 * g + b] = scaled * dot(across, columns[b])


@kernel
def bend(model, data, p, g):
    """Return z = dn/ds in section axes of a station, n·τ, K, K-independent parts t + d' and |t|.

    τ = dt/ds = K × t + Γ' + K' × d + K × d' + d'', with the slope of the strain along the segment.
    """
    k = model.tendon_seg[p]
    path = model.tendon_path[p, g]
    t, norm, d = path_tangent(model, data, p, g)
    slope = load_vec(path[1])
    x1, x2 = load_twist(data.xi[k, 0, 0]), load_twist(data.xi[k, 1, 0])
    rate = 0.5 * ROOT3 / model.half[k]
    turn = load_twist(data.xi[k, g, 0])[0]
    tau = add(cross(turn, add(t, slope)), load_vec(path[2]))
    tau = add(tau, scale(rate, sub(x2[1], x1[1])))
    tau = add(tau, cross(scale(rate, sub(x2[0], x1[0])), d))
    n = scale(1.0 / norm, t)
    along = dot(n, tau)
    return scale(1.0 / norm, sub(tau, scale(along, n))), along, turn, add(t, slope), norm


@kernel
def wrap(model, data, i, p, g):
    """Return by how much the path turns per arc length in rad/m, rounded off near zero.

    κ²/√(κ² + κ₀²) instead of κ = |dn/ds|, so that a straight path is no corner of the law.
    """
    z = bend(model, data, p, g)[0]
    square = dot(z, z)
    return square / math.sqrt(square + model.friction[i, 2] ** 2)


@unit
def add_wrap(model, data, i, p, g, factor, out):
    """Add factor times ∂(wrap)/∂q of one station to out (n,)."""
    out = bare(out)
    k = model.tendon_seg[p]
    t, _, d = path_tangent(model, data, p, g)
    z, along, turn, lever, norm = bend(model, data, p, g)
    square = dot(z, z)
    near = square + model.friction[i, 2] ** 2
    scaled = factor * (square + 2.0 * (near - square)) / (near * math.sqrt(near)) / norm
    # z·δz = [z·δτ − (n·τ)/|t| z·δt − z·z n·δt] / |t|
    own = sub(cross(z, turn), scale(along / norm, z))
    own = sub(own, scale(square / norm, t))
    m, moment = cross(d, own), cross(lever, z)
    here = (m[0] + moment[0], m[1] + moment[1], m[2] + moment[2], own[0], own[1], own[2])
    rate = 0.5 * ROOT3 / model.half[k]
    ahead = dual_of(d, z)
    spread(model, k, g, scaled, here, out)
    spread(model, k, 1, scaled * rate, ahead, out)
    spread(model, k, 0, -scaled * rate, ahead, out)
