"""The matrices of nodes, four at once, in the base frame, that the tangent needs."""

from soft_sim_ros.core.algebra.dual import (
    add,
    apply,
    cross,
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
from soft_sim_ros.core.algebra.maps import keep_blocks
from soft_sim_ros.core.algebra.simd import four, lanes_of, nine, six, three
from soft_sim_ros.core.algebra.spaces import axial_of, polar_of, rotation_of, size_of, twist_of
from soft_sim_ros.core.backend.jit import algebra
from soft_sim_ros.core.terms.mass_damping import damping_matrices


@algebra
def node_matrices(model, data, rows, out, here):
    """Fill rows ``here`` of out (4, 3 size, 8): I, G and D in the base frame of nodes ``rows``."""
    space = model.space
    mass, j1, j2, j3 = four(model.inertia, rows, 0)
    rotation = rotation_of(space, nine(data.rotation, rows, 0))
    p = polar_of(space, three(data.position, rows, 0))
    eta = twist_of(space, six(data.eta, rows, 0))
    scaled = (
        rotation[0] * j1,
        rotation[1] * j2,
        rotation[2] * j3,
        rotation[3] * j1,
        rotation[4] * j2,
        rotation[5] * j3,
        rotation[6] * j1,
        rotation[7] * j2,
        rotation[8] * j3,
    )
    central = mul(scaled, transpose(rotation))
    # spatial velocity and momentum
    w = apply(rotation, eta[0])
    v_node = apply(rotation, eta[1])
    spin = apply(scaled, eta[0])
    push = scale(mass, v_node)
    h_moment = add(spin, cross(p, push))
    px = skew(p)
    arm = mscale(mass, px)
    offset = madd(spherical(mass * dot(p, p)), mscale(-mass, outer(p, p)))
    angular = madd(central, offset)
    # İ from its parts: d/dt(central) = w×J − J w×, d/dt p = v of the node
    wx = skew(w)
    central_rate = madd(mul(wx, central), mscale(-1.0, mul(central, wx)))
    moved = madd(outer(p, v_node), outer(v_node, p))
    offset_rate = madd(spherical(2.0 * mass * dot(p, v_node)), mscale(-mass, moved))
    angular_rate = madd(central_rate, offset_rate)
    arm_rate = mscale(mass, skew(v_node))
    hm, hn = skew(h_moment), skew(push)
    # body components of dead wrench and weight change as the section turns: δF = ω × (…)
    force = lanes_of(scale(mass, polar_of(space, data.gravity)))
    moment = lanes_of((0.0, 0.0, 0.0))
    if data.active[0] != 0:
        dead = six(data.dead, rows, 0)
        force = lanes_of(add(force, polar_of(space, dead[3:])))
        moment = lanes_of(axial_of(space, dead))
    fx = skew(force)
    turn_moment = madd(skew(moment), mul(px, fx))
    none = spherical(0.0)
    turned = lanes_of(madd(angular_rate, mscale(-1.0, hm)))
    pushed = lanes_of(madd(arm_rate, mscale(-1.0, hn)))
    swung = lanes_of(mscale(-1.0, madd(arm_rate, hn)))
    dragged = lanes_of(none)
    if len(model.mass_damping) > 0:
        damping_angular, damping_arm, damping_mass = damping_matrices(
            four(model.mass_damping, rows, 0), rotation, p
        )
        turned, pushed = madd(turned, damping_angular), madd(pushed, damping_arm)
        swung, dragged = madd(swung, mscale(-1.0, damping_arm)), lanes_of(damping_mass)
    size = 8 * size_of(space)
    keep_blocks(space, out, here, 0, (angular, arm, mscale(-1.0, arm), spherical(mass)))
    keep_blocks(space, out, here, size, (turned, pushed, swung, dragged))
    turn = (mscale(-1.0, turn_moment), none, mscale(-1.0, fx), none)
    keep_blocks(space, out, here, 2 * size, turn)
