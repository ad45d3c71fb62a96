"""What stands around an arm and never moves: the shapes of its environment."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from soft_sim_ros.scene import Scene
from soft_sim_ros.scene.environment import Shape as Solid
from soft_sim_ros.scene.taper import Floats
from soft_sim_ros.viewing.shapes import CUBE, CYLINDER, HOLLOW, SPHERE, STONE, Shape

GROUP = "environment"
PARTS = 3  # most markers of one shape: a capsule has three
THIN = 0.01  # of the length: how thick a plane is drawn
Scale = tuple[float, float, float]


def surroundings(scene: Scene, length: float) -> list[tuple[Shape, Floats]]:
    """Return the shapes of a scene's environment, and their poses (7,) in the world.

    A plane is a slab as wide as two lengths of the arm in m, below its face; a capsule a cylinder
    with two balls. Numbers are ``PARTS`` times the index of the shape, and what follows.
    """
    found = []
    for index, solid in enumerate(scene.environment):
        if solid.on not in (None, "base"):
            continue  # it moves, and is not drawn yet
        colour = HOLLOW if solid.inside else STONE
        quaternion = Rotation.from_matrix(solid.axes).as_quat()
        for part, (kind, scale, offset) in enumerate(_parts(solid, scene, length)):
            place = solid.position + solid.axes @ offset
            shape = Shape(GROUP, PARTS * index + part, kind, scale, colour)
            found.append((shape, np.concatenate([place, quaternion])))
    return found


def _parts(solid: Solid, scene: Scene, length: float) -> Iterator[tuple[int, Scale, Floats]]:
    """Yield kind, size in m and place in its own axes of what a shape is drawn with."""
    r, half, _ = solid.size.tolist()
    if solid.kind == "plane":  # before the base
        at = solid.axes.T @ (scene.base.position - solid.position)
        thin = THIN * length
        yield CUBE, (4.0 * length, 4.0 * length, thin), np.array([at[0], at[1], -0.5 * thin])
    elif solid.kind in ("box", "ellipsoid"):
        a, b, c = (2.0 * solid.size).tolist()
        yield (CUBE if solid.kind == "box" else SPHERE), (a, b, c), np.zeros(3)
    elif solid.kind == "sphere":
        yield SPHERE, (2.0 * r, 2.0 * r, 2.0 * r), np.zeros(3)
    elif solid.kind in ("cylinder", "capsule"):
        yield CYLINDER, (2.0 * r, 2.0 * r, 2.0 * half), np.zeros(3)
        for end in (-half, half) if solid.kind == "capsule" else ():
            yield SPHERE, (2.0 * r, 2.0 * r, 2.0 * r), np.array([0.0, 0.0, end])
