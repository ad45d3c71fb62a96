"""Contacts of a recording: messages to arrays, numbers to names."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from soft_sim_ros.errors import SoftSimError
from soft_sim_ros.recording.cloud import POINT, Cloud
from soft_sim_ros.recording.decode import Decoded
from soft_sim_ros.recording.series import ContactSeries
from soft_sim_ros.scene import parse_scene

_AXES = ("x", "y", "z")


def names_in(text: str | None) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of bodies and shapes in a scene; none where it cannot be read."""
    if text is None:
        return (), ()
    try:
        scene = parse_scene(text, "scene.yaml")
    except SoftSimError:  # of another version: numbers have to do
        return (), ()
    bodies = tuple(body.name for body in scene.bodies)
    return bodies, tuple(shape.name for shape in scene.environment)


def contacts_of(
    messages: Sequence[tuple[int, Decoded]], bodies: Sequence[str], shapes: Sequence[str]
) -> ContactSeries:
    """Return contacts as arrays.

    Parameters
    ----------
    messages : time in ns, and the cloud of contacts at that time
    bodies, shapes : names in the order of their numbers; what has none is ``#`` and its number
    """
    clouds = [cloud for _, cloud in messages if isinstance(cloud, Cloud)]
    points = np.concatenate([np.empty(0, POINT), *(cloud.points for cloud in clouds)])

    def vector(name: str) -> np.ndarray:
        names = [f"{name}_{axis}" for axis in _AXES] if name else list(_AXES)
        return np.stack([points[one] for one in names], axis=1).astype(float)

    def named(field: str) -> np.ndarray:
        names = (*bodies, *shapes)
        found = points[field].tolist()
        return np.array([names[i] if i < len(names) else f"#{i}" for i in found], dtype=np.str_)

    return ContactSeries(
        time_ns=np.array([time_ns for time_ns, _ in messages], np.int64),
        frame_id=clouds[0].frame_id if clouds else "",
        at=np.repeat(np.arange(len(clouds)), [len(cloud.points) for cloud in clouds]),
        body=named("body"),
        other=named("other"),
        s=points["s"].astype(float),
        point=vector(""),
        normal=vector("normal"),
        gap=points["gap"].astype(float),
        normal_force=points["normal_force"].astype(float),
        friction=vector("friction"),
        slip=vector("slip"),
        sticks=points["sticks"] != 0,
    )
