"""Columns of numbers from a file beside the scene: CSV with a head line, or numpy's npz."""

from __future__ import annotations

import csv
from io import StringIO
from pathlib import Path

import numpy as np

from soft_sim_ros.errors import UnfitFile
from soft_sim_ros.files import MOST_TABLE, read_npz, read_text
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats
from soft_sim_ros.scene.words import nearest


def read_columns(
    reader: Reader, key: str, wanted: tuple[str, ...], optional: tuple[str, ...] = ()
) -> list[Floats]:
    """Return the columns of the file that a key of a scene names, all of one length.

    Those that are ``optional`` come last, and are left out together if one is not there.
    """
    path = Path(reader.document.file).parent / reader.word(key, expected="the name of a file")
    columns = _npz(reader, key, path) if path.suffix == ".npz" else _csv(reader, key, path)
    for name in wanted:
        if name not in columns:
            reader.refuse(f"a file with the column {name!r}; {nearest(name, columns)}", key)
    if all(name in columns for name in optional):
        wanted += optional
    found = [columns[name] for name in wanted]
    for name, column in zip(wanted, found, strict=True):
        if column.shape != found[0].shape or column.ndim != 1:
            reader.refuse(f"columns of one length, {name!r} has another", key)
        if not np.isfinite(column).all():
            reader.refuse(f"finite numbers in the column {name!r}", key)
    return found


def _npz(reader: Reader, key: str, path: Path) -> dict[str, Floats]:
    try:
        return {name: np.asarray(array, dtype=float) for name, array in read_npz(path).items()}
    except (OSError, ValueError, TypeError, UnfitFile) as error:
        reader.refuse(f"a readable npz file of numbers beside the scene ({error})", key)


def _csv(reader: Reader, key: str, path: Path) -> dict[str, Floats]:
    try:
        text = read_text(path, MOST_TABLE)
        head, *rows = [row for row in csv.reader(StringIO(text, newline="")) if row]
        numbers = np.array([[float(cell) for cell in row] for row in rows])
        return {name.strip(): numbers[:, i] for i, name in enumerate(head)}
    except OSError as error:
        reader.refuse(f"a file beside the scene ({error.strerror})", key)
    except UnfitFile as error:
        reader.refuse(f"a CSV file beside the scene ({error})", key)
    except (ValueError, IndexError, csv.Error):
        reader.refuse("a CSV file: a line of names, then lines of as many numbers", key)
