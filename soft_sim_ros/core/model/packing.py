"""Lists of numbers and segments as the contiguous arrays that kernels take."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.floats import Floats, Ints

from .model import Tree
from .segments import Block, Segment


def floats(values: object) -> Floats:
    """Return a contiguous array of doubles."""
    return np.ascontiguousarray(np.array(values, dtype=np.float64))


def ints(values: object) -> Ints:
    """Return a flat array of integers."""
    return np.array(values, dtype=np.int64).reshape(-1)


def flat_tree(segments: list[Segment], blocks: list[Block]) -> Tree:
    """Return where segments and blocks leave from."""
    node = ints([s.origin for s in segments])
    if (node == np.arange(len(segments))).all():
        return Tree(node=ints([]), block=ints([]), slot=ints([]), slots=ints([0]))
    ends = {b.first_segment: i - 1 for i, b in enumerate(blocks)} | {len(segments): len(blocks) - 1}
    # the block that ends in node p has segment p − 1; node 0 is the base
    block = ints([ends[int(node[b.first_segment])] for b in blocks])
    forks = sorted({p for i, p in enumerate(block.tolist()) if p not in (i - 1, -1)})
    slot = np.full(len(blocks), -1, dtype=np.int64)
    slot[forks] = np.arange(len(forks))
    return Tree(node=node, block=block, slot=slot, slots=ints([len(forks)]))


def flat_entries(segments: list[Segment]) -> tuple[Ints, Ints, Ints, Floats]:
    """Return entry_ptr, entry_col, entry_comp and entry_phi of segments (model.py).

    Entries of a segment come in the order of their strain components.
    """
    flat = [e for segment in segments for e in sorted(segment.entries, key=lambda e: e[1])]
    return (
        ints([0, *np.cumsum([len(segment.entries) for segment in segments])]),
        ints([entry[0] for entry in flat]),
        ints([entry[1] for entry in flat]),
        floats([entry[2:] for entry in flat]).reshape(-1, 2),
    )
