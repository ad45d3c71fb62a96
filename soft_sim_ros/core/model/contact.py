"""Arrays of contact: what touches (stations on bodies), what is touched (shapes), by which law."""

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.algebra.motion_space import Space
from soft_sim_ros.core.backend.structs import struct
from soft_sim_ros.core.floats import Floats, Ints

# Contact.kind
PLANE, SPHERE, CAPSULE, CYLINDER, BOX, ELLIPSOID = range(6)
# columns of Contact.law; STIFFNESS is per share: Pa along rods, N/m^1.5 of HERTZ
KIND, STIFFNESS, ONSET, DISSIPATION, STATIC, KINETIC, ACROSS, TANGENT, TIME = range(9)
# law[KIND]: the pair is left out; force ∝ depth, beyond an onset; Hertz: ∝ depth^1.5
NONE, LINEAR, HERTZ = 0, 1, 2
# columns of Touch.start: the bristle's deflection (3,), and 2 (shape + 1) + whether it sticks
CODE, WIDE = 3, 4
# Touch.mode: ∂q̇/∂q̈ of the stage, below zero: no friction; whether there is contact at all
SPAN, PRESENT = 0, 1
# Touch.call
WRENCHES, MATRICES, ENERGY, BRISTLES, MADE = range(5)
SLOTS = 2  # shapes whose friction a station can feel at a time
FAR = 1e30
STAGES = 6  # of a step, at most


@struct
class Contact(NamedTuple):
    """P stations on bodies, M shapes fixed in the base frame; all arrays empty without shapes."""

    ptr: Ints  # (S + 2,) stations on a node; (0,) without any
    node: Ints  # (P,)
    offset: Floats  # (P, 3) centre of the ball of a station, along the axes of its node, m
    radius: Floats  # (P,) of the ball, m
    share: Floats  # (P,) length that it stands for, m; 1 for HERTZ
    group: Ints  # (P,) row of the laws
    law: Floats  # (C, M, 9) of stations of a group with a shape, see KIND …
    kind: Ints  # (M,)
    size: Floats  # (M, 3) radius, half-length; half edges; semi-axes, m
    rotation: Floats  # (M, 9) axes of a shape in the base frame
    centre: Floats  # (M, 3) m
    sign: Floats  # (M,) 1, or −1: bodies are inside
    bound: Floats  # (M,) radius in m of a ball about the centre that holds the shape; < 0: none
    slots: Ints  # (1,) bristles of a station
    components: Ints  # components of twists that may not vanish


@struct
class Touch(NamedTuple):
    """Scratch of contact: K bristles a station."""

    bristle: Floats  # (1, P, K, 4) of the state
    start: Floats  # (P, K, 4) bristles that a stage begins with
    after: Floats  # (P, K, 4) and ends with
    rates: Floats  # (6, P, K, 4) of the stages of a step, m/s
    kept_back: Floats  # (2, P, K, 4) of the state before a step, before a piece of it
    ends: Floats  # (2, P, K, 4) of the present step of the adaptive method: its two ends …
    final: Floats  # (P, K, 4) … and the rates at the last one
    alive: Ints  # (3,) whether any is not zero: NOW, SAVED, BEFORE (terms/touch.py)
    kept: Ints  # (P,) whether a station begins with a bristle that is not free
    # (P, 4) where a station was when distances were taken, and how far it may move without touching
    near: Floats
    mode: Floats  # (2,) SPAN, PRESENT
    power: Floats  # (1,) dissipated, W, at the last sweep
    pattern: Floats  # (1,) what touches, and how, as one number; 0: nothing
    met: Ints  # (1,) whether anything touched in a stage since it was set to 0
    call: Ints  # (5,) addresses: WRENCHES, MATRICES, ENERGY, BRISTLES, MADE


def no_contact() -> Contact:
    """Return the contact of a scene without an environment."""
    none = np.zeros(0, dtype=np.int64)
    return Contact(
        ptr=none,
        node=none,
        offset=np.zeros((0, 3)),
        radius=np.zeros(0),
        share=np.zeros(0),
        group=none,
        law=np.zeros((0, 0, 9)),
        kind=none,
        size=np.zeros((0, 3)),
        rotation=np.zeros((0, 9)),
        centre=np.zeros((0, 3)),
        sign=np.zeros(0),
        bound=np.zeros(0),
        slots=none,
        components=none,
    )


def new_touch(contact: Contact, more: int = 0, slots: int = 0) -> Touch:
    """Allocate scratch; addresses are filled in by who knows the model.

    more : stations that press on other bodies; their bristles come last
    slots : bristles that each of them may use
    """
    some = min(len(contact.node), 1)
    stations = len(contact.node) + more
    slots = max(slots, int(contact.slots[0]) if some else 0)
    near = np.zeros((len(contact.node), 4))
    near[:, 3] = -1.0
    return Touch(
        bristle=np.zeros((some, stations, slots, WIDE)),
        rates=np.zeros((STAGES * some, stations, slots, WIDE)),
        kept_back=np.zeros((2 * some, stations, slots, WIDE)),
        ends=np.zeros((2 * some, stations, slots, WIDE)),
        final=np.zeros((stations, slots, WIDE)),
        alive=np.zeros(3 * some, dtype=np.int64),
        start=np.zeros((stations, slots, WIDE)),
        after=np.zeros((stations, slots, WIDE)),
        kept=np.zeros(stations, dtype=np.int64),
        near=near,
        mode=np.array([-1.0, 1.0][: 2 * some]),
        power=np.zeros(some),
        pattern=np.zeros(some),
        met=np.zeros(some, dtype=np.int64),
        call=np.zeros(5 * some, dtype=np.int64),
    )


def within(contact: Contact, space: Space) -> Contact | None:
    """Return the contact of a model that moves in a plane; None if shapes push it out of it.

    Nothing does if the shapes, and the balls of every node together, are their own mirror images.
    """
    if not len(contact.node):
        return contact
    out = next(c for c in range(3) if 3 + c not in space.components)
    for kind, axes, centre, bound in zip(
        contact.kind, contact.rotation, contact.centre, contact.bound, strict=True
    ):
        scale = max(1.0, float(np.abs(centre).max()), float(bound))
        turned = np.abs(axes.reshape(3, 3)[out])  # of the shape's axes, along the plane's normal
        along = np.isclose(turned, 0.0, atol=1e-12) | np.isclose(turned, 1.0, atol=1e-12)
        if kind == PLANE and turned[2] > 1e-12:
            return None
        if kind != PLANE and abs(centre[out]) > 1e-12 * scale:
            return None
        if kind in (CAPSULE, CYLINDER) and not along[2]:
            return None
        if kind in (BOX, ELLIPSOID) and not along.all():
            return None
    for node in np.unique(contact.node):
        own = contact.node == node
        rows = np.column_stack([contact.offset[own], contact.radius[own], contact.share[own]])
        mirrored = rows.copy()
        mirrored[:, out] *= -1.0
        order, other = np.lexsort(np.round(rows, 12).T), np.lexsort(np.round(mirrored, 12).T)
        if not np.allclose(rows[order], mirrored[other], rtol=1e-9, atol=1e-12):
            return None
    return contact._replace(components=np.array(space.components, dtype=np.int64))
