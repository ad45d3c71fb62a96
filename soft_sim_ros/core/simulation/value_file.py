"""Values as files of arrays: ``.npz`` without pickle, each part under its own name."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import numpy as np
from numpy.lib import format as npy

from soft_sim_ros.core.floats import Floats, Ints
from soft_sim_ros.errors import StateError
from soft_sim_ros.files import read_npz, write_whole

from .value import Value

V = TypeVar("V", bound=Value)
FORMAT = "format"
# kind of part → kind of array in the file, its dimensions (None: any) and what that is in words
_KINDS: dict[Any, tuple[str, int | None, str]] = {
    Floats: ("f", None, "an array of numbers"),
    Ints: ("i", None, "an array of whole numbers"),
    int: ("i", 0, "a whole number"),
    float: ("f", 0, "a number"),
    bool: ("b", 0, "True or False"),
    str: ("U", 0, "a text"),
    tuple[str, ...]: ("U", 1, "a list of texts"),
}
_STORED = {"f": "<f8", "i": "<i8", "b": "|b1"}


def save(value: Value, form: str, path: str | Path) -> None:
    """Write a value and the name of its format to a file, whole or not at all."""
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_STORED) as archive:
        for name, part in [(FORMAT, form), *_flat(value, "")]:
            array = np.asarray(part)
            if array.size == 0 and isinstance(part, tuple):
                array = np.zeros(0, dtype="<U1")
            array = array.astype(_STORED.get(array.dtype.kind, array.dtype.newbyteorder("<")))
            # a fixed date: the same value makes the same bytes
            with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w") as member:
                npy.write_array(member, array, allow_pickle=False)
    write_whole(path, content.getvalue())


def load(kind: type[V], form: str, path: str | Path) -> V:
    """Read a value of a class and of a format from a file.

    Raises
    ------
    StateError
        if it is of another format, or a part is missing, unknown or not as expected
    UnfitFile, OSError
        if it is no file of arrays, or cannot be read
    """
    arrays = read_npz(path)
    found = arrays.pop(FORMAT, None)
    if found is None or found.dtype.kind != "U" or found.shape != () or str(found) != form:
        is_there = "missing" if found is None else repr(found.tolist())[:100]
        raise StateError(path, FORMAT, is_there, repr(form))
    value = _made(kind, arrays, "", path)
    if arrays:
        raise StateError(path, min(arrays), "there", "no such key")
    return value


def _flat(value: Value, of: str) -> Iterator[tuple[str, Any]]:
    for name, part in value.parts():
        if isinstance(part, Value):
            yield from _flat(part, f"{of}{name}.")
        else:
            yield of + name, part


def _made(kind: type[V], arrays: dict[str, np.ndarray], of: str, path: str | Path) -> V:
    """Take the parts of a value out of the arrays of a file."""
    parts: dict[str, Any] = {}
    for name, hint in get_type_hints(kind).items():
        key = of + name
        if hint not in _KINDS:  # a value in this one
            parts[name] = _made(hint, arrays, f"{key}.", path)
            continue
        letter, dimensions, expected = _KINDS[hint]
        array = arrays.pop(key, None)
        if array is None:
            raise StateError(path, key, "missing", expected)
        if array.dtype.kind != letter or dimensions not in (None, array.ndim):
            raise StateError(path, key, f"of type {array.dtype} {array.shape}", expected)
        if letter in _STORED:
            array = array.astype(_STORED[letter])
        if hint in (Floats, Ints):
            parts[name] = array
        else:
            given = array.tolist()
            parts[name] = tuple(given) if isinstance(given, list) else given
    return kind(**parts)
