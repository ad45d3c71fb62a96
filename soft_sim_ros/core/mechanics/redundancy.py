"""Rows of constraints that say nothing new: whose they are, and what says the same."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.floats import Floats

# Rows that move less than this, over the row that moves most, are implied by others.
DEPENDENT = 1e-9


class Redundancy(NamedTuple):
    """What of a constraint others say already.

    Attributes
    ----------
    rows : how many of its rows the constraints before it imply, or nothing can move along
    held : rows that it has
    beside : names of the constraints before it that say the same; none: bodies and joints alone do
    """

    rows: int
    held: int
    beside: tuple[str, ...]

    def words(self) -> str:
        """Say it."""
        by = ", ".join(self.beside) or "the joints between its frames"
        return f"{self.rows} of {self.held} rows are implied by {by}"


def redundancies(names: Sequence[str], blocks: Sequence[Floats]) -> dict[str, Redundancy]:
    """Return what constraints say twice, in their order.

    Parameters
    ----------
    names : of the constraints that act
    blocks : their rows (r, n), one below the other scaled alike
    """
    found: dict[str, Redundancy] = {}
    largest = max((float(np.linalg.norm(rows, 2)) for rows in blocks if rows.size), default=0.0)
    before = 0  # rank of all rows so far
    owner = np.repeat(np.arange(len(names)), [len(rows) for rows in blocks])
    for k, name in enumerate(names):
        rows = np.concatenate(blocks[: k + 1])
        left, size, _ = np.linalg.svd(rows, full_matrices=len(rows) > rows.shape[1])
        rank = int(np.count_nonzero(size > DEPENDENT * largest))
        implied = len(blocks[k]) - (rank - before)
        if implied:
            # combinations of rows that vanish, and take part of those of this constraint
            nothing = left[:, rank:]
            own = nothing[owner[: len(rows)] == k]
            part = nothing @ own.T
            beside = [
                names[j]
                for j in range(k)
                if np.abs(part[owner[: len(rows)] == j]).max(initial=0.0) > 1e-6
            ]
            found[name] = Redundancy(implied, len(blocks[k]), tuple(beside))
        before = rank
    return found
