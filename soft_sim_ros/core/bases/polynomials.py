"""Polynomials on an element."""

import numpy as np
from numpy.polynomial import chebyshev, legendre

from soft_sim_ros.core.floats import Floats

from .base import ElementBasis, register


class Legendre(ElementBasis):
    """Legendre polynomials: orthogonal, ∫ P_i P_j = 2/(2i + 1) δ_ij on [−1, 1]."""

    kind = "legendre"

    def values(self, order: int, t: Floats) -> Floats:
        """Return P_0 … P_order at t."""
        return np.asarray(legendre.legvander(t, order), dtype=np.float64)


class Chebyshev(ElementBasis):
    """Chebyshev polynomials of the first kind: the same space, nearly minimax truncation."""

    kind = "chebyshev"

    def values(self, order: int, t: Floats) -> Floats:
        """Return T_0 … T_order at t."""
        return np.asarray(chebyshev.chebvander(t, order), dtype=np.float64)


class Monomial(ElementBasis):
    """Powers of x = (1 + t)/2 ∈ [0, 1].

    Coefficients are easy to read, badly conditioned beyond order 6.
    """

    kind = "monomial"

    def values(self, order: int, t: Floats) -> Floats:
        """Return 1, x, … x^order at t."""
        return np.vander(0.5 * (1.0 + t), order + 1, increasing=True)


class Constant(ElementBasis):
    """Piecewise constant strain on elements (PCS), for any order."""

    kind = "constant"

    def count(self, order: int) -> int:
        """Return 1."""
        return 1

    def values(self, order: int, t: Floats) -> Floats:
        """Return ones."""
        return np.ones((len(t), 1))


for _basis in (Legendre(), Chebyshev(), Monomial(), Constant()):
    register(_basis)
