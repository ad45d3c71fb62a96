"""What a forest is made of: segments, steps from node to node, and blocks of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.quadrature import composite, gauss

PROJECTION = gauss(16)
ANGULAR = 3  # strain components below this index are rotations

Entry = tuple[int, int, float, float]  # coordinate, component, value at the two Gauss points


@dataclass
class Segment:
    """One step from node to node (see model.py)."""

    half: float
    kappa: float
    xi0: Floats
    entries: list[Entry] = field(default_factory=list)
    span: tuple[float, float] = (0.0, 0.0)  # arc lengths in its rod, m
    origin: int = -1  # the node that it begins at


@dataclass
class Block:
    """Consecutive segments that share the coordinates begin … end − 1."""

    begin: int
    end: int
    first_segment: int
    stiffness: Floats
    damping: Floats
    branch: Floats  # stiffness of Maxwell branches
    branch_time: float = 1.0  # s


def project_linear(function: Callable[[Floats], Floats], marks: Sequence[float]) -> Floats:
    """Return the values (2, m) at the two Gauss points of the best linear fit to a function (N, m).

    The function is smooth between neighbours of ``marks``; first and last are the ends.

    A fourth-order Magnus step depends only on mean and first moment of the function. Taking them
    exactly, instead of point values, makes the step exact for strains that commute, of any degree:
    planar bending, twist, stretch of a straight rod.
    """
    s, w = composite(PROJECTION, marks)
    values = function(s)
    w /= marks[-1] - marks[0]
    mean = w @ values
    moment = (w * (s - marks[0]) / (marks[-1] - marks[0]) - 0.5 * w) @ values
    return np.stack([mean - 2.0 * math.sqrt(3.0) * moment, mean + 2.0 * math.sqrt(3.0) * moment])
