"""A quantity that varies along a section as a straight line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Taper:
    """``start`` at x = 0, ``end`` at x = 1, a straight line between them."""

    start: float
    end: float

    @property
    def knots(self) -> tuple[float, ...]:
        """Places in (0, 1) where a derivative jumps: none."""
        return ()

    @property
    def kinks(self) -> tuple[float, ...]:
        """Places in (0, 1) where the slope jumps: none."""
        return ()

    @property
    def resolving(self) -> Floats:
        """Places in [0, 1] that show it: its ends."""
        return np.array([0.0, 1.0])

    def __call__(self, x: Floats) -> Floats:
        """Return the values at normalised arc lengths x in [0, 1], same shape as x."""
        x = np.asarray(x, dtype=float)
        # This form is exact at both ends and gives a constant exactly.
        return np.where(x < 0.5, self.start + (self.end - self.start) * x,
                        self.end - (self.end - self.start) * (1.0 - x))  # fmt: skip
