"""The surrounding fluid on the nodes: added mass, drag, lift, buoyancy.

With η = (ω; v) the body twist of a place, u the current in its axes, v_r = v − u, 𝓜_A the added
mass and m the displaced mass, the wrench of the fluid on it is (docs/theory.md)

    F = −[𝓜_A η̇_r − ad_{η_r}ᵀ 𝓜_A η_r] − drag(η_r) + lift(v_r) − m (g − u̇),
    v̇_r = v̇ − u̇ + ω × u,

with the rate u̇ of the current along fixed axes, seen in those of the place. Ends on which no
pressure acts get ρ A (g · x + surface) along the rod.
"""

import math

from soft_sim_ros.core.algebra.dual import (
    add,
    apply,
    apply_t,
    cross,
    dot,
    load_mat,
    load_vec,
    madd,
    mscale,
    mul,
    outer,
    scale,
    skew,
    store_wrench,
    sub,
    transpose,
)
from soft_sim_ros.core.algebra.maps import add_blocks
from soft_sim_ros.core.algebra.spaces import (
    keep_wrench,
    polar_of,
    rotation_of,
    size_of,
    twist_of,
    wrench_of,
)
from soft_sim_ros.core.backend.jit import algebra, bare, kernel, unit

from .drag import (
    diagonal,
    lifting,
    lifting_slope,
    resistance,
    resistance_slope,
    rows_by,
    times,
)

# columns of Data.fluid_power
WORK, LOSS = 0, 1


@kernel
def still(data):
    """Return whether nothing of the current acts."""
    for c in range(data.current.shape[0]):
        if data.current[c, 0] != 0.0 or data.current[c, 1] != 0.0:
            return data.now[1] == 0.0
    return True


@kernel
def current_of(model, data, which):
    """Return the velocity (0) or acceleration (1) of the current in the base frame."""
    c = data.current
    world = scale(data.now[1], (c[0, which], c[1, which], c[2, which]))
    return apply_t(load_mat(model.fluid.base), world)


@kernel
def frame_of(model, data, e):
    """Return orientation and position of place e in the base frame."""
    space, fluid = model.space, model.fluid
    k = fluid.node[e]
    rotation = rotation_of(space, data.rotation[k])
    offset = load_vec(fluid.frame[e, 9:])
    at = add(polar_of(space, data.position[k]), apply(rotation, offset))
    return mul(rotation, load_mat(fluid.frame[e])), at


@kernel
def moved(model, data, e):
    """Return body twist and acceleration minus gravity of place e, along its axes."""
    space, fluid = model.space, model.fluid
    k = fluid.node[e]
    own, offset = load_mat(fluid.frame[e]), load_vec(fluid.frame[e, 9:])
    eta, acc = twist_of(space, data.eta[k]), twist_of(space, data.acc[k])
    v = apply_t(own, add(eta[1], cross(eta[0], offset)))
    a = apply_t(own, add(acc[1], cross(acc[0], offset)))
    return apply_t(own, eta[0]), v, apply_t(own, acc[0]), a


@kernel
def depth(model, data, at):
    """Return the pressure at a place in the base frame over the density, in m²/s²."""
    base, gravity = model.fluid.base, load_vec(data.gravity)
    g = apply(load_mat(base), gravity)
    return dot(gravity, at) + dot(g, load_vec(base[9:])) + math.sqrt(dot(g, g)) * base[12]


@kernel
def pushed(model, data, e):
    """Return force and moment, minus those of the fluid, on place e along its axes; book its power.

    data.fluid_power gets the work of the current and of dry ends, and what is dissipated, in W.
    """
    space, fluid = model.space, model.fluid
    rotation, at = frame_of(model, data, e)
    w, v, dw, a = moved(model, data, e)
    g = apply_t(rotation, polar_of(space, data.gravity))
    u = apply_t(rotation, current_of(model, data, 0))
    du = apply_t(rotation, current_of(model, data, 1))
    inertia, mass = load_vec(fluid.added[e]), load_vec(fluid.added[e, 3:])
    split = fluid.law[e] == 0
    vr = sub(v, u)
    rate = add(add(a, sub(g, du)), cross(w, u))
    spin, push = times(inertia, w), times(mass, vr)
    drag = resistance(load_vec(fluid.quadratic[e, 3:]), load_vec(fluid.viscous[e, 3:]), split, vr)
    brake = resistance(load_vec(fluid.quadratic[e]), load_vec(fluid.viscous[e]), False, w)
    up = lifting(load_vec(fluid.lift[e]), vr)
    moment = add(add(times(inertia, dw), cross(w, spin)), add(cross(vr, push), brake))
    force = add(add(times(mass, rate), cross(w, push)), sub(drag, up))
    force = add(force, scale(fluid.displaced[e], sub(g, du)))
    missing = 0.0
    if fluid.end[e] != 0.0:
        missing = data.now[1] * fluid.end[e] * depth(model, data, at)
    data.fluid_power[e, LOSS] = dot(drag, vr) + dot(brake, w)
    work = missing * v[0]
    if not still(data):
        work += dot(times(mass, du), v) - dot(times(mass, cross(w, u)), u)
        work += dot(sub(up, drag), u) + fluid.displaced[e] * dot(du, v)
    data.fluid_power[e, WORK] = work
    return (force[0] - missing, force[1], force[2]), moment


@unit
def fluid_wrench(model, data, e, out):
    """Fill out (6,) with minus the wrench of the fluid on place e, along its axes."""
    store_wrench(bare(out), pushed(model, data, e))


@unit
def fluid_wrenches(model, data):
    """Add minus the wrench of the fluid to data.wrench of all nodes, along their axes."""
    space, fluid = model.space, model.fluid
    for e in range(len(fluid.node)):
        force, moment = pushed(model, data, e)
        own, offset = load_mat(fluid.frame[e]), load_vec(fluid.frame[e, 9:])
        force = apply(own, force)
        moment = add(apply(own, moment), cross(offset, force))
        waiting = wrench_of(space, data.wrench[fluid.node[e]])
        whole = (add(waiting[0], force), add(waiting[1], moment))
        keep_wrench(space, data.wrench[fluid.node[e]], whole)


@unit
def fluid_matrices(model, data, node, out):
    """Add the derivatives of the fluid's wrench on a node to its I, G and D: out (3 size, 8)."""
    space, fluid = model.space, model.fluid
    size = size_of(space)
    for e in range(fluid.ptr[node], fluid.ptr[node + 1]):
        rotation, at = frame_of(model, data, e)
        w, v, _, _ = moved(model, data, e)
        g = apply_t(rotation, polar_of(space, data.gravity))
        u = apply_t(rotation, current_of(model, data, 0))
        du = apply_t(rotation, current_of(model, data, 1))
        inertia, mass = load_vec(fluid.added[e]), load_vec(fluid.added[e, 3:])
        split = fluid.law[e] == 0
        vr = sub(v, u)
        wx, ux = skew(w), skew(u)
        push, none = times(mass, vr), skew((0.0, 0.0, 0.0))
        # by acceleration
        blocks = diagonal(inertia), none, none, diagonal(mass)
        add_blocks(space, out, 0, to_base(blocks, rotation, at))
        # by the relative velocity, and by the angular velocity
        moment_v = madd(mul(skew(vr), diagonal(mass)), mscale(-1.0, skew(push)))
        drag = resistance_slope(
            load_vec(fluid.quadratic[e, 3:]), load_vec(fluid.viscous[e, 3:]), split, vr
        )
        force_v = madd(mul(wx, diagonal(mass)), drag)
        force_v = madd(force_v, mscale(-1.0, lifting_slope(load_vec(fluid.lift[e]), vr)))
        brake = resistance_slope(load_vec(fluid.quadratic[e]), load_vec(fluid.viscous[e]), False, w)
        moment_w = madd(mul(wx, diagonal(inertia)), mscale(-1.0, skew(times(inertia, w))))
        moment_w = madd(madd(moment_w, brake), mscale(-1.0, rows_by(inertia, wx)))
        force_w = madd(skew(push), rows_by(mass, skew(add(u, v))))
        blocks = (
            moment_w,
            moment_v,
            mscale(-1.0, force_w),
            madd(force_v, mscale(-1.0, rows_by(mass, wx))),
        )
        add_blocks(space, out, size, to_base(blocks, rotation, at))
        # by pose: gravity and current turn the other way
        turn = rows_by(mass, madd(mul(wx, ux), mscale(-1.0, skew(du))))
        turn = madd(turn, mscale(-1.0, mul(force_v, ux)))
        turn = madd(turn, mscale(fluid.displaced[e], skew(sub(g, du))))
        shift = none
        if fluid.end[e] != 0.0:
            all_of_g = apply_t(rotation, load_vec(data.gravity))
            shift = outer((-data.now[1] * fluid.end[e], 0.0, 0.0), all_of_g)
        blocks = mscale(-1.0, mul(moment_v, ux)), none, turn, shift
        add_blocks(space, out, 2 * size, to_base(blocks, rotation, at))


@algebra
def to_base(blocks, rotation, at):
    """Return a map from twists to wrenches, blocks (ww, wv, vw, vv), about the base and its axes.

    It is given along the axes of a place ``at`` of an orientation, about that place.
    """
    back, x = transpose(rotation), skew(at)
    ww, wv = mul(mul(rotation, blocks[0]), back), mul(mul(rotation, blocks[1]), back)
    vw, vv = mul(mul(rotation, blocks[2]), back), mul(mul(rotation, blocks[3]), back)
    vw = madd(vw, mscale(-1.0, mul(vv, x)))
    ww = madd(madd(ww, mscale(-1.0, mul(wv, x))), mul(x, vw))
    return ww, madd(wv, mul(x, vv)), vw, vv


@unit
def fluid_energies(model, data):
    """Return the energy in J of the fluid that moves along, as if still, and of buoyancy."""
    fluid = model.fluid
    kinetic, potential = 0.0, 0.0
    for e in range(len(fluid.node)):
        _, at = frame_of(model, data, e)
        w, v, _, _ = moved(model, data, e)
        kinetic += 0.5 * dot(times(load_vec(fluid.added[e]), w), w)
        kinetic += 0.5 * dot(times(load_vec(fluid.added[e, 3:]), v), v)
        potential += fluid.displaced[e] * dot(load_vec(data.gravity), at)
    return kinetic, potential


@kernel
def fluid_work(data):
    """Return the power in W of current and dry ends, at the last residual."""
    total = 0.0
    for e in range(len(data.fluid_power)):
        total += data.fluid_power[e, WORK]
    return total


@kernel
def fluid_loss(data):
    """Return what drag dissipates in W, at the last residual."""
    total = 0.0
    for e in range(len(data.fluid_power)):
        total += data.fluid_power[e, LOSS]
    return total
