"""The matrices of one node, in the base frame, that the tangent needs."""

from .drag import drag_matrices
from .dual import (
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
from .jit import algebra
from .spaces import axial_of, keep_blocks, polar_of, rotation_of, twist_of


@algebra
def node_matrices(model, data, k, inertia, gyro, turning):
    """Fill the base-frame matrices I, G and D (rows, rows) of node k."""
    space = model.space
    mass = model.inertia[k, 0]
    rotation, p = rotation_of(space, data.rotation[k]), polar_of(space, data.position[k])
    eta = twist_of(space, data.eta[k])
    j = (model.inertia[k, 1], model.inertia[k, 2], model.inertia[k, 3])
    scaled = (
        rotation[0] * j[0],
        rotation[1] * j[1],
        rotation[2] * j[2],
        rotation[3] * j[0],
        rotation[4] * j[1],
        rotation[5] * j[2],
        rotation[6] * j[0],
        rotation[7] * j[1],
        rotation[8] * j[2],
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
    # dead wrench and weight, turning with the section in body components: δF = ω × (…)
    force, moment = scale(mass, polar_of(space, data.gravity)), (0.0, 0.0, 0.0)
    if data.active[0] != 0:
        force, moment = add(force, polar_of(space, data.dead[k, 3:])), axial_of(space, data.dead[k])
    fx = skew(force)
    turn_moment = madd(skew(moment), mul(px, fx))
    none = spherical(0.0)
    turned = madd(angular_rate, mscale(-1.0, hm))
    pushed, swung = madd(arm_rate, mscale(-1.0, hn)), mscale(-1.0, madd(arm_rate, hn))
    dragged = none
    if len(model.drag) > 0:
        drag_angular, drag_arm, dragged = drag_matrices(model, k, rotation, p)
        turned, pushed = madd(turned, drag_angular), madd(pushed, drag_arm)
        swung = madd(swung, mscale(-1.0, drag_arm))
    keep_blocks(space, inertia, angular, arm, mscale(-1.0, arm), spherical(mass))
    keep_blocks(space, gyro, turned, pushed, swung, dragged)
    keep_blocks(space, turning, mscale(-1.0, turn_moment), none, mscale(-1.0, fx), none)
