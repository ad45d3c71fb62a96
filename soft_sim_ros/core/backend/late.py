"""Units that only some scenes need: offered by name, compiled when a model asks for them.

What calls them does so by address, so a scene that does not need them compiles none of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from soft_sim_ros.core.floats import Ints

from .jit import address

# examples of arguments, or what makes them for a model
Examples = tuple[Any, ...] | Callable[[Any], tuple[Any, ...]]
_offered: dict[str, list[tuple[Any, Examples]]] = {}


def offer(name: str, *units: tuple[Any, Examples]) -> None:
    """Offer units; each with examples of its arguments after the model and the scratch."""
    _offered[name] = list(units)


def calls(name: str, model: Any, data: Any) -> list[tuple[Any, ...]]:
    """Return the calls of units under a name, to be compiled for a model and its scratch."""
    return [
        (function, model, data, *(rest(model) if callable(rest) else rest))
        for function, rest in _offered[name]
    ]


def addresses(name: str, model: Any, data: Any) -> Ints:
    """Return the addresses of the units under a name, compiled if need be."""
    return np.array([address(*call) for call in calls(name, model, data)], dtype=np.int64)
