"""Strain bases: how a strain component varies along a section.

Two shapes of basis exist. An *element basis* has its own coordinates in every element of a
section; a *section basis*
shares coordinates across the elements of a section. Both are a name and two functions;
``register`` adds one.
"""

from .base import ElementBasis, SectionBasis, get_basis, register
from .hats import Linear
from .polynomials import Chebyshev, Constant, Legendre, Monomial

__all__ = [
    "Chebyshev",
    "Constant",
    "ElementBasis",
    "Legendre",
    "Linear",
    "Monomial",
    "SectionBasis",
    "get_basis",
    "register",
]
