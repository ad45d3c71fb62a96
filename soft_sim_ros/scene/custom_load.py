"""Loads whose law is a program of the user's: a spring to a point, wind, a magnet."""

from __future__ import annotations

from dataclasses import dataclass

from soft_sim_ros.scene.reader import Reader

# Names of the laws that were registered (core/terms/custom.py) → names of their parameters.
LAWS: dict[str, tuple[str, ...]] = {}


@dataclass(frozen=True, eq=False)
class CustomLoad:
    """A law of the user's at a place of a body, or along a part of a rod.

    parameters : numbers, in the order that the law names them
    start, end : arc lengths in m of a rod along which it acts per length; equal: it acts there
    """

    name: str
    law: str
    parameters: tuple[float, ...]
    body: str
    start: float
    end: float


def read_law(reader: Reader) -> tuple[str, tuple[float, ...]]:
    """Read ``law`` and ``parameters``."""
    law = reader.reference("law", LAWS, "registered law (soft_sim_ros.register_load)")
    own = reader.mapping("parameters").only(*LAWS[law])
    return law, tuple(float(own.number(name)) for name in LAWS[law])
