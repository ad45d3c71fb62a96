"""Paths of tendons and chambers: where in the cross-section they run, along their rod."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from soft_sim_ros.scene.body import ROUNDING, Rod
from soft_sim_ros.scene.interval import NONNEGATIVE, Interval
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats, Taper

PATHS = ("offset", "helix", "points")
SHARP = 0.5  # change of slope from one point of a path to the next, at which its rod is cut


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

    def curvature(self, u: Floats) -> Floats:
        """Return d²d/du² (…, 3)."""
        return np.zeros((*np.shape(u), 3))


@dataclass(frozen=True)
class HelicalPath:
    """A helix about the backbone: radius in m, first angle in rad from y towards z, turns."""

    radius: Taper
    angle: float
    turns: float

    def offset(self, u: Floats) -> Floats:
        """Return d (…, 3) at u (…) in [0, 1], start to end of the tendon."""
        return self._rows(u, self.radius(u), 0.0)

    def slope(self, u: Floats) -> Floats:
        """Return dd/du (…, 3)."""
        return self._rows(u, self._growth, self._rate * self.radius(u))

    def curvature(self, u: Floats) -> Floats:
        """Return d²d/du² (…, 3)."""
        return self._rows(u, -(self._rate**2) * self.radius(u), 2.0 * self._rate * self._growth)

    @property
    def _rate(self) -> float:
        return 2.0 * math.pi * self.turns

    @property
    def _growth(self) -> float:
        return self.radius.end - self.radius.start

    def _rows(self, u: Floats, outwards: Floats | float, around: Floats | float) -> Floats:
        """Return the vectors (…, 3) with these components along and across the radius at u."""
        phase = self.angle + self._rate * u
        cos, sin = np.cos(phase), np.sin(phase)
        rows = [np.zeros_like(u), outwards * cos - around * sin, outwards * sin + around * cos]
        return np.stack(rows, axis=-1)


@dataclass(frozen=True)
class TablePath:
    """A natural cubic spline through points: positions u (N,) in [0, 1], offsets (y, z) (N, 2)."""

    u: tuple[float, ...]
    points: tuple[tuple[float, float], ...]

    @cached_property
    def _spline(self) -> scipy.interpolate.CubicSpline:
        return scipy.interpolate.CubicSpline(self.u, np.array(self.points), bc_type="natural")

    def offset(self, u: Floats) -> Floats:
        """Return d (…, 3) at u (…) in [0, 1], start to end of the tendon."""
        return self._values(u, 0)

    def slope(self, u: Floats) -> Floats:
        """Return dd/du (…, 3)."""
        return self._values(u, 1)

    def curvature(self, u: Floats) -> Floats:
        """Return d²d/du² (…, 3)."""
        return self._values(u, 2)

    def _values(self, u: Floats, order: int) -> Floats:
        yz = self._spline(u, order)
        return np.concatenate([np.zeros((*np.shape(u), 1)), yz], axis=-1)


Path = StraightPath | HelicalPath | TablePath


@dataclass(frozen=True)
class Stretch:
    """The part of a path that runs along one rod, from arc length ``start`` to ``end`` in m.

    ``first`` and ``last`` are where on the path that is, u in [0, 1].
    """

    rod: str
    start: float
    end: float
    path: Path
    first: float = 0.0
    last: float = 1.0

    def offset(self, s: Floats) -> Floats:
        """Return where the path runs, d (…, 3) in m in the section frame, d_x = 0."""
        return self.path.offset(self._fraction(s))

    def slope(self, s: Floats) -> Floats:
        """Return d' = dd/ds (…, 3)."""
        return self.path.slope(self._fraction(s)) * self._rate

    def curvature(self, s: Floats) -> Floats:
        """Return d'' (…, 3) in 1/m."""
        return self.path.curvature(self._fraction(s)) * self._rate**2

    @property
    def cuts(self) -> set[float]:
        """Arc lengths in m where its rod has to be cut: both ends, and points of sharp turns."""
        found = {self.start, self.end}
        if isinstance(self.path, TablePath):
            u = np.array(self.path.u)
            turn = np.linalg.norm(np.diff(self.path.slope(u) * self._rate, axis=0), axis=1)
            sharp = np.append(turn > SHARP, False) | np.append(False, turn > SHARP)
            s = self.start + (u[sharp] - self.first) / self._rate
            found |= {x for x in s.tolist() if self.start < x < self.end}
        return found

    @property
    def _rate(self) -> float:
        return (self.last - self.first) / (self.end - self.start)

    def _fraction(self, s: Floats) -> Floats:
        return self.first + (np.asarray(s, dtype=float) - self.start) * self._rate


@dataclass(frozen=True)
class Routed:
    """An actuator along a path through one rod, or through several that are rigidly joined."""

    name: str
    limits: tuple[float, float]
    safe: float
    stretches: tuple[Stretch, ...]

    def along(self, rod: str, s: float) -> Stretch | None:
        """Return the stretch that an arc length of a rod lies in, if any."""
        for stretch in self.stretches:
            if stretch.rod == rod and stretch.start < s < stretch.end:
                return stretch
        return None


@dataclass(frozen=True)
class Lane:
    """Rods in a row, as one arc length."""

    rods: tuple[Rod, ...]

    @property
    def length(self) -> float:
        """Length of all rods in m."""
        return sum(rod.length for rod in self.rods)

    def snap(self, s: float) -> float:
        """Return the section boundary that an arc length means, else the arc length itself."""
        behind = 0.0
        for rod in self.rods[:-1]:
            if s < behind + rod.length * (1.0 - ROUNDING):
                return behind + rod.snap(s - behind)
            behind += rod.length
        return behind + self.rods[-1].snap(s - behind)

    def stretches(self, start: float, end: float, path: Path) -> tuple[Stretch, ...]:
        """Return the stretches of a path from ``start`` to ``end``."""
        out, behind = [], 0.0
        for rod in self.rods:
            begin, stop = max(start - behind, 0.0), min(end - behind, rod.length)
            if stop - begin > ROUNDING * rod.length:
                first, last = ((behind + s - start) / (end - start) for s in (begin, stop))
                out.append(Stretch(rod.name, begin, stop, path, first, last))
            behind += rod.length
        return tuple(out)


def read_points(reader: Reader, lane: Lane) -> tuple[float, float, TablePath]:
    """Read ``points``, a list of [s, y, z] in m, s rising; return start, end and the path."""
    for key in ("start", "end"):
        reader.no_effect(key, "the first and the last of the points say it")
    rows = reader.matrix("points", None, 3).reshape(-1, 3)
    s = np.array([lane.snap(value) for value in rows[:, 0].tolist()])
    inside = Interval(0.0, lane.length * (1.0 + ROUNDING), True, True)
    if any(value not in inside for value in s):
        reader.refuse(f"points [s, y, z] with every s a {inside}", "points")
    if len(s) < 2 or np.any(np.diff(s) <= 1e-9 * lane.length):
        reader.refuse("at least two points [s, y, z], in the order of rising s", "points")
    start, end = float(s[0]), float(s[-1])
    u = (s - start) / (end - start)
    path = TablePath(tuple(u.tolist()), tuple((y, z) for y, z in rows[:, 1:].tolist()))
    return start, end, path


def read_path(reader: Reader, length: float) -> StraightPath | HelicalPath:
    """Read ``offset`` or ``helix`` of a path along a stretch of some length in m."""
    if reader.has("helix"):
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
