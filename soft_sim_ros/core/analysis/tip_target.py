"""A target for a frame: how far an equilibrium is from it, and how that follows the efforts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.arguments import real
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.closing import free_directions
from soft_sim_ros.core.mechanics.dynamics import Dynamics

from .statics import equilibrium

BARELY = 1e-9  # arm lengths that a slack tendon is pulled in to be taut


class Sensitivity(NamedTuple):
    """How an equilibrium follows the efforts."""

    q: Floats  # (n, A) dq/dτ
    tip: Floats  # (6, A) small rotation and displacement of the frame, world axes, per effort


def tip_sensitivity(
    dynamics: Dynamics,
    q: Floats,
    efforts: Floats,
    time: float = 0.0,
    *,
    tip: Floats | None = None,
    tip_follows: bool = False,
    frame: str | None = None,
) -> Sensitivity:
    """Return the exact derivative of an equilibrium with respect to the efforts.

    With constraints, the arm moves in the directions that they leave free.

    Parameters
    ----------
    q : (n,) the equilibrium under ``efforts`` (A,), the loads at ``time`` and the wrench ``tip``
    frame : name of a body, whose end is looked at; the tip, the last of all ends, by default

    Raises
    ------
    numpy.linalg.LinAlgError
        where the stiffness is singular, as at a limit point.
    """
    zero = np.zeros(dynamics.n)
    stiffness = dynamics.tangents(q, zero, zero, efforts, time, tip, tip_follows)[0]
    everything = np.ones(dynamics.n, dtype=bool)
    ways = free_directions(dynamics, everything, time, dynamics.model.weight)
    push = dynamics.effort_matrix(q, efforts)
    if ways is None:
        slope: Floats = np.asarray(np.linalg.solve(stiffness, push))
    else:
        slope = ways @ np.linalg.solve(ways.T @ stiffness @ ways, ways.T @ push)
    node = dynamics.compiled.node_of(frame)
    rotation = dynamics.node_poses(q)[node, :3, :3]
    twist = dynamics.jacobians(q, zero)[0][node] @ slope
    return Sensitivity(slope, np.vstack([rotation @ twist[:3], rotation @ twist[3:]]))


@dataclass(frozen=True, eq=False)
class Reach:
    """Efforts, and how the arm at rest then holds its tip, or the frame that was asked for.

    Parameters
    ----------
    efforts : (A,) in scene order, in the units of their commands
    q : (n,) the equilibrium
    pose : (4, 4) of it in the world
    distance : from the target position, m; 0 if none was asked for
    angle : from the target orientation, rad; likewise
    reached : whether both are within the tolerance
    """

    efforts: Floats
    q: Floats
    pose: Floats
    distance: float
    angle: float
    reached: bool


class Point(NamedTuple):
    """Efforts and what they lead to."""

    efforts: Floats
    q: Floats
    pose: Floats
    error: Floats  # (m,) target minus tip: arm lengths, rad

    @property
    def size(self) -> float:
        return float(np.linalg.norm(self.error))


@dataclass
class Task:
    """What is asked for, and under which loads."""

    dynamics: Dynamics
    position: Floats | None
    rotation: Floats | None
    bounds: Floats  # (2, A)
    weights: Floats
    tolerance: float
    frame: str | None = None
    loads: dict[str, Any] = field(default_factory=dict)

    def at(self, efforts: Floats, q: Floats | None, thorough: bool = False) -> Point:
        """Return the equilibrium near q; raises StaticsFailed if there is none."""
        q = equilibrium(
            self.dynamics, q, efforts=efforts, thorough=thorough, check=False, **self.loads
        )
        pose = self.dynamics.node_poses(q)[self.dynamics.compiled.node_of(self.frame)]
        parts = []
        if self.position is not None:
            parts.append((self.position - pose[:3, 3]) / self.dynamics.compiled.length)
        if self.rotation is not None:
            parts.append(Rotation.from_matrix(self.rotation @ pose[:3, :3].T).as_rotvec())
        return Point(efforts, q, pose, np.concatenate(parts))

    def sensitivities(self, point: Point) -> tuple[Floats, Floats]:
        """Return −d error/dτ (m, A), and how far (A,) unit efforts move the arm, arm lengths."""
        return self._slopes(point, point.efforts)

    def slack(self, point: Point) -> dict[int, float]:
        """Return the slack ones of the tendons of commanded length → where they are just taut."""
        length = np.flatnonzero(self.dynamics.model.length_control[:, 0])
        if not len(length):
            return {}
        taut = self.dynamics.ports(point.q, np.zeros(len(point.q)))[0]
        return {int(i): float(taut[i]) for i in length if point.efforts[i] <= taut[i]}

    def pulling(self, point: Point, i: int, taut: float) -> tuple[Floats, float]:
        """Return −d error/dτ (m,), and the reach, of slack tendon i when it is pulled in."""
        efforts = point.efforts.copy()
        efforts[i] = taut + BARELY * self.dynamics.compiled.length
        slopes, reach = self._slopes(point, efforts)
        return slopes[:, i], float(reach[i])

    def _slopes(self, point: Point, efforts: Floats) -> tuple[Floats, Floats]:
        twist = tip_sensitivity(self.dynamics, point.q, efforts, **self.loads, frame=self.frame)
        rows = []
        if self.position is not None:
            rows.append(twist.tip[3:] / self.dynamics.compiled.length)
        if self.rotation is not None:
            # error = log(R* Rᵀ): a turn δ of the tip changes it by −(right tangent)⁻¹ δ
            vector = np.concatenate([point.error[-3:], np.zeros(3)])
            turn = np.linalg.inv(se3.right_tangent(vector))[:3, :3]
            rows.append(turn @ twist.tip[:3])
        reach = np.abs(twist.q * self.dynamics.model.weight[:, None]).max(axis=0)
        # a slack tendon moves nothing: its step is bounded by the others', each effort measured by
        # what it costs, since newtons, pascals and metres do not compare
        least = 1e-9 * ((reach / self.weights).max() or 1.0) * self.weights
        return np.vstack(rows), np.maximum(reach, least)

    def result(self, point: Point) -> Reach:
        split = 3 if self.position is not None else 0
        place, turn = point.error[:split], point.error[split:]
        distance = float(np.linalg.norm(place)) * self.dynamics.compiled.length
        return Reach(
            efforts=point.efforts,
            q=point.q,
            pose=point.pose,
            distance=distance,
            angle=float(np.linalg.norm(turn)),
            reached=point.size <= self.tolerance,
        )


def make_task(
    dynamics: Dynamics,
    position: Floats | None,
    rotation: Floats | None,
    limits: Floats | None,
    weights: Floats | None,
    tolerance: float,
    frame: str | None,
) -> Task:
    """Return the task, checked."""
    dynamics.compiled.node_of(frame)
    actuators = dynamics.compiled.scene.actuators
    if position is None and rotation is None:
        raise ValueError("a position, a rotation or both are needed")
    if not actuators:
        raise ValueError(f"{dynamics.compiled.scene.name} has no actuators")
    if position is not None:
        position = real("position", position)
        if position.shape != (3,) or not np.isfinite(position).all():
            raise ValueError(f"position must be three finite numbers, not {position!r}")
    if rotation is not None:
        rotation = real("rotation", rotation)
        orthogonal = rotation.shape == (3, 3) and np.allclose(
            rotation @ rotation.T, np.eye(3), atol=1e-6
        )
        if not orthogonal or np.linalg.det(rotation) < 0.0:
            raise ValueError(f"rotation must be a rotation matrix (3, 3), not {rotation!r}")
    if limits is None:
        limits = np.array([actuator.limits for actuator in actuators]).T
    limits = real("limits", limits)
    if limits.shape != (2, len(actuators)) or not (limits[0] <= limits[1]).all():
        raise ValueError(f"limits must be (2, {len(actuators)}), low ≤ high, not {limits!r}")
    if weights is None:
        largest = np.abs(limits).max(axis=0)
        usable = np.isfinite(largest) & (largest > 0.0)
        weights = 1.0 / np.where(usable, largest, 1.0)
    weights = real("weights", weights)
    if weights.shape != (len(actuators),) or not (weights > 0.0).all():
        raise ValueError(f"weights must be {len(actuators)} numbers above zero, not {weights!r}")
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above zero, not {tolerance!r}")
    return Task(dynamics, position, rotation, limits, weights, tolerance, frame)
