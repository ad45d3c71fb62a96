"""The bank of shapes and releases of a rod of TPU that SoRoSim computed, as files.

Origin: github.com/ContinuumRoboticsLab/opencr-mujoco, commit 17fff8b (July 2026), MIT licence. The
directory has ``statics/TPURodMuJoCo_dataStatics.csv`` and ``dynamics/TPURodMuJoCo_<k>.txt``. All
numbers have four decimals. Wrenches are dead, along world axes; the rod lies along x from the
origin, where it is clamped, and consists of two halves.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SOURCE = "SoRoSim, by way of opencr-mujoco @ 17fff8b (ContinuumRoboticsLab, 2026)"
LICENCE = "MIT"
HALF = 0.2  # m
LENGTH = 2 * HALF
DIGIT = 5e-5  # half of the last decimal of every number
STATICS = "TPURodMuJoCo_dataStatics.csv"
WRENCH_COLUMNS = (1, 2, 3)  # gravity, mid and tip wrench
STATIONS = 7  # of each half


@dataclass(frozen=True)
class Shape:
    """One equilibrium: what acts, and where the rod lies.

    gravity : (3,) m/s²
    wrenches : (2, 6) moment N·m and force N at the middle and at the tip
    stations : (2, 7) arc lengths from the clamp in m, of both halves
    positions : (2, 7, 3) m
    """

    name: str
    gravity: Floats
    wrenches: Floats
    stations: Floats
    positions: Floats


@dataclass(frozen=True)
class Release:
    """A rod that two wrenches held at rest until time zero.

    damping : s, what the damping is of the stiffness
    times : (N,) s; the first is zero
    mid, tip : (N, 3) m
    """

    name: str
    damping: float
    gravity: Floats
    wrenches: Floats
    times: Floats
    mid: Floats
    tip: Floats


class BankError(ValueError):
    """A directory or a file that is not the bank."""


def shapes(bank: Path) -> list[Shape]:
    """Read all equilibria."""
    file = bank / "statics" / STATICS
    if not file.is_file():
        raise BankError(f"{bank}: expected statics/{STATICS} in it, as in opencr-mujoco's bank")
    with file.open(newline="") as lines:
        rows = list(csv.reader(lines))
    share = np.array(rows[1][4 : 4 + 2 * STATIONS], dtype=float).reshape(2, STATIONS)
    stations = HALF * (share + np.array([[0.0], [1.0]]))
    found = []
    for k in range(2, len(rows) - 5, 6):
        name = rows[k][0].rpartition("_")[2]
        numbers = np.array([row[1 : 4 + 2 * STATIONS] for row in rows[k : k + 6]], dtype=float)
        wrenches = numbers[:, 1:3].T
        places = numbers[3:, 3:].T.reshape(2, STATIONS, 3)
        found.append(Shape(name, numbers[3:, 0], wrenches, stations, places))
    return found


def releases(bank: Path) -> list[Release]:
    """Read all releases."""
    files = list((bank / "dynamics").glob("*.txt"))
    if not files:
        raise BankError(f"{bank}: expected dynamics/*.txt in it, as in opencr-mujoco's bank")
    found = []
    for file in sorted(files, key=lambda f: int(re.findall(r"\d+", f.stem)[-1])):
        rows = np.loadtxt(file)
        wrenches = rows[1, 1:13].reshape(2, 6)
        found.append(
            Release(
                file.stem, float(rows[0, 0]), rows[0, 10:13], wrenches,
                rows[2:, 0], rows[2:, 4:7], rows[2:, 10:13],
            )
        )  # fmt: skip
    return found
