"""Tubes of an arm from its scene and the recorded poses alone: nothing is simulated."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene import Rod, Scene
from soft_sim_ros.scene.actuator import ChamberActuator, TendonActuator
from soft_sim_ros.scene.limbs import limbs_of
from soft_sim_ros.scene.taper import Floats
from soft_sim_ros.viewing.outline import SIDES, Path, outline, rods_of, thickness

ROUND = 6  # sides of a tendon
SLENDER = 0.02  # radius over length of an arm of which nothing is known


@dataclass(frozen=True)
class RecordedTube:
    """A tube through recorded poses.

    Parameters
    ----------
    at : (P,) indices of poses
    rings : (P, M, 2) in m, in the y-z planes of these poses
    actuator : name of the actuator whose effort colours it; None for the arm itself
    """

    at: tuple[int, ...]
    rings: Floats
    actuator: str | None = None


def recorded_tubes(
    scene: Scene | None, poses: Mapping[str, int], length: float
) -> list[RecordedTube]:
    """Return the tubes of rods, tendons and chambers through poses at equal arc lengths.

    Parameters
    ----------
    scene : None where the recording has none that can be read: the arm is a plain tube then
    poses : name of each backbone → number of its recorded poses, base to tip, all one after the
        other; one alone may be called ``""``
    length : of the arm in m, for one without a scene
    """
    rows = _rows(scene, list(poses)) if scene else None
    if scene is None or not rows:
        angle = 2 * np.pi * np.arange(SIDES) / SIDES
        ring = SLENDER * length * np.column_stack([np.cos(angle), np.sin(angle)])
        ends = np.cumsum([0, *poses.values()]).tolist()
        return [
            RecordedTube(tuple(range(a, b)), np.broadcast_to(ring, (b - a, SIDES, 2)))
            for a, b in itertools.pairwise(ends)
        ]
    places = [
        place
        for row, count in zip(rows, poses.values(), strict=True)
        for place in _places(row, count)
    ]
    tubes = []
    rods = [rod for row in rows for rod in row]
    for rod in rods:
        own = [(i, s) for i, (name, s) in enumerate(places) if name == rod.name]
        if len(own) > 1:
            rings = np.array([_ring(rod, s) for _, s in own])
            tubes.append(RecordedTube(tuple(i for i, _ in own), rings))
    thin = 0.07 * thickness(scene, sum(rod.length for rod in rods))
    for actuator in scene.actuators:
        if isinstance(actuator, TendonActuator | ChamberActuator):
            tubes += _path(actuator, places, thin)
    return tubes


def _rows(scene: Scene, names: list[str]) -> list[list[Rod]] | None:
    """Return the rods of each of some backbones; None if the scene has others."""
    rods, found = iter(rods_of(scene)), {}
    limbs = limbs_of(scene)
    for name, row in zip(limbs.backbones, limbs.rows, strict=True):
        found[name] = [next(rods) for _ in row]
    if len(found) == len(names) == 1:
        return list(found.values())
    return [found[name] for name in names] if set(names) <= found.keys() else None


def _places(rods: list[Rod], poses: int) -> list[tuple[str, float]]:
    """Return the rod and the arc length in m on it of every pose."""
    ends = np.cumsum([rod.length for rod in rods])
    found = []
    for s in np.linspace(0.0, ends[-1], poses).tolist():
        index = min(int(np.searchsorted(ends, s - 1e-9 * ends[-1])), len(rods) - 1)
        begin = ends[index] - rods[index].length
        found.append((rods[index].name, min(max(s - begin, 0.0), rods[index].length)))
    return found


def _ring(rod: Rod, s: float) -> Floats:
    for section, begin, end in zip(
        rod.sections, rod.boundaries[:-1], rod.boundaries[1:], strict=True
    ):
        if s <= end:
            return outline(section.cross_section, (s - begin) / (end - begin))
    return outline(rod.sections[-1].cross_section, 1.0)


def _path(path: Path, places: list[tuple[str, float]], thin: float) -> list[RecordedTube]:
    """Return a path as one tube: it may run along several rods."""
    radius = math.sqrt(path.area / math.pi) if isinstance(path, ChamberActuator) else thin
    angle = 2 * np.pi * np.arange(ROUND) / ROUND
    ring = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    at, rings = [], []
    for stretch in path.stretches:
        for i, (name, s) in enumerate(places):
            if name == stretch.rod and stretch.start - 1e-9 <= s <= stretch.end + 1e-9:
                at.append(i)
                rings.append(stretch.offset(np.array(s))[1:] + ring)
    return [RecordedTube(tuple(at), np.array(rings), path.name)] if len(at) > 1 else []
