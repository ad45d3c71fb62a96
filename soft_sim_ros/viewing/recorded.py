"""Tubes of an arm from its scene and the recorded poses alone: nothing is simulated."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from soft_sim_ros.scene import Rod, Scene
from soft_sim_ros.scene.actuator import ChamberActuator, TendonActuator
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


def recorded_tubes(scene: Scene | None, poses: int, length: float) -> list[RecordedTube]:
    """Return the tubes of rods, tendons and chambers through poses at equal arc lengths.

    Parameters
    ----------
    scene : None where the recording has none that can be read: the arm is a plain tube then
    poses : number of recorded poses, base to tip
    length : of the arm in m, for one without a scene
    """
    rods = rods_of(scene) if scene else []
    if scene is None or not rods:
        angle = 2 * np.pi * np.arange(SIDES) / SIDES
        ring = SLENDER * length * np.column_stack([np.cos(angle), np.sin(angle)])
        return [RecordedTube(tuple(range(poses)), np.broadcast_to(ring, (poses, SIDES, 2)))]
    places = _places(rods, poses)
    tubes = []
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
