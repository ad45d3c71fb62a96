"""Derivatives of the residual of a large arm, block by block: nothing of the size (n, n) is made.

A dense matrix of n coordinates costs n² numbers and n³ operations; the blocks of a forest cost n of
both (``recursion/elimination.py``). What Newton's method, stability and continuation ask of a
matrix is here: its solution, its product, and how many of its directions are negative.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.recursion.elimination import diagonal_of, factor, new_system, solve
from soft_sim_ros.core.recursion.multiplication import multiply
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.terms.driven import HELD

from .dynamics import Dynamics

FROM = 250  # coordinates: fewer are solved as fast, or faster, by a dense matrix


class Blocks:
    """α₀ ∂r/∂q + α₁ ∂r/∂q̇ + α₂ ∂r/∂q̈ at the last residual, of coordinates in a mask.

    Parameters
    ----------
    dynamics : the arm
    mask : (n,) bool, the coordinates that may move
    """

    def __init__(self, dynamics: Dynamics, mask: NDArray[np.bool_]) -> None:
        self.dynamics, self.mask = dynamics, mask
        self._model = dynamics.model
        self._system = new_system(self._model)
        self.tied = self._system.left.shape[0] > 0
        self._diagonal = diagonal_of(self._model, self._system)

    @staticmethod
    def serve(dynamics: Dynamics, mask: NDArray[np.bool_]) -> bool:
        """Whether the arm is large, and its matrix is all in the blocks: no constraints act."""
        return int(np.count_nonzero(mask)) >= FROM and not len(dynamics.constraints)

    def fill(self, alpha: tuple[float, float, float]) -> None:
        """Take the derivatives at the last residual; factor before solving."""
        tangent(self._model, self.dynamics.scratch, alpha, self._system)

    @property
    def diagonal(self) -> Floats:
        """The diagonal (n,) of what was filled in."""
        ties = (self._system.left * self._system.right).sum(axis=0)
        return np.asarray(self._system.diagonal[self._diagonal] + ties)

    def add(self, diagonal: Floats) -> None:
        """Add a diagonal matrix (n,)."""
        self._system.diagonal[self._diagonal] += diagonal

    def factor(self) -> bool:
        """Factor the matrix; False if it is singular or not finite."""
        still = self._diagonal[~self.mask]
        held = self._system.diagonal[still]
        self._system.diagonal[still] = HELD * np.maximum(1.0, np.abs(held))
        return bool(factor(self._model, self._system))

    def solve(self, right: Floats) -> Floats:
        """Return x (n,) with K x = right (n,) after ``factor``; 0 outside the mask."""
        x = np.where(self.mask, right, 0.0)
        solve(self._model, self._system, x)
        x[~self.mask] = 0.0
        return x

    def times(self, x: Floats) -> Floats:
        """Return K x (n,) before ``factor``, of the coordinates in the mask."""
        out = np.empty(len(x))
        multiply(self._model, self._system, np.where(self.mask, x, 0.0), out)
        out[~self.mask] = 0.0
        return out

    def negative(self, scale: Floats) -> int:
        """Return how many eigenvalues below zero a symmetric matrix has, after ``factor``.

        By the law of inertia (Haynsworth 1968): elimination from the tips leaves blocks, and the
        matrix has as many negative directions as they have together. Ties between blocks are not
        among them.

        scale : (n,) units in which the matrix is of order one
        """
        count, system = 0, self._system
        block_col = self._model.block_col
        same: dict[int, list[Floats]] = {}
        for b, (begin, end) in enumerate(zip(block_col[:-1], block_col[1:], strict=True)):
            m = int(end - begin)
            if m == 0:
                continue
            kept = system.inverse[system.square[b] : system.square[b + 1]].reshape(m, -1)[:, :m]
            unit = scale[begin:end]
            same.setdefault(m, []).append(kept * np.outer(unit, unit))
        for blocks in same.values():
            stack = np.stack(blocks)
            values = np.linalg.eigvalsh(0.5 * (stack + stack.transpose(0, 2, 1)))
            count += int(np.count_nonzero(values < 0.0))
        return count
