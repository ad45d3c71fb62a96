"""Lists of numbers and segments as the contiguous arrays that kernels take."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.floats import Floats, Ints

from .segments import Segment


def floats(values: object) -> Floats:
    """Return a contiguous array of doubles."""
    return np.ascontiguousarray(np.array(values, dtype=np.float64))


def ints(values: object) -> Ints:
    """Return a flat array of integers."""
    return np.array(values, dtype=np.int64).reshape(-1)


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
