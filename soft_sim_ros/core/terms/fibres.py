"""Hyperelastic sections: energy, force and tangent of stretch, bending and torsion by their fibres.

A fibre at (y, z) of the stress-free section, of an incompressible material, is stretched by

    λ = Γ + (z K_y − y K_z)/√Γ,     γ² = t K_x²,

with Γ = 1 + (ξ − ξ₀)_x and K counted from K₀. The section gets thinner as the rod is stretched, so
the fibre lies at (y, z)/√Γ. The energy per reference length is W = Σ w(λ, γ²) dA; force and
stiffness are its exact derivatives.
"""

import math

from soft_sim_ros.core.algebra.search import row_of
from soft_sim_ros.core.backend.jit import bare, kernel, unit


@kernel
def curve(knots, first, last, stretch):
    """Return energy, stress and slope of a piecewise cubic stress."""
    first = row_of(knots, first, last, stretch)
    x = stretch - knots[first, 0]
    c0, c1, c2, c3 = knots[first, 2], knots[first, 3], knots[first, 4], knots[first, 5]
    energy = knots[first, 1] + x * (c0 + x * (c1 / 2.0 + x * (c2 / 3.0 + x * c3 / 4.0)))
    stress = c0 + x * (c1 + x * (c2 + x * c3))
    return energy, stress, c1 + x * (2.0 * c2 + x * 3.0 * c3)


@kernel
def rivlin(c10, c01, c20, c30, stretch, twist):
    """Return w and its derivatives by λ, γ², λλ, λγ², γ²γ² of Rivlin's series (scene/law.py)."""
    r = 1.0 / stretch
    r2 = r * r
    first = stretch * stretch + (2.0 + twist) * r - 3.0
    first_s = 2.0 * stretch - (2.0 + twist) * r2
    first_ss = 2.0 + 2.0 * (2.0 + twist) * r2 * r
    second = 2.0 * stretch + (1.0 + twist) * r2 - 3.0
    second_s = 2.0 - 2.0 * (1.0 + twist) * r2 * r
    second_ss = 6.0 * (1.0 + twist) * r2 * r2
    d1 = c10 + first * (2.0 * c20 + first * 3.0 * c30)
    d2 = 2.0 * c20 + first * 6.0 * c30
    return (
        first * (c10 + first * (c20 + first * c30)) + c01 * second,
        d1 * first_s + c01 * second_s,
        d1 * r + c01 * r2,
        d1 * first_ss + d2 * first_s * first_s + c01 * second_ss,
        d2 * first_s * r - d1 * r2 - 2.0 * c01 * r2 * r,
        d2 * r2,
    )


@kernel
def fibre(fibres, law, stretch, twist):
    """Return w in J/m³ and its derivatives by λ, γ², λλ, λγ², γ²γ².

    Outside of the range of the law, w is continued as a parabola in λ. Newton's method may pass
    through such states; none of them is accepted as a solution.
    """
    p = fibres.laws
    inside = min(max(stretch, p[law, 0]), p[law, 1])
    first, last = int(p[law, 7]), int(p[law, 8])
    if last > first:
        w, ws, wss = curve(fibres.knots, first, last, inside)
        wt, wst, wtt = 0.5 * p[law, 6], 0.0, 0.0
        w += wt * twist
    else:
        w, ws, wt, wss, wst, wtt = rivlin(p[law, 2], p[law, 3], p[law, 4], p[law, 5], inside, twist)
    beyond = stretch - inside
    w += beyond * (ws + 0.5 * beyond * wss)
    return w, ws + beyond * wss, wt + beyond * wst, wss, wst, wtt


@kernel
def thinning(stretch):
    """Return Γ^-½, the factor of all widths of the section, and its two derivatives."""
    g = max(stretch, 1e-3)
    c = 1.0 / math.sqrt(g)
    return c, -0.5 * c / g, 0.75 * c / (g * g)


@unit
def section_strains(fibres, q, section):
    """Fill section (P, 4) with K − K₀ and Γ at the stations."""
    q, section = bare(q), bare(section)
    for p in range(len(fibres.block)):
        for c in range(3):
            section[p, c] = 0.0
        section[p, 3] = 1.0
        for e in range(fibres.entry_ptr[p], fibres.entry_ptr[p + 1]):
            section[p, fibres.entry_comp[e]] += fibres.entry_phi[e] * q[fibres.entry_col[e]]


@kernel
def section_force(fibres, p, strain):
    """Return energy and the dual of (K_x, K_y, K_z, Γ) at station p, times its arc length."""
    kx, ky, kz, g = strain[0], strain[1], strain[2], strain[3]
    c, c1, _ = thinning(g)
    energy, fx, fy, fz, fg = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(fibres.ptr[p], fibres.ptr[p + 1]):
        y, z = fibres.points[i, 0], fibres.points[i, 1]
        area, t = fibres.points[i, 2], fibres.points[i, 3]
        lever = z * ky - y * kz
        w, ws, wt, _, _, _ = fibre(fibres, fibres.law[p], g + lever * c, t * kx * kx)
        energy += area * w
        fx += area * wt * 2.0 * t * kx
        fy += area * ws * z * c
        fz -= area * ws * y * c
        fg += area * ws * (1.0 + lever * c1)
    return energy, fx, fy, fz, fg


@kernel
def section_stiffness(fibres, p, strain):
    """Return the upper triangle, by rows, of the second derivatives of the energy at station p."""
    kx, ky, kz, g = strain[0], strain[1], strain[2], strain[3]
    c, c1, c2 = thinning(g)
    xx, xy, xz, xg, yy, yz, yg, zz, zg, gg = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(fibres.ptr[p], fibres.ptr[p + 1]):
        y, z = fibres.points[i, 0], fibres.points[i, 1]
        area, t = fibres.points[i, 2], fibres.points[i, 3]
        lever = z * ky - y * kz
        _, ws, wt, wss, wst, wtt = fibre(fibres, fibres.law[p], g + lever * c, t * kx * kx)
        ws, wss, wst = area * ws, area * wss, area * wst * 2.0 * t * kx
        dy, dz, dg = z * c, -y * c, 1.0 + lever * c1  # ∂λ/∂K_y, ∂λ/∂K_z, ∂λ/∂Γ
        xx += area * (wtt * (2.0 * t * kx) ** 2 + wt * 2.0 * t)
        xy += wst * dy
        xz += wst * dz
        xg += wst * dg
        yy += wss * dy * dy
        yz += wss * dy * dz
        yg += wss * dy * dg + ws * z * c1
        zz += wss * dz * dz
        zg += wss * dz * dg - ws * y * c1
        gg += wss * dg * dg + ws * lever * c2
    return xx, xy, xz, xg, yy, yz, yg, zz, zg, gg


@unit
def fibre_energy(fibres, section, q):
    """Return the energy in J of all hyperelastic sections."""
    section, q = bare(section), bare(q)
    section_strains(fibres, q, section)
    total = 0.0
    for p in range(len(fibres.block)):
        total += section_force(fibres, p, section[p])[0]
    return total


@unit
def fibre_forces(fibres, section, q, r):
    """Add ∂W/∂q to r; section (P, 4) is left with the strains."""
    section, q, r = bare(section), bare(q), bare(r)
    section_strains(fibres, q, section)
    for p in range(len(fibres.block)):
        force = section_force(fibres, p, section[p])[1:]
        for e in range(fibres.entry_ptr[p], fibres.entry_ptr[p + 1]):
            r[fibres.entry_col[e]] += fibres.entry_phi[e] * force[fibres.entry_comp[e]]


@unit
def fibre_tangent(model, section, a0, system):
    """Add α₀ ∂²W/∂q² at the strains of the last ``fibre_forces``."""
    section = bare(section)
    fibres = model.fibres
    for p in range(len(fibres.block)):
        xx, xy, xz, xg, yy, yz, yg, zz, zg, gg = section_stiffness(fibres, p, section[p])
        rows = ((xx, xy, xz, xg), (xy, yy, yz, yg), (xz, yz, zz, zg), (xg, yg, zg, gg))
        b = fibres.block[p]
        begin, m = model.block_col[b], model.block_col[b + 1] - model.block_col[b]
        for e in range(fibres.entry_ptr[p], fibres.entry_ptr[p + 1]):
            row = rows[fibres.entry_comp[e]]
            at = system.offset[b] + (fibres.entry_col[e] - begin) * m - begin
            factor = a0 * fibres.entry_phi[e]
            for f in range(fibres.entry_ptr[p], fibres.entry_ptr[p + 1]):
                term = factor * fibres.entry_phi[f] * row[fibres.entry_comp[f]]
                system.diagonal[at + fibres.entry_col[f]] += term


@kernel
def rises(fibres, law, stretch, twist):
    """Return whether a sheared fibre resists more stretch and more shear: ∂²w/∂λ², ∂²w/∂γ² > 0."""
    _, _, wt, wss, _, wtt = fibre(fibres, law, stretch, twist)
    return wss > 0.0 and wt + 2.0 * twist * wtt > 0.0


@kernel
def lawful(fibres, section):
    """Return whether every fibre is within the stretches, and the shear, that its law holds for."""
    for p in range(len(fibres.block)):
        kx, ky, kz, g = section[p, 0], section[p, 1], section[p, 2], section[p, 3]
        low, high = fibres.laws[fibres.law[p], 0], fibres.laws[fibres.law[p], 1]
        c = thinning(g)[0]
        for i in range(fibres.ptr[p], fibres.ptr[p + 1]):
            stretch = g + (fibres.points[i, 1] * ky - fibres.points[i, 0] * kz) * c
            if not low <= stretch <= high:
                return False
            twist = fibres.points[i, 3] * kx * kx
            if twist > 0.0 and not rises(fibres, fibres.law[p], stretch, twist):
                return False
    return True
