"""Rotation vectors for any number of turns: a change of chart keeps them below a full turn.

A rotation vector w and (1 − 2π/|w|) w are the same rotation. At |w| = 2π, the identity,
T(w) is singular; so a vector longer than 4π/3 is replaced by the
other one, shorter than 2π/3. The margin between the two keeps motions near half a turn from
changing back and forth. The change concerns coordinates, not the motion, and depends on the
state only.
"""

import math

from soft_sim_ros.core.backend.jit import kernel

from .dual import add, cross, dot, scale, sub
from .rotation import stumpff

LONGEST = 4.0 * math.pi / 3.0


@kernel
def body_rate(w, rate):
    """Return the angular velocity T(w) ẇ in the turned frame."""
    c = stumpff(dot(w, w))
    turned = sub(scale(c[1], rate), scale(c[2], cross(w, rate)))
    return add(turned, scale(c[3] * dot(w, rate), w))


@kernel
def vector_rate(w, omega):
    """Return ẇ = T(w)⁻¹ ω; |w| < 2π.

    T⁻¹ = 1 + w×/2 + β w×w×. As Tᵀ turns T into exp, T⁻¹ = (T Tᵀ)⁻¹ Tᵀ, with T Tᵀ = 2c₂ across w
    and 1 along it: no case distinction at small angles.
    """
    x = dot(w, w)
    c = stumpff(x)
    turned = add(scale(c[1], omega), scale(c[2], cross(w, omega)))
    turned = add(turned, scale(c[3] * dot(w, omega), w))
    # 1/(2c₂) across, 1 along; 1 − 1/(2c₂) = −x c₄/c₂ since c₂ = 1/2 − x c₄
    across = 1.0 / (2.0 * c[2])
    return add(scale(across, turned), scale(-c[4] / c[2] * dot(w, turned), w))


@kernel
def change_charts(model, work, q, v):
    """Shorten every rotation vector beyond LONGEST; return whether there was one.

    The guess for the accelerations and the factors of the Newton matrix are then void.
    """
    changed = False
    for c in model.chart:
        w = (q[c], q[c + 1], q[c + 2])
        angle = math.sqrt(dot(w, w))
        if angle <= LONGEST:
            continue
        omega = body_rate(w, (v[c], v[c + 1], v[c + 2]))
        w = scale(1.0 - 2.0 * math.pi / angle, w)
        rate = vector_rate(w, omega)
        for i in range(3):
            q[c + i], v[c + i], work.a[c + i] = w[i], rate[i], 0.0
        work.key[0] = -1.0
        changed = True
    return changed
