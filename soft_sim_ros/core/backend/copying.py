"""Copies of what holds arrays that kernels know by their addresses.

A copied address still points into the original. So whatever holds one is built anew, from what
never changes and is shared, and gets the content of the original's arrays: it goes on with the same
bits, and neither moves the other.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import numpy as np

from soft_sim_ros.errors import NotCopied


def arrays_of(value: Any) -> Iterator[np.ndarray]:
    """Give the arrays in nested tuples, in their order."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple):
        for part in value:
            yield from arrays_of(part)


def pour(what: str, content: list[np.ndarray], into: Any) -> None:
    """Copy ``content`` into the arrays in nested tuples.

    Raises
    ------
    NotCopied
        if they do not fit, for instance because another version of the package pickled them
    """
    vessels = list(arrays_of(into))
    if [(a.shape, a.dtype) for a in content] != [(a.shape, a.dtype) for a in vessels]:
        raise NotCopied(what, "its arrays are not those of this version of the package")
    for vessel, array in zip(vessels, content, strict=True):
        vessel[...] = array


def take_rest(new: Any, old: Any, memo: dict[int, Any] | None) -> None:
    """Give ``new`` the attributes that others hung on ``old``: deep copies if there is a memo."""
    for name, value in vars(old).items():
        if name not in vars(new):
            setattr(new, name, value if memo is None else copy.deepcopy(value, memo))
