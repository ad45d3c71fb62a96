"""How contact of bodies couples them in Newton's matrix: K = K₀ + Jᵀ C (J; J̇ …).

C has few rows, six for a node that is touched, so K₀ is solved at linear cost and the rest by the
formula of Sherman, Morrison and Woodbury (terms/couplings.py). Where nodes have more components
than the scene has coordinates, the columns are those of the coordinates.
"""

import numpy as np

from soft_sim_ros.core.algebra.dual import apply, cross, load_mat, load_vec
from soft_sim_ros.core.backend.jit import kernel, unit
from soft_sim_ros.core.backend.late import offer
from soft_sim_ros.core.model.contact import CODE, PRESENT
from soft_sim_ros.core.recursion.elimination import before, new_system, rows

from .meeting import home_of, pair_wrenches
from .settling import pair_energy, settle_bristles
from .slopes import add_hit, spin_of


@kernel
def carried(by, at, out):
    """Fill out (6, 12) with by (6, 12) per spatial twists and their rates, of a node at a place."""
    for i in range(6):
        for part in range(2):
            m, f = 6 * part, 6 * part + 3
            for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                # v = v₀ + θ × p
                out[i, m + a] = by[i, m + a] + by[i, f + c] * at[b] - by[i, f + b] * at[c]
                out[i, f + a] = by[i, f + a]


@kernel
def in_space(data, node, own, sums, by, out):
    """Turn derivatives by (6, 12) of a wrench by the motion of a node into those by spatial twists.

    own : whether the wrench is on that node: then it belongs to its frame, with sums (6,)
    """
    omega, at = spin_of(data, node), load_vec(data.position[node])
    speed = apply(load_mat(data.rotation[node]), load_vec(data.eta[node, 3:]))
    for i in range(6):
        for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # velocities belong to the frame
            by[i, a] += by[i, 6 + c] * omega[b] - by[i, 6 + b] * omega[c]
            by[i, a] += by[i, 9 + c] * speed[b] - by[i, 9 + b] * speed[c]
    if own:
        for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            by[c, b] += sums[a]
            by[b, c] -= sums[a]
            by[3 + c, b] += sums[3 + a]
            by[3 + b, c] -= sums[3 + a]
    carried(by, at, out)


@unit
def node_motion(model, system, node, out):
    """Fill out (12, n) with J of a node, and with the variation of its twist along the columns."""
    out[:] = 0.0
    parts = model.pairs.components
    size = len(parts)
    b = model.seg_block[node - 1]
    begin, end = model.block_col[b], model.block_col[b + 1]
    for c in range(size):
        for j in range(end - begin):
            out[parts[c], begin + j] = system.inner[node, c, j]
            out[6 + parts[c], begin + j] = system.inner[node, size + c, j]
    b = before(model, b)
    while b >= 0:
        begin, end = model.block_col[b], model.block_col[b + 1]
        motion = rows(system, system.motion, 3 * size, b)
        for c in range(size):
            for j in range(end - begin):
                out[parts[c], begin + j] = motion[c, j]
                out[6 + parts[c], begin + j] = motion[size + c, j]
        b = before(model, b)


@kernel
def number_sites(model, data, site):
    """Give numbers to the nodes of all that touches, −1 to others; return how many they are."""
    pairs, touch, meet = model.pairs, data.touch, data.meet
    site[:] = -1
    for i in range(meet.counts[1]):
        q, e, slot = meet.hit[i, 0], meet.hit[i, 1], meet.hit[i, 2]
        g = pairs.cell[q]
        for k in range(2):
            site[pairs.node[g, k]] = site[pairs.node[e, k]] = 0
        if slot >= 0:
            code = touch.after[len(model.contact.node) + q, slot, CODE]
            site[pairs.node[home_of(code), 0]] = 0
    site[0] = -1
    count = 0
    for node in range(len(site)):
        if site[node] == 0:
            site[node] = count
            count += 1
    return count


@unit
def pair_matrices(model, data, alpha, system):
    """Fill the columns by which bodies that touch couple coordinates, at the last residual."""
    ties, n = model.couple_ptr[len(model.couple_ptr) - 1], system.left.shape[1]
    system.tied[0] = ties
    if data.touch.mode[PRESENT] == 0.0 or data.meet.counts[1] == 0:
        return
    site = np.zeros(len(data.position), np.int64)
    count = number_sites(model, data, site)
    if count == 0:
        return
    wide = 6 * count
    matrix, sums = np.zeros((wide, 2 * wide)), np.zeros((count, 6))
    for i in range(data.meet.counts[1]):
        add_hit(model, data, i, site, matrix, sums)
    moves, at = np.zeros((count, 12, n)), np.zeros(count, np.int64)
    for node in range(len(site)):
        if site[node] >= 0:
            at[site[node]] = node
            node_motion(model, system, node, moves[site[node]])
    by, out, given = np.zeros((6, 12)), np.zeros((6, 12)), np.zeros((wide, n))
    for two in range(count):
        for one in range(count):
            used = False
            for i in range(6):
                for j in range(12):
                    by[i, j] = matrix[6 * one + i, 12 * two + j]
                    used = used or by[i, j] != 0.0
            if not used and one != two:
                continue
            in_space(data, at[two], one == two, sums[one], by, out)
            p = load_vec(data.position[at[one]])
            for j in range(12):  # moments about the origin
                f = (out[3, j], out[4, j], out[5, j])
                more = cross(p, f)
                for c in range(3):
                    out[c, j] += more[c]
            for i in range(6):
                for j in range(12):
                    x = -out[i, j] * (alpha[0] if j < 6 else 1.0)
                    if x != 0.0:
                        for m in range(n):
                            given[6 * one + i, m] += x * moves[two, j, m]
    if wide <= n:
        for i in range(wide):
            for m in range(n):
                system.left[ties + i, m] = moves[i // 6, i % 6, m]
                system.right[ties + i, m] = given[i, m]
        system.tied[0] = ties + wide
        return
    for i in range(n):
        for m in range(n):
            system.left[ties + i, m] = 1.0 if m == i else 0.0
            system.right[ties + i, m] = 0.0
        for s in range(wide):
            x = moves[s // 6, s % 6, i]
            if x != 0.0:
                for m in range(n):
                    system.right[ties + i, m] += x * given[s, m]
    system.tied[0] = ties + n


offer(
    "pairs",
    (pair_wrenches, ()),
    (pair_matrices, lambda model: ((1.0, 1.0, 1.0), new_system(model))),
    (pair_energy, ()),
    (settle_bristles, ()),
)
