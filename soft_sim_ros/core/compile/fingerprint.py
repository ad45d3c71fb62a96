"""Few numbers by which a model is known again, on this machine or another."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np

from soft_sim_ros.core.floats import Floats

# Multiples of the golden ratio, modulo 1: exact in floating point on every machine, and so far from
# any pattern that a change of one number is not made up for by that of another.
GOLDEN = 0.6180339887498949


def fingerprint(parts: Any) -> dict[str, Floats]:
    """Return the four sums of every array in nested named tuples."""
    return {name: sums(array) for name, array in _arrays(parts)}


def _arrays(parts: Any, of: str = "") -> Iterator[tuple[str, np.ndarray]]:
    for name, part in parts._asdict().items():
        if isinstance(part, np.ndarray):
            yield of + name, part
        elif hasattr(part, "_asdict"):
            yield from _arrays(part, f"{of}{name}.")


def sums(array: np.ndarray) -> Floats:
    """Return of an array (4,): a weighted sum, Σ |x|, its size, and where numbers are infinite."""
    x = array.ravel().astype(np.float64)
    weight = _weights(max(256, 1 << len(x).bit_length()))[: len(x)]
    endless = np.isinf(x)  # as times are of what never ends
    finite = np.where(endless, 0.0, x)
    return np.array(
        [weight @ finite, np.abs(finite).sum(), len(x), weight[endless] @ np.sign(x[endless])]
    )


@lru_cache(maxsize=32)
def _weights(count: int) -> Floats:
    return 0.5 + np.arange(1.0, count + 1.0) * GOLDEN % 1.0
