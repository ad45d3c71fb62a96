"""The contract of a strain basis and the table of known ones."""

from abc import ABC, abstractmethod

from soft_sim_ros.core.floats import Floats

from ...scene.numerics import BASES


class ElementBasis(ABC):
    """Functions of t ∈ [−1, 1] along one element, with coordinates of its own.

    A subclass sets ``kind`` and gives ``values``; the functions of order p must span those of
    order p − 1.
    """

    kind: str

    def count(self, order: int) -> int:
        """Return the number of functions of an order."""
        return order + 1

    @abstractmethod
    def values(self, order: int, t: Floats) -> Floats:
        """Return (len(t), count(order)) values at t (N,) in [−1, 1]."""


class SectionBasis(ABC):
    """Functions of arc length along a whole section, with coordinates shared by its elements."""

    kind: str

    @abstractmethod
    def count(self, ends: Floats) -> int:
        """Return the number of functions for element ends (elements + 1,) in m."""

    @abstractmethod
    def values(self, ends: Floats, s: Floats) -> Floats:
        """Return (len(s), count(ends)) values at arc lengths s (N,) in m."""


Basis = ElementBasis | SectionBasis
_BASES: dict[str, Basis] = {}


def register(basis: Basis) -> None:
    """Make a basis known under its ``kind``, to scenes as well."""
    _BASES[basis.kind] = basis
    if basis.kind not in BASES:
        BASES.append(basis.kind)


def get_basis(kind: str) -> Basis:
    """Return the basis of a kind."""
    return _BASES[kind]
