"""What touches in a state, for reading off."""

import math

from soft_sim_ros.core.algebra.dual import add, cross, dot, load_vec, scale, sub
from soft_sim_ros.core.backend.jit import bare, unit
from soft_sim_ros.core.model.contact import (
    ACROSS,
    CODE,
    KIND,
    KINETIC,
    NONE,
    STATIC,
    TANGENT,
    TIME,
)
from soft_sim_ros.core.recursion.rnea import kinematics, place, strains

from .law import along, motion, pushed, weighed
from .shapes import distance

# columns of a row
GAP, NORMAL, POINT, PUSH, PULL, STICKS, SLIDE = 0, 1, 4, 7, 8, 11, 12
COLUMNS = 15


@unit
def contact_rows(model, data, q, v, zero, rows):
    """Fill rows (P, M, 15) of stations and shapes: gap in m, normal, point, forces in N, slip.

    Along the axes of the base frame: the normal (3,) off the shape; the point (3,) of the body's
    surface; the normal force; the force of friction (3,) on the body; 1 if it sticks; the velocity
    (3,) of the point along the surface in m/s. Pairs that are left out have a gap of infinity.
    Bristles are those of the state in ``data``.
    """
    q, v, zero, rows = bare(q), bare(v), bare(zero), bare(rows)
    strains(model, data, q, v, zero)
    kinematics(model, data)
    place(model, data)
    contact = model.contact
    slots = data.touch.start.shape[1]
    for e in range(len(contact.node)):
        radius, share = contact.radius[e], contact.share[e]
        _, centre, omega, speed, axis = motion(model, data, e)
        for s in range(len(contact.kind)):
            law = contact.law[contact.group[e], s]
            row = rows[e, s]
            for c in range(COLUMNS):
                row[c] = 0.0
            row[GAP] = math.inf
            if law[KIND] == NONE:
                continue
            d, n, _ = distance(contact, s, centre)
            row[GAP] = d - radius
            point = sub(centre, scale(radius, n))
            slide = sub(along(n, speed), scale(radius, cross(omega, n)))
            for c in range(3):
                row[NORMAL + c], row[POINT + c], row[SLIDE + c] = n[c], point[c], slide[c]
            if d >= radius:
                continue
            row[PUSH] = pushed(law, share, radius, n, radius - d, speed)[0]
            for k in range(slots):
                code = int(data.touch.bristle[0, e, k, CODE])
                if code // 2 != s + 1:
                    continue
                # what sticks bends its bristle at the rate of the slip, else it says where to
                u, w = along(n, load_vec(data.touch.bristle[0, e, k])), slide
                if law[ACROSS] != 1.0:
                    w = along(n, weighed(law[ACROSS], axis, slide))
                g = scale(law[TANGENT] * share, add(u, scale(law[TIME], w)))
                most = (law[STATIC] if code % 2 == 1 else law[KINETIC]) * row[PUSH]
                size = math.sqrt(dot(g, g))
                if size > most or (code % 2 == 0 and size > 0.0):
                    g = scale(most / size, g)
                pull = g
                if law[ACROSS] != 1.0:
                    pull = along(n, weighed(law[ACROSS], axis, g))
                for c in range(3):
                    row[PULL + c] = -pull[c]
                row[STICKS] = float(code % 2)
