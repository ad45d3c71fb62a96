"""Whether a step made energy while bodies touched.

A step that does not see where a contact begins or ends, or how stiff it is, may throw a body out
faster than it came in. So where something touched, the balance of the step is drawn: what is stored
more, less the work that was done, plus what was lost. A step that makes more than a small part of
what it turned over is cut; one that loses is not.

Bristles jump when they begin to slip, however short a step is, and methods in time that are not
algebraically stable make energy of jumps. So what friction loses in a step is the work that it
took less what its bristles store more then, exactly.
"""

import numpy as np

from soft_sim_ros.core.algebra.dual import dot, load_vec
from soft_sim_ros.core.backend.jit import bare, unit
from soft_sim_ros.core.backend.late import offer
from soft_sim_ros.core.model.contact import CODE, TANGENT
from soft_sim_ros.core.recursion.output import energies
from soft_sim_ros.core.terms.actuators import port_motion

SHARE = 2e-4  # of the energy that a step turns over
# of the energy that is there, that of the weight included, and has been turned over so far: no
# step is cut for less
TRIFLE = 1e-7
SLOW = 1e-6  # m/s: no velocity is known better


@unit
def bristle_energy(model, data, bristles):
    """Return the energy in J that bristles (P, K, 4) store."""
    bristles = bare(bristles)
    contact, pairs = model.contact, model.pairs
    total, shaped = 0.0, len(contact.node)
    for row in range(bristles.shape[0]):
        for k in range(bristles.shape[1]):
            other = int(bristles[row, k, CODE]) // 2 - 1
            if other < 0:
                continue
            if row < shaped:
                kappa = contact.law[contact.group[row], other, TANGENT] * contact.share[row]
            else:
                q = row - shaped
                law = pairs.law[pairs.group[pairs.cell[q]], pairs.group[other]]
                kappa = law[TANGENT] * pairs.share[q]
            u = load_vec(bristles[row, k])
            total += 0.5 * kappa * dot(u, u)
    return total


@unit
def energy_made(model, data, effort, q0, v0, old, q1, v1, new, worked, lost, whole):
    """Return the energy that a step made over what it may make.

    Parameters
    ----------
    q0, v0, q1, v1 : (n,) of its ends; old, new : (P, K, 4) bristles there
    worked, lost : J, work of loads and energy dissipated in it
    whole : J that have been turned over so far
    """
    effort, q0, v0, q1, v1 = bare(effort), bare(q0), bare(v0), bare(q1), bare(v1)
    touch = data.touch
    kept, zero, actuators = touch.bristle[0].copy(), np.zeros(len(q0)), len(effort)
    later = new.copy()  # it may be the state's own
    first, last = np.zeros(actuators), np.zeros(actuators)
    rate, acting = np.zeros(actuators), np.zeros(actuators)
    touch.bristle[0] = old
    kinetic, elastic, weight = energies(model, data, q0, v0, zero)
    port_motion(model, data, q0, v0, first, rate, acting)
    touch.bristle[0] = later
    more, bent, lifted = energies(model, data, q1, v1, zero)
    port_motion(model, data, q1, v1, last, rate, acting)
    touch.bristle[0] = kept
    put_in = worked
    for i in range(actuators):
        if model.length_control[i, 0] == 0.0:
            put_in += effort[i] * (last[i] - first[i])
    made = more - kinetic + bent - elastic + lifted - weight - put_in + lost
    turned = abs(more - kinetic) + abs(bent - elastic) + abs(lifted - weight)
    turned += abs(put_in) + abs(lost)
    mass = 0.0
    for k in range(model.inertia.shape[0]):
        mass += model.inertia[k, 0]
    # what Newton's method leaves of velocities moves energy too
    rough = SLOW * (np.sqrt(2.0 * mass * more) + mass * SLOW)
    small = TRIFLE * (whole + more + bent + abs(put_in) + abs(lifted))
    return made / (SHARE * turned + small + rough + 1e-300)


offer(
    "balance",
    (bristle_energy, (np.zeros((0, 0, 0)),)),
    (
        energy_made,
        (
            *(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((0, 0, 0))),
            *(np.zeros(0), np.zeros(0), np.zeros((0, 0, 0)), 0.0, 0.0, 0.0),
        ),
    ),
)
