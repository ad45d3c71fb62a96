"""Newton and Euler by hand: what joints must bear when rigid bodies move in a given way.

Poses come from scipy rotations and the joints' coordinates as polynomials in time, accelerations
from differentiating these poses numerically: no twists, no adjoints, no recursion for velocities.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

# eighth-order central differences on nine instants, with the instants this far apart in s
STEP = 0.004
FIRST = np.array([3, -32, 168, -672, 0, 672, -168, 32, -3]) / 840.0
SECOND = np.array([-9, 128, -1008, 8064, -14350, 8064, -1008, 128, -9]) / 5040.0


def pose(entry):
    """Return rotation matrix and position of a pose entry."""
    turn = Rotation.from_euler("xyz", entry.get("rpy", [0, 0, 0])).as_matrix()
    return turn, np.array(entry.get("position", [0.0, 0.0, 0.0]))


def joint_motion(entry, q):
    """Return rotation and shift that a joint makes with its coordinates q."""
    unit = [
        np.array(a) / np.linalg.norm(a) for a in entry.get("axes", [entry.get("axis", [1, 0, 0])])
    ]
    kind = entry["kind"]
    if kind == "prismatic":
        return np.eye(3), q[0] * unit[0]
    if kind in ("revolute", "universal"):
        turn = Rotation.identity()
        for axis, angle in zip(unit, q, strict=True):
            turn = turn * Rotation.from_rotvec(angle * axis)
        return turn.as_matrix(), np.zeros(3)
    shift = q[3:] if kind == "free" else np.zeros(3)
    return Rotation.from_rotvec(q[:3]).as_matrix(), shift


COUNT = {"fixed": 0, "revolute": 1, "prismatic": 1, "universal": 2, "spherical": 3, "free": 6}


def frames(document, q):
    """Return world rotations and positions after every joint, and centres of mass of all bodies."""
    turn, origin = pose(document.get("base", {}))
    joints, bodies, at = {}, [], 0
    for entry in document["bodies"]:
        if "joint" in entry:
            offset, shift = pose(entry.get("offset", {}))
            origin, turn = origin + turn @ shift, turn @ offset
            count = COUNT[entry["kind"]]
            if count:
                rotation, shift = joint_motion(entry, q[at : at + count])
                origin, turn = origin + turn @ shift, turn @ rotation
            at += count
            joints[entry["joint"]] = (turn, origin)
        else:
            own, com = pose(entry.get("com", {}))
            bodies.append((turn @ own, origin + turn @ com))
    return joints, bodies


def reactions(document, q, v, a):
    """Return {joint: wrench (6,) on the part after it, in the frame after it}, moment first.

    Of rigid bodies under weight, moving with q, v, a.
    """
    times = STEP * np.arange(-4, 5)
    past = [frames(document, q + v * t + 0.5 * a * t * t) for t in times]
    joints, _ = past[4]
    masses = [entry for entry in document["bodies"] if "rigid_body" in entry]
    gravity = np.array(document["gravity"], dtype=float)
    out: dict[str, np.ndarray] = {}
    for index, entry in enumerate(document["bodies"]):
        if "joint" not in entry:
            continue
        after = [e["rigid_body"] for e in document["bodies"][index:] if "rigid_body" in e]
        turn, origin = joints[entry["joint"]]
        force, moment = np.zeros(3), np.zeros(3)
        for i, body in enumerate(masses):
            if body["rigid_body"] not in after:
                continue
            turns = np.array([f[1][i][0] for f in past])
            centres = np.array([f[1][i][1] for f in past])
            inertia = np.diag(body["inertia"])
            # angular momentum R J ω with ω from Rᵀ Ṙ at every instant would need more instants:
            # it is the sum over J's principal axes of m_k e_k × ė_k with m_k = (tr J)/2 − J_k
            second = 0.5 * np.trace(inertia) - np.diag(inertia)
            curved = np.tensordot(SECOND, turns, 1) / STEP**2
            rate = sum(second[k] * np.cross(turns[4][:, k], curved[:, k]) for k in range(3))
            push = body["mass"] * (SECOND @ centres / STEP**2 - gravity)
            force += push
            moment += rate + np.cross(centres[4] - origin, push)
        out[entry["joint"]] = np.concatenate([turn.T @ moment, turn.T @ force])
    return out


def rate_of(function: Callable[[float], np.ndarray]) -> np.ndarray:
    """Return the derivative of a function of time at 0."""
    return np.tensordot(FIRST, np.array([function(t) for t in STEP * np.arange(-4, 5)]), 1) / STEP
