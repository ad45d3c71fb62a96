"""An independent static solution: the Cosserat rod equations in world axes, by collocation (scipy).

Unknowns per arc length: position r, quaternion (unit by construction of its rate), internal moment
m and force n in *world* axes. Nothing is shared with the package: other unknowns, other equations,
another discretisation.
"""

import numpy as np
from scipy.integrate import solve_bvp
from scipy.spatial.transform import Rotation


def solve_rod(
    length,
    stiffness,
    strain0,
    *,
    density_force=(0.0, 0.0, 0.0),
    tip_force=(0.0, 0.0, 0.0),
    tip_moment=(0.0, 0.0, 0.0),
    tolerance=1e-9,
):
    """Return tip position (3,) and tip rotation matrix of a rod clamped at the origin along x.

    stiffness (6,) or (6, 6), or a function of s, and strain0(s) -> (6,) of [K, Γ]; loads in world
    axes, density_force in N/m, a constant or a function density_force(s).
    """

    def compliance(x):
        values = np.asarray(law(x), dtype=float)
        return np.linalg.inv(values) if values.ndim == 2 else np.diag(1.0 / values)

    body = density_force if callable(density_force) else lambda s: density_force
    law = stiffness if callable(stiffness) else lambda s: stiffness
    force, moment = np.asarray(tip_force, dtype=float), np.asarray(tip_moment, dtype=float)

    def rates(s, y, share):
        quaternion = y[3:7] / np.linalg.norm(y[3:7], axis=0)
        turn = Rotation.from_quat(quaternion.T).as_matrix().transpose(1, 2, 0)
        m, n = y[7:10], y[10:13]
        rest = np.array([strain0(x) for x in s]).T
        weight = np.array([body(x) for x in s], dtype=float).T
        own = np.vstack([np.einsum("jik,jk->ik", turn, x) for x in (m, n)])
        strain = np.einsum("kij,jk->ik", np.array([compliance(x) for x in s]), own) + rest
        curvature, stretch = strain[:3], strain[3:]
        tangent = np.einsum("ijk,jk->ik", turn, stretch)
        x, yq, z, w = quaternion
        kx, ky, kz = curvature
        spin = 0.5 * np.array([
            w * kx + yq * kz - z * ky,
            w * ky + z * kx - x * kz,
            w * kz + x * ky - yq * kx,
            -x * kx - yq * ky - z * kz,
        ])  # fmt: skip
        dm = -np.cross(tangent.T, n.T).T
        return np.vstack([tangent, spin, dm, -share * weight])

    s = np.linspace(0.0, length, 41)
    y = np.zeros((13, len(s)))
    y[0] = s
    y[6] = 1.0
    for i, x in enumerate(s[1:], start=1):  # reference shape as a first guess
        step = strain0(x) * (s[1] - s[0])
        turn = Rotation.from_quat(y[3:7, i - 1])
        y[:3, i] = y[:3, i - 1] + turn.apply(step[3:])
        y[3:7, i] = (turn * Rotation.from_rotvec(step[:3])).as_quat()
    for share in np.linspace(0.0, 1.0, 11)[1:]:

        def ends(a, b, share=share):
            return np.concatenate([
                a[:3], a[3:7] - [0, 0, 0, 1], b[7:10] - share * moment, b[10:13] - share * force,
            ])  # fmt: skip

        goal = tolerance if share == 1.0 else 1e-4
        result = solve_bvp(
            lambda x, u, share=share: rates(x, u, share), ends, s, y, tol=goal, max_nodes=20000
        )
        assert result.success, result.message
        s, y = result.x, result.y
    return y[:3, -1], Rotation.from_quat(y[3:7, -1]).as_matrix()
