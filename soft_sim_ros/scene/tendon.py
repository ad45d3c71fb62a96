"""Paths of tendons: where in the cross-section a tendon runs, along the arc length of its rod."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene.interval import NONNEGATIVE
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats, Taper


@dataclass(frozen=True)
class StraightPath:
    """Offsets (y, z) in m, a straight line from the start of the tendon to its end."""

    y: Taper
    z: Taper

    def offset(self, u: Floats) -> Floats:
        """Return d (…, 3) at u (…) in [0, 1], start to end of the tendon."""
        return np.stack([np.zeros_like(u), self.y(u), self.z(u)], axis=-1)

    def slope(self, u: Floats) -> Floats:
        """Return dd/du (…, 3)."""
        row = np.array([0.0, self.y.end - self.y.start, self.z.end - self.z.start])
        return np.broadcast_to(row, (*np.shape(u), 3)).copy()


@dataclass(frozen=True)
class HelicalPath:
    """A helix about the backbone: radius in m, first angle in rad from y towards z, turns."""

    radius: Taper
    angle: float
    turns: float

    def offset(self, u: Floats) -> Floats:
        """Return d (…, 3) at u (…) in [0, 1], start to end of the tendon."""
        phase = self.angle + 2 * math.pi * self.turns * u
        radius = self.radius(u)
        rows = [np.zeros_like(u), radius * np.cos(phase), radius * np.sin(phase)]
        return np.stack(rows, axis=-1)

    def slope(self, u: Floats) -> Floats:
        """Return dd/du (…, 3)."""
        rate = 2 * math.pi * self.turns
        phase = self.angle + rate * u
        radius, growth = self.radius(u), self.radius.end - self.radius.start
        along_y = growth * np.cos(phase) - radius * rate * np.sin(phase)
        along_z = growth * np.sin(phase) + radius * rate * np.cos(phase)
        return np.stack([np.zeros_like(u), along_y, along_z], axis=-1)


def read_path(reader: Reader, length: float) -> StraightPath | HelicalPath:
    """Read ``offset`` or ``helix`` of a tendon of some length in m."""
    if reader.one_of(("offset", "helix")) == "helix":
        helix = reader.mapping("helix").only("radius", "angle", "turns", "pitch")
        radius = helix.taper("radius", NONNEGATIVE)
        angle = helix.number("angle", default=0.0)
        if helix.one_of(("turns", "pitch")) == "turns":
            return HelicalPath(radius, angle, helix.number("turns"))
        pitch = helix.number("pitch")
        if pitch == 0.0 or not math.isfinite(length / pitch):
            helix.refuse("a number other than 0 (m of arc length per turn)", "pitch")
        return HelicalPath(radius, angle, length / pitch)
    if reader.is_mapping("offset"):
        ends = reader.mapping("offset").only("from", "to")
        first, last = ends.vector("from", 2), ends.vector("to", 2)
    else:
        first = last = reader.vector("offset", 2)
    (y0, z0), (y1, z1) = first.tolist(), last.tolist()
    return StraightPath(Taper(y0, y1), Taper(z0, z1))
