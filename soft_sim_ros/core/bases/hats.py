"""Continuous piecewise linear strain."""

import numpy as np

from soft_sim_ros.core.floats import Floats

from .base import SectionBasis, register


class Linear(SectionBasis):
    """Hat functions at the element ends of a section.

    The strain is continuous within the section.
    """

    kind = "linear"

    def count(self, ends: Floats) -> int:
        """Return how many: one for each element end."""
        return len(ends)

    def values(self, ends: Floats, s: Floats) -> Floats:
        """Return the hats at s."""
        return np.stack([np.interp(s, ends, row) for row in np.eye(len(ends))], axis=1)


register(Linear())
