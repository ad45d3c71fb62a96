"""SE(3) for users: poses (4, 4), twists η = (Ω; V), wrenches Λ = (M; N) as arrays (6,).

The formulas are those of the kernels (algebra/rotation.py, over dual numbers) and hold for every
angle.
``exp`` is onto; ``log`` returns the rotation vector with norm at most π and is accurate up to π
itself.
"""

from __future__ import annotations

import numpy as np
import scipy

from soft_sim_ros.core.arguments import vector
from soft_sim_ros.core.backend.jit import unit
from soft_sim_ros.core.floats import Floats

from . import rotation
from .dual import load_twist


def hat(x: Floats) -> Floats:
    """Return the (4, 4) matrix of a twist."""
    out = np.zeros((4, 4))
    out[:3, :3] = skew(x[:3])
    out[:3, 3] = x[3:]
    return out


def skew(w: Floats) -> Floats:
    """Return the (3, 3) matrix of w ×."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


@unit
def _exp(x, out):
    w, v = load_twist(x)
    c = rotation.stumpff(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    r = rotation.rotation_exp(w, c)
    p = rotation.exp_translation(w, v, c)
    for i in range(3):
        for j in range(3):
            out[i, j] = r[3 * i + j]
        out[i, 3] = p[i]
        out[3, i] = 0.0
    out[3, 3] = 1.0


@unit
def _stumpff(x):
    return rotation.stumpff(x)


@unit
def _tangent(x, out):
    o = load_twist(x)
    w = o[0]
    t = rotation.tangent_map(o, rotation.stumpff(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]))
    for i in range(3):
        for j in range(3):
            out[i, j] = t[0][3 * i + j]
            out[i + 3, j + 3] = t[0][3 * i + j]
            out[i + 3, j] = t[1][3 * i + j]
            out[i, j + 3] = 0.0


def exp(x: Floats) -> Floats:
    """Return the pose (4, 4) reached by unit flow along the twist x (6,)."""
    out = np.empty((4, 4))
    _exp(vector("x", x, 6), out)
    return out


def log(g: Floats) -> Floats:
    """Return the twist x (6,) with exp(x) = g and rotation angle at most π."""
    w = scipy.spatial.transform.Rotation.from_matrix(g[:3, :3]).as_rotvec()
    angle2 = float(w @ w)
    # p = V v with V = T(−ω), and V⁻¹ = 1 − ω×/2 + k ω×ω× with k = (c₃ − 2c₄)/(2c₂) at every angle
    # below 2π
    c = _stumpff(angle2)
    k = (c[3] - 2.0 * c[4]) / (2.0 * c[2])
    p = g[:3, 3]
    v = p - 0.5 * np.cross(w, p) + k * np.cross(w, np.cross(w, p))
    return np.concatenate([w, v])


def inverse(g: Floats) -> Floats:
    """Return g⁻¹ (4, 4)."""
    out = np.eye(4)
    out[:3, :3] = g[:3, :3].T
    out[:3, 3] = -g[:3, :3].T @ g[:3, 3]
    return out


def Ad(g: Floats) -> Floats:
    """Return Ad_g (6, 6): body twist of a frame to the twist in the frame g is given in."""
    r = g[:3, :3]
    out = np.zeros((6, 6))
    out[:3, :3] = out[3:, 3:] = r
    out[3:, :3] = skew(g[:3, 3]) @ r
    return out


def ad(x: Floats) -> Floats:
    """Return ad_x (6, 6): the Lie bracket [x, ·]."""
    out = np.zeros((6, 6))
    out[:3, :3] = out[3:, 3:] = skew(x[:3])
    out[3:, :3] = skew(x[3:])
    return out


def coad(x: Floats) -> Floats:
    """Return ad_xᵀ (6, 6), acting on wrenches: (coad(x) Λ)·y = Λ·[x, y].

    Boyer & Primault 2005 (3.6).
    """
    return ad(x).T


def right_tangent(x: Floats) -> Floats:
    """Return T(x) (6, 6) with g⁻¹ dg = T(x) dx for g = exp(x).

    The body twist of a varied exponential.
    """
    out = np.empty((6, 6))
    _tangent(vector("x", x, 6), out)
    return out


def left_tangent(x: Floats) -> Floats:
    """Return T(−x) (6, 6) with dg g⁻¹ = T(−x) dx for g = exp(x)."""
    return right_tangent(-vector("x", x, 6))


def pose_matrix(position: Floats, quaternion: Floats) -> Floats:
    """Return the pose (4, 4) of a position in m and a quaternion x y z w."""
    # not by scipy: loading its rotations would take a tenth of the start of a program
    quaternion = vector("quaternion", quaternion, 4)
    axis, w = quaternion[:3], float(quaternion[3])
    k = skew(axis)
    out = np.eye(4)
    out[:3, :3] += 2.0 / (axis @ axis + w * w) * (w * k + k @ k)
    out[:3, 3] = vector("position", position, 3)
    return out


__all__ = [
    "Ad",
    "ad",
    "coad",
    "exp",
    "hat",
    "inverse",
    "left_tangent",
    "log",
    "pose_matrix",
    "right_tangent",
    "skew",
]
