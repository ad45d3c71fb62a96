"""Closed tubes around a line of frames, as triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.scene.taper import Floats

Ints = NDArray[np.int64]


def _products() -> Floats:
    """Return (16, 9): what the products of two parts of a quaternion add to a rotation matrix."""
    x, y, z, w = range(4)
    out = np.zeros((4, 4, 3, 3))
    for i, (j, k) in enumerate(((y, z), (z, x), (x, y))):
        out[j, j, i, i] = out[k, k, i, i] = -2.0
        out[j, k, j, k] = out[j, k, k, j] = 2.0  # symmetric part
        out[i, w, k, j], out[i, w, j, k] = 2.0, -2.0
    return out.reshape(16, 9)


_PRODUCTS = _products()


def rotations(quaternions: Floats) -> Floats:
    """Return the matrices (P, 3, 3) of unit quaternions (P, 4) x y z w."""
    products = quaternions[:, :, None] * quaternions[:, None, :]
    flat: Floats = products.reshape(-1, 16) @ _PRODUCTS
    flat[:, ::4] += 1.0
    return flat.reshape(-1, 3, 3)


def around(positions: Floats, turns: Floats, rings: Floats) -> Floats:
    """Return the corners (P, M, 3) of rings (P, M, 2), y and z in the planes of P frames."""
    corners: Floats = positions[:, None, :] + rings @ turns[:, :, 1:].transpose(0, 2, 1)
    return corners


def triangles(count: int, sides: int) -> Ints:
    """Return the triangles (T, 3) of a closed tube of ``count`` rings, as corners i·sides + j.

    Seen from outside they run counter-clockwise, for rings that go from y towards z and frames
    whose x axis points along the tube.
    """
    i, j = np.meshgrid(np.arange(count - 1), np.arange(sides), indexing="ij")
    here, there = i * sides + j, i * sides + (j + 1) % sides
    wall = np.stack([here, there, there + sides, here, there + sides, here + sides], axis=-1)
    fan = np.stack([np.zeros(sides - 2), np.arange(1, sides - 1), np.arange(2, sides)], axis=-1)
    last = fan + (count - 1) * sides
    parts = [wall.reshape(-1, 3), fan[:, ::-1], last]
    return np.concatenate(parts).astype(np.int64)
