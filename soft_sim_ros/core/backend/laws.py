"""Compiled laws of the user's, by a number that stands for their names on every machine."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

import numpy as np

from soft_sim_ros.core.floats import Ints
from soft_sim_ros.errors import BadArgument

_known: dict[int, tuple[int, int]] = {}
_kept: list[object] = []


def key_of(name: str) -> int:
    """Return the number of a name."""
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:7], "big")


def note_law(name: str, law: int, derivatives: int, *functions: object) -> None:
    """Note the addresses of a law and of its derivatives, and keep their functions alive."""
    _known[key_of(name)] = law, derivatives
    _kept.extend(functions)


def addresses(keys: Sequence[int] | Ints) -> Ints:
    """Return the addresses (P, 2) of laws and derivatives, given their numbers."""
    missing = [int(key) for key in keys if int(key) not in _known]
    if missing:
        expected = "laws that this process has registered (soft_sim_ros.register_load)"
        raise BadArgument("law", missing[0], expected)
    return np.array([_known[int(key)] for key in keys], dtype=np.int64).reshape(-1, 2)
