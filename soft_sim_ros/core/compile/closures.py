"""Constraints of a scene as rows: functions of two frames that vanish."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Closures, new_live
from soft_sim_ros.core.model.packing import floats, ints
from soft_sim_ros.core.terms.closures import ALONG, DISTANCE, TURN
from soft_sim_ros.core.terms.driven import known_motions
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import Scene
from soft_sim_ros.scene.constraint import HOLDS, Constraint, Place

from .chain import Chain
from .drives import courses, flat_drives
from .start import given_coordinates, node_frames

Row = tuple[int, Floats]
UNIT = np.eye(3)
FOREVER = 1e300  # s


def flat_closures(scene: Scene, chain: Chain) -> Closures:
    """Return the constraints of a scene.

    Raises
    ------
    SceneError
        for a method that is not known to keep them
    """
    found, method = scene.constraints, scene.numerics.integrator
    if found and method == "generalized_alpha":
        expected = "another integrator: nobody has checked this one with constraints"
        raise SceneError(scene.file, "numerics.integrator", method, expected)
    nodes = [[_node(chain, place) for place in one.frames] for one in found]
    sites = sorted({node for pair in nodes for node in pair if node > 0})
    ends = {block.first_segment: i for i, block in enumerate(chain.blocks)}
    ends[chain.node] = len(chain.blocks)
    base = se3.pose_matrix(scene.base.position, scene.base.quaternion)
    poses = _begin(scene, chain) if found else np.zeros((0, 4, 4))
    rows: list[Row] = []
    ptr, offsets, targets = [0], [], []
    for one, (first, second) in zip(found, nodes, strict=True):
        offset = _pose(one.frames[0], None)
        here = poses[first] @ offset
        if one.frames[1].offset is None:
            target = se3.inverse(poses[second]) @ here
        else:
            target = _pose(one.frames[1], base)
        offsets.append(_flat(offset))
        targets.append(_flat(target))
        apart = float(np.linalg.norm((poses[second] @ target - here)[:3, 3]))
        rows += _rows(scene, one, apart)
        ptr.append(len(rows))
    return Closures(
        ptr=ints(ptr),
        node=ints(nodes).reshape(-1, 2),
        place=ints([[_index(sites, node) for node in pair] for pair in nodes]).reshape(-1, 2),
        site=ints([[node, ends[node] - 1] for node in sites]).reshape(-1, 2),
        offset=floats(offsets).reshape(-1, 12),
        target=floats(targets).reshape(-1, 12),
        catches=ints([one.frames[1].offset is None for one in found]),
        rule=ints([rule for rule, _ in rows]),
        vector=floats([vector for _, vector in rows]).reshape(-1, 4, 3),
        schedule=np.clip(
            floats([(one.start, one.end) for one in found]).reshape(-1, 2), -FOREVER, FOREVER
        ),
        length=floats([chain.whole[0] or 1.0] if found else []),
    )


def _node(chain: Chain, place: Place) -> int:
    if place.body is None:
        return 0
    rod_map = chain.rods.get(place.body)
    if rod_map is None or place.s is None:
        return chain.ends[place.body]
    return chain.node_at(rod_map, place.s)


def _index(sites: list[int], node: int) -> int:
    return sites.index(node) if node > 0 else -1


def _pose(place: Place, base: Floats | None) -> Floats:
    """Return a frame (4, 4) in that of its node; of the world, in the base frame."""
    assert place.offset is not None
    pose = se3.pose_matrix(place.offset.position, place.offset.quaternion)
    return se3.inverse(base) @ pose if place.body is None and base is not None else pose


def _flat(pose: Floats) -> Floats:
    return np.concatenate([pose[:3, :3].ravel(), pose[:3, 3]])


def _begin(scene: Scene, chain: Chain) -> Floats:
    """Return the poses (nodes, 4, 4) of all nodes when the scene begins."""
    q = given_coordinates(chain, scene.initial)[0]
    if courses(scene):
        drives = flat_drives(scene, chain)
        told = np.zeros((len(drives.column), 4))
        known_motions(drives, new_live(0, len(told)).course, 0.0, told)
        q[drives.column] = told[:, 0]
    return node_frames(chain, q)


def _rows(scene: Scene, one: Constraint, apart: float) -> list[Row]:
    place, turn = HOLDS[one.kind]
    n, across = _axes(one)
    rows: list[Row] = []
    if place == "distance":
        length = apart if math.isnan(one.length) else one.length
        if not length > 0.0:
            key = f"constraints.{one.name}.length"
            raise SceneError(
                scene.file, key, "here", "frames that are apart, they are at one place"
            )
        rows.append((DISTANCE, _vector([length, 0.0, 0.0])))
    axes = {"all": list(UNIT), "across": across, "along": [n]}.get(place, [])
    rows += [(ALONG, _vector(axis)) for axis in axes]
    if turn == "all":
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            pair = 0.5 * UNIT[k], UNIT[j], 0.5 * UNIT[j], UNIT[k]
            rows.append((TURN, _vector(*pair)))
    elif turn == "axis":
        rows += [(TURN, _vector(-across[1], n)), (TURN, _vector(across[0], n))]
    return rows


def _vector(*parts: Any) -> Floats:
    out = np.zeros((4, 3))
    for i, part in enumerate(parts):
        out[i] = part
    return out


def _axes(one: Constraint) -> tuple[Floats, list[Floats]]:
    """Return the axis of a constraint, and two across it: a right-handed triple (across, axis)."""
    n = one.axis
    if not n.any():
        return n, []
    first = np.cross(n, UNIT[int(np.argmin(np.abs(n)))])
    first /= np.linalg.norm(first)
    return n, [first, np.cross(n, first)]
