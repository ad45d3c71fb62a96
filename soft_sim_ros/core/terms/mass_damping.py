"""Rayleigh damping proportional to mass: the wrench D η on every node, D = α × its inertia.

Summed over the nodes it is Σ Jᵀ D J q̇, that is α M q̇ if all masses have the same α.
"""

from soft_sim_ros.core.algebra.dual import (
    dot,
    madd,
    mscale,
    mul,
    outer,
    scale,
    skew,
    spherical,
    transpose,
)
from soft_sim_ros.core.backend.jit import kernel


@kernel
def damping_wrench(model, k, eta):
    """Return force and moment in N, N·m that resist the body twist eta of node k."""
    d = model.mass_damping[k]
    return scale(d[0], eta[1]), (d[1] * eta[0][0], d[2] * eta[0][1], d[3] * eta[0][2])


@kernel
def damping_matrices(d, rotation, p):
    """Return the angular, arm and linear 3x3 blocks of D in the base frame; d: a row of the model.

    They act on the rate of a variation: the body twist varies by the body components of ζ̇
    (theory.md), so no other term is left.
    """
    scaled = (
        rotation[0] * d[1],
        rotation[1] * d[2],
        rotation[2] * d[3],
        rotation[3] * d[1],
        rotation[4] * d[2],
        rotation[5] * d[3],
        rotation[6] * d[1],
        rotation[7] * d[2],
        rotation[8] * d[3],
    )
    offset = madd(spherical(d[0] * dot(p, p)), mscale(-d[0], outer(p, p)))
    angular = madd(mul(scaled, transpose(rotation)), offset)
    return angular, mscale(d[0], skew(p)), spherical(d[0])


@kernel
def mass_damping_power(model, data):
    """Return Σ ηᵀ D η in W at the last sweep."""
    total = 0.0
    for k in range(len(model.mass_damping)):
        for c in range(3):
            total += model.mass_damping[k, 1 + c] * data.eta[k, c] ** 2
            total += model.mass_damping[k, 0] * data.eta[k, 3 + c] ** 2
    return total
