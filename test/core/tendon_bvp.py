"""An independent static solution of a rod with one tendon: Rucker and Webster's equations.

The tendon is a load on the rod: T dn̂/ds per arc length along its path, n̂ its direction, and a
point force where it ends. Unknowns per arc length: position, quaternion, curvature K and stretch Γ
of the section; their slopes come from the 6 x 6 system of the equations of equilibrium, in which
the load depends on them too. Nothing of the package is used: no port, no length, no energy.
"""

import numpy as np
from scipy.integrate import solve_bvp
from scipy.spatial.transform import Rotation


def cross_matrix(a):
    """Return the matrices (N, 3, 3) of a × for a (N, 3)."""
    zero = np.zeros(len(a))
    return np.array([
        [zero, -a[:, 2], a[:, 1]], [a[:, 2], zero, -a[:, 0]], [-a[:, 1], a[:, 0], zero],
    ]).transpose(2, 0, 1)  # fmt: skip


def solve_tendon_rod(length, stiffness, path, tension, weight=(0.0, 0.0, 0.0), tolerance=1e-7):
    """Return position (3,) and rotation matrix of the tip of a rod clamped along x.

    stiffness (6,) of [K, Γ]; path(s) -> d, d', d'' (N, 3) from the base to the tip; weight in N/m,
    world. A negative tension is a pressure times an area.
    """
    bend, stretch = np.asarray(stiffness[:3]), np.asarray(stiffness[3:])
    weight = np.asarray(weight, dtype=float)
    ahead = np.array([1.0, 0.0, 0.0])

    def rates(s, y, share):
        turn = Rotation.from_quat(y[3:7].T).as_matrix()
        k, gamma = y[7:10].T, y[10:13].T
        force, moment = stretch * (gamma - ahead), bend * k
        d, slope, curve = path(s)
        t = gamma + np.cross(k, d) + slope
        size = np.linalg.norm(t, axis=1)[:, None, None]
        across = share * tension / size * (np.eye(3) - np.einsum("ki,kj->kij", t, t) / size**2)
        # T dn̂/ds = across τ, τ = K × t + K' × d + K × d' + d'' + Γ'
        known = np.einsum("kij,kj->ki", across, np.cross(k, t) + np.cross(k, slope) + curve)
        arm = cross_matrix(d)
        matrix = np.block([[np.diag(bend) - arm @ across @ arm, arm @ across],
                           [-across @ arm, np.diag(stretch) + across]])  # fmt: skip
        load = known + share * np.einsum("kji,j->ki", turn, weight)
        right = -np.concatenate([
            np.cross(k, moment) + np.cross(gamma, force) + np.cross(d, known),
            np.cross(k, force) + load,
        ], axis=1)  # fmt: skip
        x, yq, z, w = y[3:7]
        kx, ky, kz = k.T
        spin = 0.5 * np.array([w * kx + yq * kz - z * ky, w * ky + z * kx - x * kz,
                               w * kz + x * ky - yq * kx, -x * kx - yq * ky - z * kz])  # fmt: skip
        slopes = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
        return np.vstack([np.einsum("kij,kj->ik", turn, gamma), spin, slopes.T])

    def ends(a, b, share):
        k, gamma = b[7:10], b[10:13]
        d, slope, _ = (x[0] for x in path(np.array([length])))
        t = gamma + np.cross(k, d) + slope
        pull = -share * tension * t / np.linalg.norm(t)
        return np.concatenate([
            a[:3], a[3:7] - [0, 0, 0, 1],
            bend * k - np.cross(d, pull), stretch * (gamma - ahead) - pull,
        ])  # fmt: skip

    s = np.linspace(0.0, length, 21)
    y = np.zeros((13, len(s)))
    y[0], y[6], y[10] = s, 1.0, 1.0
    for share in (0.34, 0.67, 1.0):
        result = solve_bvp(
            lambda x, u, share=share: rates(x, u, share),
            lambda a, b, share=share: ends(a, b, share),
            s,
            y,
            tol=tolerance if share == 1.0 else 1e-3,
            max_nodes=5000,
        )
        assert result.success, result.message
        s, y = result.x, result.y
    return y[:3, -1], Rotation.from_quat(y[3:7, -1]).as_matrix()
