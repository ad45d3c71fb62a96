"""The units of what a recording holds about actuators, from the scene inside it."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

from soft_sim_ros.errors import SceneError
from soft_sim_ros.recording.reader import Run
from soft_sim_ros.scene import Scene, parse_scene
from soft_sim_ros.scene.actuator import PULLING, TURNING, Units

UNKNOWN = Units("", "", "", "")
DRIVEN = {
    "rad": TURNING._replace(command="rad"),
    "m": PULLING._replace(command="m"),
}


def port_units(run: Run) -> dict[str, Units]:
    """Return the units of every port of the run's scene, by name and in its order.

    Empty where no scene is inside, or one that this version cannot read (of a later version, or
    with profiles that a program has registered): a report has no unit then rather than a wrong one.
    """
    scene = scene_of(run)
    if scene is None:
        return {}
    driven = zip(scene.commanded, scene.commanded_units, strict=True)
    return {a.name: a.units for a in scene.actuators} | {
        name: DRIVEN[unit] for name, unit in driven
    }


def scene_of(run: Run) -> Scene | None:
    """Return the scene inside a recording; None without one that this version can read."""
    return _scene_of(run.scene_text or "")


def grouped(names: Iterable[str], units: dict[str, Units]) -> dict[tuple[str, str], list[int]]:
    """Return the indices of ports that may share axes, by their units of effort and position."""
    found: dict[tuple[str, str], list[int]] = {}
    for index, name in enumerate(names):
        of = units.get(name, UNKNOWN)
        found.setdefault((of.effort, of.position), []).append(index)
    return found


def labelled(name: str, unit: str) -> str:
    """Return a name with its unit, if it has one."""
    return f"{name} ({unit})" if unit else name


@lru_cache(maxsize=8)
def _scene_of(text: str) -> Scene | None:
    try:
        return parse_scene(text)
    except SceneError:
        return None
