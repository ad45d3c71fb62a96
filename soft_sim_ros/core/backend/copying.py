"""Copies of objects whose arrays kernels know by address.

A copied address would still point into the original. So such an object is constructed again from
its immutable, shared parts, and the content of the original's arrays is copied into it. The copy
continues with the same bits, independent of the original.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import numpy as np


def arrays_of(value: Any) -> Iterator[np.ndarray]:
    """Yield the arrays in nested tuples, in order."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple):
        for part in value:
            yield from arrays_of(part)


def take_rest(new: Any, old: Any, memo: dict[int, Any] | None) -> None:
    """Copy attributes that users added to ``old`` to ``new``; deep copies if memo is given."""
    for name, value in vars(old).items():
        if name not in vars(new):
            setattr(new, name, value if memo is None else copy.deepcopy(value, memo))
