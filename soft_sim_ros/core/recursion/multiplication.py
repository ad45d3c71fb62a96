"""The matrix of a forest times a vector, at a cost linear in the blocks; see ``elimination.py``."""

import numpy as np

from soft_sim_ros.core.algebra.spaces import size_of
from soft_sim_ros.core.backend.jit import bare, unit

from .elimination import rows


@unit
def multiply(model, system, x, out):
    """Fill out (n,) with K x, for a system that has been filled.

    Towards the tips goes the motion of all before, s = Σ Q_j x_j, so that block i feels P_iᵀ s;
    towards the base the wrench of all beyond, t = Σ X_j x_j, so that it feels J_iᵀ t.
    """
    x, out = bare(x), bare(out)
    size = size_of(model.space)
    tree, last = model.tree, len(model.block_col) - 2
    forks = len(tree.block) > 0
    s = np.zeros(3 * size)
    kept = np.zeros((tree.slots[0], 3 * size))
    for b in range(last + 1):
        if forks:
            if b > 0 and tree.slot[b - 1] >= 0:
                kept[tree.slot[b - 1]] = s
            p = tree.block[b]
            if p != b - 1:
                for c in range(3 * size):
                    s[c] = kept[tree.slot[p], c] if p >= 0 else 0.0
        begin, m = model.block_col[b], model.block_col[b + 1] - model.block_col[b]
        if m == 0:
            continue
        motion = rows(system, system.motion, 3 * size, b)
        feels = rows(system, system.feels, 3 * size, b)
        for i in range(m):
            at = system.offset[b] + i * m
            total = 0.0
            for j in range(m):
                total += system.diagonal[at + j] * x[begin + j]
            for c in range(3 * size):
                total += feels[c, i] * s[c]
            out[begin + i] = total
        for c in range(3 * size):
            for j in range(m):
                s[c] += motion[c, j] * x[begin + j]
    t = np.zeros(size)
    waiting = np.zeros((tree.slots[0], size))
    for b in range(last, -1, -1):
        if forks:
            if b < last and tree.block[b + 1] != b:
                p = tree.block[b + 1]
                for c in range(size):
                    if p >= 0:
                        waiting[tree.slot[p], c] += t[c]
                    t[c] = 0.0
            if tree.slot[b] >= 0:
                for c in range(size):
                    t[c] += waiting[tree.slot[b], c]
        begin, m = model.block_col[b], model.block_col[b + 1] - model.block_col[b]
        if m == 0:
            continue
        motion = rows(system, system.motion, 3 * size, b)
        exerts = rows(system, system.exerts, size, b)
        for i in range(m):
            for c in range(size):
                out[begin + i] += motion[c, i] * t[c]
        for c in range(size):
            for j in range(m):
                t[c] += exerts[c, j] * x[begin + j]
    for tie in range(system.left.shape[0]):
        share = 0.0
        for j in range(len(x)):
            share += system.right[tie, j] * x[j]
        for i in range(len(x)):
            out[i] += system.left[tie, i] * share
