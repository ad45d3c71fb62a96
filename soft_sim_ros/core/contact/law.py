"""The force of a ball that presses on a shape, and how it changes.

With the depth φ, its rate φ̇ and the velocity w of the point of contact along the surface,

    normal    F = c σ(φ) (1 + d φ̇)₊,              after Hunt and Crossley: it never pulls
    friction  g = κ u + κ τ u̇,  |g| ≤ μ F,        u̇ = w while it sticks

in which u is the deflection of a bristle. A stage of a step begins with û and lasts a (SPAN): the
bristle would be deflected by û + a w. Where that is more than friction holds, g is brought back to
the circle μ F in its own direction, and u is what gives that g: return mapping, as in plasticity.
What is lost, g · w − κ u · u̇, is then never negative.
"""

import math

from soft_sim_ros.core.algebra.dual import (
    add,
    apply,
    cross,
    dot,
    load_mat,
    load_vec,
    scale,
    sub,
)
from soft_sim_ros.core.backend.jit import kernel
from soft_sim_ros.core.model.contact import (
    ACROSS,
    DISSIPATION,
    HERTZ,
    KIND,
    ONSET,
    SPAN,
    STIFFNESS,
    TANGENT,
    TIME,
)


@kernel
def elastic(law, share, radius, depth):
    """Return force in N, its slope in N/m, and the energy in J of a depth in m."""
    c = law[STIFFNESS] * share
    if law[KIND] == HERTZ:
        root = math.sqrt(depth)
        return c * depth * root, 1.5 * c * root, 0.4 * c * depth * depth * root
    onset = law[ONSET] * radius
    if depth < onset:
        part = depth / onset
        return 0.5 * c * depth * part, c * part, c * depth * depth * part / 6.0
    beyond = depth - 0.5 * onset
    energy = c * (0.5 * depth * (depth - onset) + onset * onset / 6.0)
    return c * beyond, c, energy


@kernel
def along(n, x):
    """Return x without its part along a unit vector n."""
    return sub(x, scale(dot(n, x), n))


@kernel
def weighed(across, axis, x):
    """Return x with its part across an axis multiplied by ``across``."""
    return add(scale(across, x), scale((1.0 - across) * dot(axis, x), axis))


@kernel
def weighed_rate(across, axis, d_axis, x, dx):
    """Return the change of ``weighed``."""
    turned = add(scale(dot(axis, x), d_axis), scale(dot(d_axis, x) + dot(axis, dx), axis))
    return add(scale(across, dx), scale(1.0 - across, turned))


@kernel
def centre_of(model, data, e):
    """Return where the centre of station e is."""
    contact = model.contact
    node = contact.node[e]
    p, offset = load_vec(data.position[node]), load_vec(contact.offset[e])
    if offset[0] == 0.0 and offset[1] == 0.0 and offset[2] == 0.0:
        return p
    return add(p, apply(load_mat(data.rotation[node]), offset))


@kernel
def motion(model, data, e):
    """Return arm, centre, ω, velocity of the centre of station e, along base axes, and its axis.

    The arm is from the node's origin to the centre of the ball.
    """
    contact = model.contact
    node = contact.node[e]
    rotation = load_mat(data.rotation[node])
    arm = apply(rotation, load_vec(contact.offset[e]))
    omega = apply(rotation, load_vec(data.eta[node]))
    speed = add(apply(rotation, load_vec(data.eta[node, 3:])), cross(omega, arm))
    axis = (rotation[0], rotation[3], rotation[6])
    return arm, add(load_vec(data.position[node]), arm), omega, speed, axis


@kernel
def pushed(law, share, radius, n, depth, speed):
    """Return F, σ c, its slope, (1 + d φ̇)₊ and the energy of the normal force."""
    force, slope, energy = elastic(law, share, radius, depth)
    factor = 1.0 - law[DISSIPATION] * dot(n, speed)
    if factor < 0.0:
        factor = 0.0
    return force * factor, force, slope, factor, energy


@kernel
def gripped(law, share, radius, touch, n, omega, speed, axis, start):
    """Return û, w, g that sticking would take, and dg/dw = κ (a + τ) of a bristle."""
    kappa, span = law[TANGENT] * share, touch.mode[SPAN]
    slide = sub(along(n, speed), scale(radius, cross(omega, n)))
    w = slide
    if law[ACROSS] != 1.0:
        w = along(n, weighed(law[ACROSS], axis, slide))
    held = along(n, start)
    resist = kappa * (span + law[TIME])
    return held, w, add(scale(kappa, held), scale(resist, w)), resist


@kernel
def bristle(law, share, touch, held, w, g, sticks):
    """Return the deflection that a bristle ends a stage with, given the g that it carries."""
    span, kappa = touch.mode[SPAN], law[TANGENT] * share
    if sticks:
        return add(held, scale(span, w))
    part = 1.0 / (span + law[TIME])
    return add(scale(part * span / kappa, g), scale(part * law[TIME], held))
