"""What the view of a page shows besides the arm: shapes around it, and forces of contacts."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.recording.reader import Run
from soft_sim_ros.report.style import shown
from soft_sim_ros.scene import Scene
from soft_sim_ros.viewing.shapes import CUBE, CYLINDER
from soft_sim_ros.viewing.surroundings import surroundings

MOST = 16  # arrows at a time: of more contacts the largest forces are shown
_WIDE = 0.75  # a plane is four times this part of what the arm reaches over, m
_WORDS = {CUBE: "box", CYLINDER: "cylinder"}


def solids(scene: Scene | None, extent: float, digits: int) -> list[dict[str, Any]]:
    """Return the shapes of a scene's environment, as the program of the page reads them."""
    if scene is None:
        return []
    return [
        {
            "kind": _WORDS.get(shape.kind, "ball"),
            "size": np.round(shape.scale, digits).tolist(),
            "place": np.round(pose[:3], digits).tolist(),
            "turn": np.round(pose[3:], 6).tolist(),
            "opacity": shape.colour[3],
        }
        for shape, pose in surroundings(scene, _WIDE * extent)
    ]


def pushes(run: Run, time_ns: NDArray[np.int64], digits: int) -> list[list[float]]:
    """Return the contacts at every frame, one after the other; nothing if there are none ever.

    Of each the point in m, the force over the largest one of the run, and whether it sticks.
    """
    found = run.contacts
    if not len(found.at):
        return []
    force = shown(found.force)
    size = np.linalg.norm(force, axis=1)
    largest = float(np.nan_to_num(size).max()) or 1.0
    rows = np.column_stack([np.round(shown(found.point), digits), np.round(force / largest, 4),
                            found.sticks])  # fmt: skip
    begins = np.searchsorted(found.at, np.arange(len(found) + 1))
    out = []
    for at in (np.searchsorted(found.time_ns, time_ns, side="right") - 1).tolist():
        own = np.arange(begins[at], begins[at + 1]) if at >= 0 else np.arange(0)
        own = own[np.isfinite(rows[own]).all(axis=1)]
        chosen = np.sort(own[np.argsort(-size[own], kind="stable")[:MOST]])
        out.append(rows[chosen].ravel().tolist())
    return out
