"""The 6x6 matrices of one node, in the base frame, that the tangent needs."""

from .drag import drag_tangent
from .dual import (
    add,
    apply,
    cross,
    dot,
    load_mat,
    load_twist,
    load_vec,
    madd,
    mscale,
    mul,
    outer,
    scale,
    skew,
    spherical,
    transpose,
)
from .jit import kernel


@kernel
def node_matrices(model, data, k, inertia, gyro, turning):
    """Fill the base-frame 6x6 matrices I, G and D of node k."""
    mass = model.inertia[k, 0]
    rotation, p = load_mat(data.rotation[k]), load_vec(data.position[k])
    eta = load_twist(data.eta[k])
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
    force, moment = scale(mass, load_vec(data.gravity)), (0.0, 0.0, 0.0)
    if data.active[0] != 0:
        force, moment = add(force, load_vec(data.dead[k, 3:])), load_vec(data.dead[k])
    fx = skew(force)
    turn_moment = madd(skew(moment), mul(px, fx))
    for a in range(3):
        for b in range(3):
            i = 3 * a + b
            inertia[a, b] = angular[i]
            inertia[a, b + 3] = arm[i]
            inertia[a + 3, b] = -arm[i]
            inertia[a + 3, b + 3] = mass if a == b else 0.0
            gyro[a, b] = angular_rate[i] - hm[i]
            gyro[a, b + 3] = arm_rate[i] - hn[i]
            gyro[a + 3, b] = -arm_rate[i] - hn[i]
            gyro[a + 3, b + 3] = 0.0
            turning[a, b] = -turn_moment[i]
            turning[a, b + 3] = 0.0
            turning[a + 3, b] = -fx[i]
            turning[a + 3, b + 3] = 0.0
    if len(model.drag) > 0:
        drag_tangent(model, k, rotation, p, gyro)
