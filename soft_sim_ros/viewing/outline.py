"""Outlines of cross-sections, and where along a body they are drawn."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from soft_sim_ros.scene import FlexibleLink, Rod, Scene
from soft_sim_ros.scene.actuator import ChamberActuator, TendonActuator
from soft_sim_ros.scene.cross_section import Annulus, Circle, CrossSection, Ellipse, Rectangle
from soft_sim_ros.scene.section import Section
from soft_sim_ros.scene.taper import Floats
from soft_sim_ros.scene.tendon import HelicalPath, Stretch, TablePath

# Sides of an outline, multiples of 4, so that a rectangle keeps its corners: of pictures, and of
# messages, which have to be small.
SIDES, FEW = 12, 8
PER_TURN = 16  # stations of one turn of a helix
Path = TendonActuator | ChamberActuator


class Station(NamedTuple):
    """A cross-section to be drawn: arc length s in m of its rod, and x in [0, 1] of a section."""

    s: float
    section: Section
    x: float


def outline(shape: CrossSection, x: float, sides: int = SIDES) -> Floats:
    """Return the outer edge (sides, 2) of a cross-section at x in [0, 1]: y, z in m.

    All begin at the same corner and go around from y towards z, so outlines of any two kinds can
    be joined.
    """
    at = np.asarray(x, dtype=float)
    angle = np.pi / 4 + 2 * np.pi * np.arange(sides) / sides
    unit = np.column_stack([np.cos(angle), np.sin(angle)])
    if isinstance(shape, Circle):
        scale = [shape.radius(at)] * 2
    elif isinstance(shape, Annulus):
        scale = [shape.outer(at)] * 2
    elif isinstance(shape, Ellipse):
        scale = [shape.semi_axis_y(at), shape.semi_axis_z(at)]
    elif isinstance(shape, Rectangle):
        scale = [shape.width_y(at) / 2, shape.width_z(at) / 2]
        unit = _square(sides)
    else:  # a shape of another package: a circle of the same area
        scale = [np.sqrt(shape.area(at) / np.pi)] * 2
    return unit * np.array(scale, dtype=float)


def _square(sides: int) -> Floats:
    """Return the edge (sides, 2) of the square [-1, 1]², its corners among the points."""
    corners = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 1.0]])
    step = np.arange(sides // 4)[:, None] / (sides // 4)
    edges = itertools.pairwise(corners)
    return np.concatenate([a + (b - a) * step for a, b in edges])


@dataclass(frozen=True)
class Stations:
    """All stations of one rod, base to tip; where sections meet, each has one of its own."""

    rod: Rod
    items: tuple[Station, ...]

    @property
    def s(self) -> Floats:
        """Arc lengths (P,) in m."""
        return np.array([item.s for item in self.items])

    def rings(self, sides: int) -> Floats:
        """Return the outlines (P, sides, 2) in m."""
        edges = [outline(item.section.cross_section, item.x, sides) for item in self.items]
        return np.array(edges)

    def along(self, stretch: Stretch) -> list[int]:
        """Return the stations on a stretch of a path, one where two lie at the same place."""
        slack = 1e-9 * self.rod.length
        chosen: list[int] = []
        for i, item in enumerate(self.items):
            inside = stretch.start - slack <= item.s <= stretch.end + slack
            if inside and not (chosen and item.s <= self.items[chosen[-1]].s + slack):
                chosen.append(i)
        return chosen


def stations(rod: Rod, paths: list[Path], count: int) -> Stations:
    """Return about ``count`` stations of a rod, and those that the paths along it begin, end at."""
    marks, pitch = set(), rod.length / count
    for path in paths:
        for stretch in path.stretches:
            if stretch.rod == rod.name:
                marks |= stretch.cuts
                pitch = min(pitch, _pitch(stretch))
    items: list[Station] = []
    for section, begin, end in zip(
        rod.sections, rod.boundaries[:-1], rod.boundaries[1:], strict=True
    ):
        pieces = max(2 if section.kinks else 1, math.ceil((end - begin) / pitch - 1e-9))
        inner = {begin + (end - begin) * i / pieces for i in range(1, pieces)}
        inner |= {begin + (end - begin) * x for x in section.kinks}
        inner |= {s for s in marks if begin < s < end}
        items += [
            Station(s, section, (s - begin) / (end - begin)) for s in [begin, *sorted(inner), end]
        ]
    return Stations(rod, tuple(items))


def _pitch(stretch: Stretch) -> float:
    """Return the distance of stations in m that shows the turns of a path."""
    share, length = stretch.last - stretch.first, stretch.end - stretch.start
    if isinstance(stretch.path, HelicalPath) and stretch.path.turns:
        return max(length / (abs(stretch.path.turns) * share * PER_TURN), length / 400)
    if isinstance(stretch.path, TablePath):
        return length / min(4 * len(stretch.path.u), 400)
    return length


def rods_of(scene: Scene) -> list[Rod]:
    """Return what has a thickness: rods, and the rods that floating-frame links are."""
    found = []
    for body in scene.bodies:
        if isinstance(body, Rod):
            found.append(body)
        elif isinstance(body, FlexibleLink):
            found.append(body.rod)
    return found


def thickness(scene: Scene, length: float) -> float:
    """Return a radius in m that goes with the arm: its thickest, or a part of its length."""
    radii = [
        float(np.linalg.norm(outline(section.cross_section, x), axis=1).max())
        for rod in rods_of(scene)
        for section in rod.sections
        for x in (0.0, 1.0)
    ]
    return max(radii, default=0.04 * length)
