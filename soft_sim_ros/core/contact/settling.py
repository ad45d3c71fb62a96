"""Contact of bodies with one another between steps: what it stores, what of it can be read off."""

from soft_sim_ros.core.algebra.dual import apply, apply_t, load_mat, load_vec, store_vec
from soft_sim_ros.core.backend.jit import bare, unit
from soft_sim_ros.core.model.contact import CODE, PRESENT, SPAN
from soft_sim_ros.core.model.pairs import GAP
from soft_sim_ros.core.recursion.rnea import kinematics, place, strains

from .law import elastic
from .meeting import home_of, pair_wrenches


@unit
def pair_energy(model, data):
    """Return the energy in J that bodies store where they touch, at the last ``place``."""
    pairs, touch, meet = model.pairs, data.touch, data.meet
    total = 0.0
    if touch.mode[PRESENT] == 0.0:
        return total
    span, power, pattern = touch.mode[SPAN], touch.power[0], touch.pattern[0]
    touch.mode[SPAN] = -1.0
    pair_wrenches(model, data)
    touch.mode[SPAN], touch.power[0], touch.pattern[0] = span, power, pattern
    for i in range(meet.counts[1]):
        q, e = meet.hit[i, 0], meet.hit[i, 1]
        law = pairs.law[pairs.group[pairs.cell[q]], pairs.group[e]]
        total += elastic(law, pairs.share[q], pairs.radius[q], -meet.report[i, GAP])[2]
    return total


@unit
def pair_reports(model, data, q, v, zero):
    """Fill Meet.report for the state (q, v) with the bristles of the state in ``data``."""
    q, v, zero = bare(q), bare(v), bare(zero)
    strains(model, data, q, v, zero)
    kinematics(model, data)
    place(model, data)
    touch = data.touch
    span = touch.mode[SPAN]
    for row in range(len(model.contact.node), len(touch.start)):
        touch.start[row] = touch.bristle[0, row]
    touch.mode[SPAN] = 0.0
    pair_wrenches(model, data)
    touch.mode[SPAN] = span


@unit
def settle_bristles(model, data):
    """After a step, let bristles be at home where they touch: what slides takes them along."""
    pairs, touch, meet = model.pairs, data.touch, data.meet
    for i in range(meet.counts[1]):
        q, e, slot = meet.hit[i, 0], meet.hit[i, 1], meet.hit[i, 2]
        if slot < 0:
            continue
        bristle = touch.bristle[0, len(model.contact.node) + q, slot]
        home = home_of(bristle[CODE])
        if home < 0 or home == e:
            continue
        turn = load_mat(data.rotation[pairs.node[home, 0]])
        u = apply(turn, load_vec(bristle))
        store_vec(bristle, apply_t(load_mat(data.rotation[pairs.node[e, 0]]), u))
        bristle[CODE] += 2.0 * (e - home)
