"""The kernels' arguments: an immutable Model and a scratch Data, flat named tuples of arrays.

A forest of bodies is a list of *segments*, depth first. Segment k carries the frame of the node
p that it leaves to node k + 1; in a chain, and along a branch, p = k:

    g_{k+1} = g_p exp(Ω_k),   Ω_k = h/2 (ξ₁ + ξ₂) + κ [ξ₁, ξ₂],   ξ_i = ξ₀ᵢ + Σ_entries φ_i
    q[column] e[component],

the fourth-order Magnus step of g' = g ξ with ξ at the two Gauss points of the segment (κ = √3
h²/12). A joint is the segment with h = 1, κ = 0 and constant φ; a rigid offset is a segment with
no entries. Inertia is lumped at the nodes by Gauss–Lobatto weights, so the model is a discrete
Lagrangian, and every quantity is computed exactly for it. Consecutive segments that share
coordinates form a *block* (a section element, a joint): the unit of elimination.

All positions, loads and gravity are expressed in the base frame of the arm.
"""

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.algebra.motion_space import PlaneXY, PlaneXZ, Space, Spatial
from soft_sim_ros.core.backend import late
from soft_sim_ros.core.backend.laws import addresses
from soft_sim_ros.core.backend.structs import struct
from soft_sim_ros.core.floats import Floats, Ints

from .contact import Contact, Touch, new_touch, within
from .pairs import Meet, Pairs, new_meet, pairs_within


@struct
class Fibres(NamedTuple):
    """Hyperelastic sections, at P stations along the rods: a Gauss point and its fibres."""

    entry_ptr: Ints  # (P + 1,) entries of a station
    entry_col: Ints  # coordinate
    entry_comp: Ints  # strain component 0…3
    entry_phi: Floats  # basis value
    block: Ints  # (P,)
    law: Ints  # (P,)
    ptr: Ints  # (P + 1,) fibres of a station
    points: Floats  # (F, 4) y, z in m, volume in m³, (γ/K_x)² in m²
    laws: Floats  # (L, 9) stretches from … to, c10, c01, c20, c30, G in Pa, knots from … to
    knots: Floats  # (N, 6) stretch, energy in J/m³ there, stress as a cubic from there on


@struct
class Custom(NamedTuple):
    """Loads by laws of the user's, on P nodes, in the order of the nodes."""

    ptr: Ints  # (S + 2,) laws on a node; (0,) without any
    node: Ints  # (P,)
    share: Floats  # (P,) 1, or a length in m
    key: Ints  # (P,) which law (terms/custom.py)
    parameters: Floats  # (P, K)
    base: Floats  # (12,) the base frame in the world: rotation by rows, position in m


@struct
class Wetted(NamedTuple):
    """The surrounding fluid at P places, in the order of their nodes (terms/fluid.py)."""

    ptr: Ints  # (S + 2,) places on a node; (0,) without any
    node: Ints  # (P,)
    frame: Floats  # (P, 12) a place in the frame of its node: rotation by rows, position in m
    added: Floats  # (P, 6) added inertia in kg·m² and mass in kg along its axes
    displaced: Floats  # (P,) kg of fluid
    quadratic: Floats  # (P, 6) drag per squared velocity, N·m·s² and N·s²/m²
    viscous: Floats  # (P, 6) drag per velocity, N·m·s and N·s/m
    lift: Floats  # (P, 3) force per squared velocity across it, N·s²/m²
    law: Ints  # (P,) 0: what resists flow across x goes with the speed across, but for friction
    end: Floats  # (P,) density times area of an end without pressure, > 0 where a rod ends, kg/m
    # (13,) the base frame in the world, rotation by rows, position in m; height in m above the
    # world's origin, against gravity, where the pressure is zero
    base: Floats


@struct
class Closures(NamedTuple):
    """Constraints between two frames. K constraints of R rows, on F nodes that can move."""

    ptr: Ints  # (K + 1,) rows of a constraint
    node: Ints  # (K, 2) nodes of both frames
    place: Ints  # (K, 2) which of the sites they are, −1: the base, which does not move
    site: Ints  # (F, 2) nodes, and the blocks that end there
    offset: Floats  # (K, 12) first frame in its node's: rotation by rows, position in m
    target: Floats  # (K, 12) second frame in its node's, likewise
    catches: Ints  # (K,) 1: made anew, the second frame is where the first is then
    rule: Ints  # (R,) ALONG, DISTANCE or TURN (terms/closures.py)
    vector: Floats  # (R, 4, 3) an axis; a length in m; two pairs of axes
    schedule: Floats  # (K, 2) when it is made and when released, s
    length: Floats  # (1,) m, by which distances are measured


@struct
class Closed(NamedTuple):
    """What constraints do, and scratch."""

    held: Floats  # (K, 13) 0 released, 1 held, 2 by schedule; second frame in its node's (12)
    on: Floats  # (K,) 1 if it acts in the present step
    multiplier: Floats  # (R,) N along an axis, N·m about one
    frame: Floats  # (K, 2, 12) rotation by rows, position in the base frame
    twist: Floats  # (K, 2, 6) spatial twist, base frame
    pull: Floats  # (K, 2, 6) its rate
    value: Floats  # (R,) m or rad: zero where it is met
    speed: Floats  # (R,) its rate
    acceleration: Floats  # (R,) and that of the rate
    wrench: Floats  # (R, 6) spatial wrench on the first frame per multiplier
    dead: Floats  # (F, 6) dead wrenches of the sites without constraints
    active: Ints  # (1,) Data.active[0] likewise


def new_closed(closures: Closures) -> Closed:
    """Allocate constraints as they are when the scene begins."""
    count, rows = len(closures.node), len(closures.rule)
    held = np.zeros((count, 13))
    held[:, 0], held[:, 1:] = 2.0, closures.target
    return Closed(
        held=held,
        on=np.zeros(count),
        multiplier=np.zeros(rows),
        frame=np.zeros((count, 2, 12)),
        twist=np.zeros((count, 2, 6)),
        pull=np.zeros((count, 2, 6)),
        value=np.zeros(rows),
        speed=np.zeros(rows),
        acceleration=np.zeros(rows),
        wrench=np.zeros((rows, 6)),
        dead=np.zeros((len(closures.site), 6)),
        active=np.zeros(1, dtype=np.int64),
    )


@struct
class Tree(NamedTuple):
    """Where branches leave: empty for a chain, in which everything follows what is before it."""

    node: Ints  # (S,) node that a segment begins at
    block: Ints  # (B,) block whose end a block leaves, −1: the base
    slot: Ints  # (B,) where scratch for a block from whose end branches leave lies, −1: none do
    slots: Ints  # (1,) how many do


@struct
class Model(NamedTuple):
    """Immutable arrays of a compiled scene. S segments, S + 1 nodes, n coordinates, B blocks."""

    half: Floats  # (S,) h/2 in m (joints: 1/2)
    kappa: Floats  # (S,) √3 h²/12 in m² (joints, rigid offsets: 0)
    xi0: Floats  # (S, 2, 6) reference strain at the two Gauss points (rigid offsets: their log)
    entry_ptr: Ints  # (S + 1,) entries of a segment
    entry_col: Ints  # (E,) coordinate
    entry_comp: Ints  # (E,) strain component 0…5, ascending within a segment
    entry_phi: Floats  # (E, 2) basis value at the two Gauss points
    inertia: Floats  # (S + 1, 4) lumped mass kg and principal inertia kg·m²
    block_col: Ints  # (B + 1,) first coordinate of a block
    block_seg: Ints  # (B + 1,) first segment of a block
    seg_block: Ints  # (S,) block of a segment
    tree: Tree
    law_ptr: Ints  # (n + 1,) rows of stiffness and damping, zeros left out …
    law_col: Ints  # … their columns
    stiffness: Floats  # … ∫ Φᵀ H Φ ds and joint stiffness
    damping: Floats  # … ∫ Φᵀ Γ Φ ds and joint damping
    branch: Floats  # … stiffness of Maxwell branches; (0,) without
    branch_time: Floats  # (n,) their relaxation times in s; (0,) without
    fibres: Fibres  # the nonlinear part of the elasticity of the rods
    mass_damping: Floats  # (S + 1, 4) Rayleigh's α times the inertia of the rods; (0, 4) without
    # (n,) displacement of the tip beyond per unit coordinate over its distance from the base along
    # the bodies: Newton's norm
    weight: Floats
    port_ptr: Ints  # (A + 1,) linear part of the actuators: dq-columns …
    port_col: Ints
    port_gain: Floats  # … and their gains: position = gain · q
    tendon_ptr: Ints  # (A + 1,) pieces of path of an actuator: a tendon or a chamber
    tendon_seg: Ints  # (P,) segment
    tendon_path: Floats  # (P, 2, 3, 3) [Gauss point][d, d', d''] in the section frame, m, 1, 1/m
    tendon_rest: Floats  # (A,) length in the reference shape, m
    tendon_gain: Floats  # (A,) port position per lengthening: −1 (tendon), its area in m² (chamber)
    length_control: (
        Floats  # (A, 2) N/m and N·s/m of a tendon whose length is commanded; 0: its tension is
    )
    friction: Floats  # (A, 3) coefficient, slip speed in m/s, curvature in 1/m that counts as none
    couple_ptr: Ints  # (A + 1,) columns by which an actuator couples blocks
    chart: Ints  # (C,) first coordinate of every rotation vector (spherical joints, free base)
    # (F, 3) of every free joint the segment that turns it (the one before shifts), its first
    # coordinate, and the node after the last that it carries
    free: Ints
    custom: Custom
    driven: Ints  # (D, 2) coordinates that are told what to do, and their blocks
    fluid: Wetted
    contact: Contact  # with the shapes of the environment
    pairs: Pairs  # contact of bodies with one another
    closures: Closures
    space: Space = Spatial()


def origins(model: Model) -> Ints:
    """Return the node (S,) that each segment begins at."""
    return model.tree.node if len(model.tree.node) else np.arange(len(model.half))


def in_its_plane(model: Model) -> Model:
    """Return the model, marked as planar if no coordinate can move it out of a plane.

    Strain components without coordinates do not change; if those out of the plane vanish at rest
    too, no load and no effort moves a node out of the plane: the section carries such loads as
    reactions. The wrench in ``Data`` then lacks these reactions.
    """
    # nobody knows where custom loads push, and constraints hold what a plane leaves out
    if len(model.custom.node) or len(model.closures.node):
        return model
    for space in (PlaneXY(), PlaneXZ()):
        out = [c for c in range(6) if c not in space.components]
        if not np.isin(model.entry_comp, out).any() and not model.xi0[:, :, out].any():
            contact, pairs = within(model.contact, space), pairs_within(model.pairs, space)
            if contact is None or pairs is None:
                return model
            return model._replace(space=space, contact=contact, pairs=pairs)
    return model


@struct
class Live(NamedTuple):
    """What is commanded while the arm moves, besides efforts and the wrench at the tip.

    W wrenches at places of their own, D driven coordinates.
    """

    push: Floats  # (W, 6) moment N·m, force N; along the axes of the base, or of the section
    follows: Ints  # (W,) 1: along those of the section
    # (D, 9) time in s at which a driven coordinate sets out, how long in s it takes, a polynomial
    # in the part of that time that has passed, constant first, and the rate from then on
    course: Floats


def new_live(pushes: int, driven: int) -> Live:
    """Return what is in force before any command: no wrench, and no motion."""
    return Live(np.zeros((pushes, 6)), np.zeros(pushes, dtype=np.int64), np.zeros((driven, 9)))


@struct
class Data(NamedTuple):
    """Scratch arrays of one simulation; every kernel overwrites what it needs."""

    xi: Floats  # (S, 2, 3, 6) strain, rate, acceleration at the Gauss points
    omega: Floats  # (S, 3, 6) Ω and its two time derivatives
    relative: Floats  # (S, 12) rotation by rows, translation of exp(Ω)
    series: Floats  # (⌈S/4⌉, 40) Stumpff functions c0 … c9 of four segments each
    step: Floats  # (S, 12) T(Ω)Ω̇, the twist a segment adds, and its rate
    dual: Floats  # (S, 12) wrenches dual to the strains at both Gauss points
    rotation: Floats  # (S + 1, 9) node orientation in the base frame
    position: Floats  # (S + 1, 3) node position in the base frame, m
    eta: Floats  # (S + 1, 6) body twist
    acc: Floats  # (S + 1, 6) body acceleration minus gravity
    # (S + 1, 6) sum of inertial minus external wrenches from a node to the tip, body frame
    wrench: Floats
    gravity: Floats  # (3,) base frame, m/s²
    dead: Floats  # (S + 1, 6) moment and force fixed in the base frame
    follower: Floats  # (S + 1, 6) moment and force fixed in the section
    active: Ints  # (2,) flags: any dead wrench, any follower wrench; kernels skip absent ones
    effort: Floats  # (A,) N·m, N or Pa; m pulled in of a tendon whose length is commanded
    now: Floats  # (2,) time in s, and the share of all loads that acts
    laws: Ints  # (P, 2) addresses of the laws of custom loads, and of their derivatives
    custom_power: Floats  # (P,) W at the last sweep
    station: Floats  # (P, 2, 4) along tendons with friction (terms/friction.py)
    section: Floats  # (P, 4) K − K₀ and stretch at the stations of hyperelastic sections
    # (D, 4) of driven coordinates q, q̇, q̈ that they are told, and the force that it takes, N·m or N
    driven: Floats
    current: Floats  # (3, 4) velocity and acceleration of the fluid along world axes
    fluid_power: Floats  # (P, 2) work and loss in W of the fluid at its places, at the last sweep
    live: Live
    touch: Touch
    meet: Meet
    closed: Closed


def new_data(model: Model, pushes: int = 0) -> Data:
    """Allocate zeroed scratch for ``model``, with so many wrenches at places of their own."""
    segments = len(model.half)
    actuators = len(model.port_ptr) - 1
    nodes = segments + 1
    data = Data(
        xi=np.zeros((segments, 2, 3, 6)),
        omega=np.zeros((segments, 3, 6)),
        relative=np.zeros((segments, 12)),
        series=np.zeros((-(-segments // 4), 40)),
        step=np.zeros((segments, 12)),
        dual=np.zeros((segments, 12)),
        rotation=np.zeros((nodes, 9)),
        position=np.zeros((nodes, 3)),
        eta=np.zeros((nodes, 6)),
        acc=np.zeros((nodes, 6)),
        wrench=np.zeros((nodes, 6)),
        gravity=np.zeros(3),
        dead=np.zeros((nodes, 6)),
        follower=np.zeros((nodes, 6)),
        active=np.zeros(2, dtype=np.int64),
        effort=np.zeros(actuators),
        now=np.array([0.0, 1.0]),
        laws=addresses(model.custom.key),
        custom_power=np.zeros(len(model.custom.node)),
        station=np.zeros((len(model.tendon_seg) if model.friction.any() else 0, 2, 4)),
        section=np.zeros((len(model.fibres.block), 4)),
        driven=np.zeros((len(model.driven), 4)),
        current=np.zeros((3, 4)),
        fluid_power=np.zeros((len(model.fluid.node), 2)),
        live=new_live(pushes, len(model.driven)),
        touch=new_touch(model.contact, len(model.pairs.cell), int(model.pairs.slots.sum())),
        meet=new_meet(model.pairs),
        closed=new_closed(model.closures),
    )
    if len(model.contact.node):
        data.touch.call[:3] = late.addresses("contact", model, data)
        data.touch.call[3:] = late.addresses("balance", model, data)
    if len(model.pairs.cell):
        data.meet.call[:] = late.addresses("pairs", model, data)
    data.rotation[0, [0, 4, 8]] = 1.0
    return data


@struct
class Drives(NamedTuple):
    """What driven coordinates are told, as functions of time: D short programs (terms/driven.py).

    A step of a program is an operation on a stack of numbers, with its operand.
    """

    column: Ints  # (D,) coordinate
    ptr: Ints  # (D + 1,) steps of a program
    operation: Ints
    operand: Floats
    table_ptr: Ints  # (K + 1,) rows of a table
    table: Floats  # (…, 5) time in s from which on a cubic holds, its coefficients, constant first


@struct
class Loads(NamedTuple):
    """Scheduled loads, lumped to nodes, and driven coordinates. L loads, P node wrenches."""

    ptr: Ints  # (L + 1,) wrenches of a load
    node: Ints  # (P,)
    wrench: Floats  # (P, 6) moment and force; base frame if dead, section frame if following
    follows: Ints  # (L,) 1: follower, 0: dead
    schedule: Floats  # (L, 3) start, end, ramp in s
    switches: Floats  # sorted times in s at which a factor jumps or bends, or a driven acceleration
    drives: Drives
    current: Drives  # of the fluid along world x, y, z in m/s; without any it is still
    push: Ints  # (W,) nodes of the wrenches that are commanded


@struct
class Samples(NamedTuple):
    """Frames between nodes, each one Magnus step from a node. P samples."""

    node: Ints  # (P,)
    half: Floats  # (P,)
    kappa: Floats  # (P,)
    xi0: Floats  # (P, 2, 6)
    entry_ptr: Ints  # (P + 1,)
    entry_col: Ints
    entry_comp: Ints
    entry_phi: Floats
