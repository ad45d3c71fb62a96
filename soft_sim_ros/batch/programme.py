"""Efforts over time from a CSV file: a header ``time,<actuator>,…``, then one row per change."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.errors import SoftSimError
from soft_sim_ros.files import MOST_TABLE, read_text


class ProgrammeError(SoftSimError):
    """A file of commands cannot be used.

    Parameters
    ----------
    file : its name
    line : counted from 1
    found, expected : what is there, and what should be
    """

    def __init__(self, file: str, line: int, found: str, expected: str) -> None:
        super().__init__(file, line, found, expected)
        self.file, self.line, self.found, self.expected = file, line, found, expected

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.found}: expected {self.expected}"


@dataclass(frozen=True)
class Programme:
    """Efforts that are held from a time on, until the next.

    Parameters
    ----------
    time : (T,) s, never falling
    efforts : (T, A) in scene order, in the units of their commands
    """

    time: NDArray[np.float64]
    efforts: NDArray[np.float64]

    def steps(self, step: float) -> NDArray[np.int64]:
        """Step (T,) at whose start each row is taken up: the first boundary not before its time."""
        # A time that was meant to be a boundary may miss it by its last decimal digits.
        return np.ceil(self.time / step - 1e-6).astype(np.int64)


def read_programme(path: str | Path, actuators: Sequence[str], safe: Sequence[float]) -> Programme:
    """Read a file of commands.

    Parameters
    ----------
    path : the file
    actuators : (A,) names in scene order
    safe : (A,) efforts of actuators that the file does not name

    Raises
    ------
    ProgrammeError
        with file, line, what was found and what was expected
    UnfitFile
        if it is no regular file, too large, or no text
    """
    file = str(path)
    text = read_text(path, MOST_TABLE)
    rows = csv.reader(StringIO(text, newline=""), skipinitialspace=True)
    try:
        header = [name.strip() for name in next(rows, [])]
        columns = _columns(file, header, actuators)
        times: list[float] = []
        efforts: list[NDArray[np.float64]] = []
        for row in rows:
            if not row or row[0].lstrip().startswith("#"):
                continue
            numbers = _numbers(file, rows.line_num, row, header)
            time = numbers[0]
            if time < (times[-1] if times else 0.0):
                expected = f"a time of at least {times[-1] if times else 0.0:g} s"
                raise ProgrammeError(file, rows.line_num, f"time = {time:g} s", expected)
            effort = np.array(safe, dtype=float)
            effort[columns] = numbers[1:]
            times.append(time)
            efforts.append(effort)
    except csv.Error as error:
        raise ProgrammeError(file, rows.line_num, str(error), "a CSV file") from error
    return Programme(np.array(times), np.array(efforts).reshape(len(times), len(actuators)))


def _columns(file: str, header: list[str], actuators: Sequence[str]) -> list[int]:
    expected = "time," + ",".join(actuators) + " (or some of these actuators, in any order)"
    if header[:1] != ["time"]:
        raise ProgrammeError(file, 1, f"header {','.join(header)!r}", expected)
    for index, name in enumerate(header[1:], 1):
        if name not in actuators:
            raise ProgrammeError(file, 1, f"unknown actuator {name!r}", expected)
        if name in header[1:index]:
            raise ProgrammeError(file, 1, f"{name!r} is there twice", "each actuator once")
    return [list(actuators).index(name) for name in header[1:]]


def _numbers(file: str, line: int, row: list[str], header: list[str]) -> list[float]:
    if len(row) != len(header):
        raise ProgrammeError(file, line, f"{len(row)} values", f"{len(header)}, as in the header")
    numbers = []
    for name, text in zip(header, row, strict=True):
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise ProgrammeError(file, line, f"{name} = {text!r}", "a finite number")
        numbers.append(number)
    return numbers
