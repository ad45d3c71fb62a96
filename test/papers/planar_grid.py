"""Motion of a curved, non-uniform rod in a plane, in absolute coordinates, by the method of lines.

A staggered grid: positions at cell ends, angles in cell middles, balances of Newton and Euler for
each, scipy's Radau in time, Richardson's extrapolation over two grids. No strains as unknowns, no
recursion, no basis: nothing is shared with the package.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import csr_matrix


def tip(n, length, duration, *, bend, pull, shear, mass, inertia, curvature, gravity, viscous):
    """Return the tip (2,) of a rod clamped along x in its reference shape, let go at rest.

    bend … curvature are functions of s; ``viscous`` is the retardation time in s of all strains.
    """
    h = length / n
    ends, middles = h * np.arange(1, n + 1), h * (np.arange(n) + 0.5)
    joints = h * np.arange(n)  # where the angle of one cell meets that of the one before
    gap = np.full(n, h)
    gap[0] = 0.5 * h  # half a cell from the clamp to the first angle
    rest = np.array([curvature(s) for s in joints])
    rest[0] = curvature(0.25 * h)
    m = h * np.array([mass(s) for s in ends])
    m[-1] = 0.5 * h * mass(length - 0.25 * h)
    j = h * np.array([inertia(s) for s in middles])
    eb = np.array([bend(s) for s in joints])
    eb[0] = bend(0.25 * h)
    ea, ga = (np.array([f(s) for s in middles]) for f in (pull, shear))
    angle0 = np.cumsum(rest * gap)
    place0 = h * np.cumsum([np.cos(angle0), np.sin(angle0)], axis=1)

    def rates(t, y):
        x, z, a, u, w, b = y.reshape(6, n)
        c, s = np.cos(a), np.sin(a)
        dx, dz = np.diff(x, prepend=0.0) / h, np.diff(z, prepend=0.0) / h
        du, dw = np.diff(u, prepend=0.0) / h, np.diff(w, prepend=0.0) / h
        along, across = c * dx + s * dz, -s * dx + c * dz
        along_rate = c * du + s * dw + b * across
        across_rate = -s * du + c * dw - b * along
        axial = ea * (along - 1.0 + viscous * along_rate)
        cut = ga * (across + viscous * across_rate)
        turn = np.diff(a, prepend=0.0) / gap - rest
        turn_rate = np.diff(b, prepend=0.0) / gap
        moment = eb * (turn + viscous * turn_rate)
        fx, fz = c * axial - s * cut, s * axial + c * cut
        push = np.append(fx[1:], 0.0) - fx, np.append(fz[1:], 0.0) - fz
        torque = np.append(moment[1:], 0.0) - moment + h * (along * cut - across * axial)
        return np.concatenate(
            [u, w, b, push[0] / m + gravity[0], push[1] / m + gravity[1], torque / j]
        )

    start = np.concatenate([*place0, angle0, np.zeros(3 * n)])
    near = (np.abs(np.subtract.outer(np.arange(n), np.arange(n))) <= 1).astype(int)
    solution = solve_ivp(
        rates, (0.0, duration), start, method="Radau", rtol=1e-7, atol=1e-9,
        jac_sparsity=csr_matrix(np.kron(np.ones((6, 6)), near)),
    )  # fmt: skip
    assert solution.success, solution.message
    return solution.y[[n - 1, 2 * n - 1], -1]


def extrapolated_tip(n, *arguments, **data):
    """Return the tip from grids n, 2n and 4n, extrapolated in h², and the last correction."""
    one, two, four = (tip(k * n, *arguments, **data) for k in (1, 2, 4))
    first, second = two + (two - one) / 3, four + (four - two) / 3
    return second + (second - first) / 15, np.abs(second - first).max()
