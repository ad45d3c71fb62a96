"""Constraints in statics: gaps that close along a load path, and directions that are left free."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.terms.closures import TARGET, TURN
from soft_sim_ros.errors import NotMet

from .closures import directions
from .dynamics import Dynamics

MET = 1e-9  # of the length, or rad: what rows that others imply may be off


class Closing:
    """The constraints that act at a time, with gaps that close as a load path goes on.

    The frames that are held are turned, and rows are given an offset, so that at the start of the
    path all are met where the arm is; both vanish in equal steps.

    Parameters
    ----------
    dynamics : the arm
    q : (n,) where the path starts
    time : s
    """

    def __init__(self, dynamics: Dynamics, q: Floats, time: float) -> None:
        self.dynamics, self.constraints = dynamics, dynamics.constraints
        self.acting: NDArray[np.bool_] = self.constraints.acting(time)
        self.multipliers = np.zeros(self.constraints.rows)
        self._held = dynamics.scratch.closed.held[:, TARGET:].copy()  # where ``hold`` has put them
        self._turns = [np.zeros(3) for _ in self.constraints.names]
        self._gap = np.zeros(self.constraints.rows)
        zero = np.zeros(dynamics.n)
        dynamics.residual(q, zero, zero, dynamics.forcing(time=time))
        closures = dynamics.model.closures
        for k in range(len(self.constraints)):
            rows = self.constraints.rows_of(k)
            if not self.acting[rows].any():
                continue
            turned = closures.rule[rows] == TURN
            if turned.any():
                one, two = self.constraints.frames(k)
                between = np.eye(4)
                between[:3, :3] = two[:3, :3].T @ one[:3, :3]
                if np.count_nonzero(turned) == 2:
                    between = _shortest(closures.vector[rows][turned][0, 1], between)
                self._turns[k] = se3.log(between)[:3]
        self.at(0.0)
        dynamics.residual(q, zero, zero, dynamics.forcing(time=time))
        self._gap = np.where(self.acting, self.constraints.value, 0.0)

    def at(self, share: float) -> None:
        """Set the frames that are held to a share of the path."""
        target = self.dynamics.scratch.closed.held[:, TARGET:]
        for k, turn in enumerate(self._turns):
            own = self._held[k]
            target[k] = own
            if share < 1.0 and turn.any():
                left = se3.exp(np.concatenate([(1.0 - share) * turn, np.zeros(3)]))[:3, :3]
                target[k, :9] = (own[:9].reshape(3, 3) @ left).ravel()

    def rows(self, share: float) -> Floats:
        """Return how far the rows that act are from where they are to be, over the length."""
        off = (self.constraints.value - (1.0 - share) * self._gap) / self.constraints.unit
        return np.asarray(off[self.acting])

    def push(self) -> None:
        """Let the multipliers act in the next residual, after ``forcing``."""
        self.dynamics.scratch.closed.multiplier[:] = self.multipliers

    def jacobian(self, mask: NDArray[np.bool_]) -> Floats:
        """Return the rows that act (R', n') in scaled coordinates, over the length."""
        weight = self.dynamics.model.weight[mask]
        own = self.constraints.jacobian()[self.acting][:, mask] / weight
        return np.asarray(own / self.constraints.unit[self.acting, None])

    def step(
        self, stiffness: Floats, residual: Floats, mask: NDArray[np.bool_], share: float
    ) -> tuple[Floats, float]:
        """Return the correction (n',) of coordinates in ``mask``, to be subtracted.

        Also how far rows that others imply are off; the multipliers are corrected. What is held and
        what is free are found apart, so multipliers are the least that do, whatever is redundant.
        """
        weight = self.dynamics.model.weight[mask]
        parts = directions(self.jacobian(mask))
        off = self.rows(share)
        way = parts.held @ ((parts.left.T @ off) / parts.size)
        implied = off - parts.left @ (parts.left.T @ off)
        stiffness, residual = stiffness / np.outer(weight, weight), residual / weight
        inner = parts.free.T @ stiffness @ parts.free
        along = np.linalg.solve(inner, parts.free.T @ (residual - stiffness @ way))
        moved = way + parts.free @ along
        left = parts.held.T @ (residual - stiffness @ moved)
        self.multipliers[self.acting] += (parts.left @ (left / parts.size)) / self.constraints.unit[
            self.acting
        ]
        return moved / weight, float(np.abs(implied).max(initial=0.0))

    def contradicted(self) -> NotMet:
        """Return the error for rows that cannot all be met."""
        return self.constraints.contradicted(self.acting)


def _shortest(axis: Floats, between: Floats) -> Floats:
    """Return the shortest turn (4, 4) that takes an axis to where ``between`` takes it."""
    goal = between[:3, :3] @ axis
    normal, cosine = np.cross(axis, goal), float(axis @ goal)
    sine = float(np.linalg.norm(normal))
    if sine == 0.0:
        normal = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        normal /= np.linalg.norm(normal)
    else:
        normal = normal / sine
    return se3.exp(np.concatenate([np.arctan2(sine, cosine) * normal, np.zeros(3)]))


def free_directions(
    dynamics: Dynamics, mask: NDArray[np.bool_], time: float, scale: Floats
) -> Floats | None:
    """Return a basis (n', m) of the motions that constraints leave to coordinates in ``mask``.

    At the last residual; None where nothing is constrained. In coordinates times ``scale`` (n',)
    it is orthonormal.
    """
    constraints = dynamics.constraints
    acting = constraints.acting(time) if len(constraints) else np.zeros(0, dtype=bool)
    if not acting.any():
        return None
    rows = constraints.jacobian()[acting][:, mask] / constraints.unit[acting, None]
    # which rows are implied is told in displacements, as everywhere
    weight = dynamics.model.weight[mask]
    held = directions(rows / weight).held * weight[:, None]
    across = np.linalg.qr(held / scale[:, None], mode="complete")[0][:, held.shape[1] :]
    return np.asarray(across / scale[:, None])
