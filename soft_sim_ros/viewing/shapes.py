"""Shapes as viewers know them: kind, size, colour, and whether they are there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.scene.taper import Floats

# the numbers of visualization_msgs/Marker
ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP, TRIANGLE_LIST = 0, 1, 2, 3, 4, 11
SHOWN, REMOVED = 0, 2

Colour = tuple[float, float, float, float]
SILICONE: Colour = (0.85, 0.80, 0.72, 0.55)  # see-through: tendons run inside
METAL: Colour = (0.45, 0.48, 0.52, 1.0)
PLATE: Colour = (0.30, 0.33, 0.37, 1.0)
LOAD: Colour = (0.80, 0.15, 0.55, 1.0)
MOMENT: Colour = (0.45, 0.25, 0.75, 1.0)
REACTION: Colour = (0.0, 0.40, 0.55, 1.0)
STICKS: Colour = (0.0, 0.62, 0.45, 1.0)
SLIPS: Colour = (0.84, 0.37, 0.0, 1.0)
STONE: Colour = (0.55, 0.53, 0.50, 0.45)
HOLLOW: Colour = (0.55, 0.53, 0.50, 0.2)  # bodies are inside
# from nothing to full effort; told apart by colour-blind readers, too (Okabe and Ito)
_RAMP = ((0.0, 0.45, 0.70), (0.94, 0.80, 0.25), (0.84, 0.37, 0.0))
_NEGATIVE = (0.35, 0.70, 0.90)


@dataclass(frozen=True)
class Shape:
    """What of a shape never changes.

    Parameters
    ----------
    group : what kind of thing it shows, such as ``tendons``; with ``number`` its lasting name
    number : index within the group
    kind : ARROW … TRIANGLE_LIST
    scale : (3,) size in m, with the meaning that visualization_msgs gives it for this kind
    colour : red, green, blue, opacity in [0, 1], until it is drawn otherwise
    points : number of points, for the kinds that have some
    """

    group: str
    number: int
    kind: int
    scale: tuple[float, float, float]
    colour: Colour
    points: int = 0


class Canvas(Protocol):
    """Where one shape is drawn: arrays to be written to."""

    pose: Floats  # (7,) x y z qx qy qz qw in m
    points: Floats  # (n, 3) in m
    colour: NDArray[np.float32]  # (4,)
    action: NDArray[np.int32]  # (1,) SHOWN or REMOVED


def ramp(share: float) -> tuple[float, ...]:
    """Return red, green, blue of an effort as a share of the largest, in [-1, 1]."""
    if share < 0.0:
        begin, end, place = _RAMP[0], _NEGATIVE, min(-share, 1.0)
    elif share <= 0.5:
        begin, end, place = _RAMP[0], _RAMP[1], 2.0 * share
    else:
        begin, end, place = _RAMP[1], _RAMP[2], 2.0 * min(share, 1.0) - 1.0
    return tuple(a + (b - a) * place for a, b in zip(begin, end, strict=True))
