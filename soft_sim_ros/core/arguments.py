"""Arguments of public functions as the contiguous numbers that kernels take, or `BadArgument`."""

from __future__ import annotations

import numbers
import operator
from typing import Any

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import BadArgument


def vector(name: str, value: object, size: int, finite: bool = False) -> Floats:
    """Return an argument as the numbers (size,) that kernels take: they do not count.

    They are contiguous, writable doubles, and those given themselves if they are that already.

    Raises
    ------
    BadArgument
        if it is of another shape, or not of real numbers; with ``finite``: if not of finite ones.
    """
    array = real(name, value, f"{size} {'finite ' if finite else ''}numbers")
    if array.shape != (size,) or (finite and not np.isfinite(array).all()):
        raise BadArgument(name, value, f"{size} {'finite ' if finite else ''}numbers")
    return array


def vector_or_zeros(name: str, value: object | None, size: int, finite: bool = False) -> Floats:
    """Return ``vector`` of an argument that may be left out: None stands for zeros."""
    return np.zeros(size) if value is None else vector(name, value, size, finite)


def real(name: str, value: object, expected: str = "real numbers") -> Floats:
    """Return an argument as contiguous, writable doubles of any shape.

    Numbers only: what has an imaginary part, a text, a truth value or a hidden entry of a masked
    array would lose its meaning without a word.

    Raises
    ------
    BadArgument
        if it is not of real numbers
    """
    if type(value) is np.ndarray and value.dtype == _DOUBLE and value.flags.carray:
        return value
    try:
        given = np.asarray(value)
        if given.dtype.kind == "O":  # numbers that no type of numpy holds, or no numbers
            given = np.array([float(x) for x in _numbers(given)]).reshape(given.shape)
    except (TypeError, ValueError, OverflowError):  # rows of different lengths, no numbers
        raise BadArgument(name, value, expected) from None
    if (given.dtype.kind not in "iuf" and given.size) or np.ma.is_masked(value):
        raise BadArgument(name, value, expected)
    return np.require(given, np.float64, ["C", "A", "W"])


_DOUBLE = np.dtype(np.float64)


def _numbers(array: np.ndarray) -> list[Any]:
    """Return the entries of an array of objects, all of them real numbers."""
    entries = array.ravel().tolist()
    if not all(isinstance(x, numbers.Real) and not isinstance(x, bool) for x in entries):
        raise TypeError
    return entries


def number(
    name: str, value: object, low: float = -np.inf, expected: str = "finite number"
) -> float:
    """Return an argument as one finite number, at least ``low``.

    Raises
    ------
    BadArgument
        if it is not
    """
    if isinstance(value, float) and low <= value < np.inf and value != -np.inf:
        return float(value)
    array = real(name, value, f"a {expected}")
    if array.shape != () or not (np.isfinite(array) and array >= low):
        raise BadArgument(name, value, f"a {expected}")
    return float(array)


def whole(name: str, value: Any, least: int, most: int) -> int:
    """Return an argument as a whole number: an int, or what numpy has for one.

    Raises
    ------
    BadArgument
        if it is not, or is outside of [least, most]
    """
    if not isinstance(value, bool | np.bool_):
        try:
            index = operator.index(value)
        except TypeError:
            pass
        else:
            if least <= index <= most:
                return index
    raise BadArgument(name, value, f"a whole number in [{least}, {most}]")
