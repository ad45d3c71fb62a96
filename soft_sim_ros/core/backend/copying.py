"""Copies of what holds arrays that kernels know by their addresses.

A copied address still points into the original. So whatever holds one is built anew, from what
never changes and is shared, and gets the state of the original: it goes on with the same bits, and
neither moves the other.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import numpy as np


def arrays_of(value: Any) -> Iterator[np.ndarray]:
    """Give the arrays in nested tuples, in their order."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple):
        for part in value:
            yield from arrays_of(part)


def take_rest(new: Any, old: Any, memo: dict[int, Any] | None) -> None:
    """Give ``new`` the attributes that others hung on ``old``: deep copies if there is a memo."""
    for name, value in vars(old).items():
        if name not in vars(new):
            setattr(new, name, value if memo is None else copy.deepcopy(value, memo))
