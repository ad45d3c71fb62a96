"""Free joints that follow poses: those at the base, all of whose coordinates follow commands."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.scene import Joint, Scene


def posed_joints(scene: Scene) -> dict[str, Floats]:
    """Return the frame (4, 4) in the world that the coordinates of each such joint begin in."""
    base, found = scene.base, {}
    for body in scene.bodies:
        if not (isinstance(body, Joint) and body.name in scene.posed):
            continue
        frame = se3.pose_matrix(base.position, base.quaternion)
        attachment = scene.attachments.get(body.name)
        for offset in ([] if attachment is None else [attachment.offset]) + [body.offset]:
            frame = frame @ se3.pose_matrix(offset.position, offset.quaternion)
        found[body.name] = frame
    return found


def coordinates_of(frame: Floats, pose: Floats, near: Floats) -> Floats:
    """Return the coordinates (6,) of a free joint, rotation vector and position, of a pose (7,).

    frame : (4, 4) that they begin in; near : (3,) rotation vector: of those that turn alike, that
        which is next to it
    """
    relative = se3.inverse(frame) @ se3.pose_matrix(pose[:3], pose[3:])
    turn = se3.log(np.block([[relative[:3, :3], np.zeros((3, 1))], [np.zeros((1, 3)), np.eye(1)]]))
    turn = turn[:3]
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle > 1e-12 else near / max(float(np.linalg.norm(near)), 1e-300)
    turns = np.round((near @ axis - angle) / (2.0 * np.pi)) if np.isfinite(axis).all() else 0.0
    return np.concatenate([(angle + 2.0 * np.pi * turns) * axis, relative[:3, 3]])


def rates_of(coordinates: Floats, twist: Floats) -> Floats:
    """Return the rates (6,) of coordinates (6,) of a free joint from its own twist (6,)."""
    turn = np.concatenate([coordinates[:3], np.zeros(3)])
    tangent = se3.right_tangent(turn)[:3, :3]
    rotation = se3.exp(turn)[:3, :3]
    return np.concatenate([np.linalg.solve(tangent, twist[:3]), rotation @ twist[3:]])
