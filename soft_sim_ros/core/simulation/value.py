"""Immutable values made of arrays, numbers, texts and other such values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any, TypeVar

import numpy as np

V = TypeVar("V", bound="Value")


class Value:
    """What dataclasses inherit from whose parts can never be changed, arrays included.

    They are compared by the bits of their parts (so NaN is NaN, and -0.0 is not 0.0), can be keys
    of dictionaries, are pickled, and are their own copies. To be declared with
    ``@dataclass(frozen=True, eq=False)``.
    """

    def __post_init__(self) -> None:
        """Take copies of the arrays, which nobody can write to."""
        for name, part in self.parts():
            if isinstance(part, np.ndarray):
                object.__setattr__(self, name, frozen(part))

    def parts(self) -> Iterator[tuple[str, Any]]:
        """Give names and parts."""
        for field in fields(self):  # type: ignore[arg-type]
            yield field.name, getattr(self, field.name)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        if self is other:
            return True
        return all(
            _bits(mine) == _bits(theirs)
            for (_, mine), (_, theirs) in zip(self.parts(), other.parts(), strict=True)
        )

    def __hash__(self) -> int:
        return hash((type(self), *(_bits(part) for _, part in self.parts())))

    def __copy__(self: V) -> V:
        return self

    def __deepcopy__(self: V, memo: dict[int, Any]) -> V:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), tuple(part for _, part in self.parts())


def frozen(array: np.ndarray) -> np.ndarray:
    """Return a copy of an array that cannot be made writable again: it lies in bytes."""
    if isinstance(array.base, np.ndarray) and isinstance(array.base.base, bytes):
        return array
    native = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("="))
    return np.frombuffer(native.tobytes(), native.dtype).reshape(array.shape)


def _bits(part: Any) -> Any:
    """Return what decides whether two parts are the same."""
    if isinstance(part, np.ndarray):
        return part.dtype.str, part.shape, part.tobytes()
    if isinstance(part, float):
        return part.hex()
    return part
