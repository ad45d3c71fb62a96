"""Constraints at the state of the last residual: gaps, rows, wrenches, directions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Data
from soft_sim_ros.core.recursion.elimination import System, new_system
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.terms.closures import MODE, TURN, bends, in_force_now, lever
from soft_sim_ros.errors import NoSuchPlace, NotMet

from .redundancy import DEPENDENT, Redundancy, redundancies

MOTION = 18  # rows of what a block hands to its end: J x, and its first and second rate
GAP = 1e-3  # of the length, or rad: so far a state may be off and is still put right


class Reaction(NamedTuple):
    """What a constraint does to its first frame; to its second the opposite, at the same place.

    Attributes
    ----------
    force, moment : (3,) along world axes in N and, about the origin of the first frame, N·m
    place : (3,) that origin in the world, m
    multipliers : of its rows, in their order: N along an axis, N·m about one
    """

    force: Floats
    moment: Floats
    place: Floats
    multipliers: Floats


class Directions(NamedTuple):
    """What rows leave free, in scaled coordinates q̂ = w q and rows over the length.

    G = left · diag(size) · heldᵀ, and G free = 0.
    """

    left: Floats  # (R, r)
    size: Floats  # (r,)
    held: Floats  # (n, r)
    free: Floats  # (n, n − r)


def directions(rows: Floats) -> Directions:
    """Return what rows (R, n) hold and leave free; those that others imply make no difference."""
    count = len(rows)
    left, size, right = np.linalg.svd(rows, full_matrices=True)
    rank = int(np.count_nonzero(size > DEPENDENT * size.max(initial=0.0))) if count else 0
    return Directions(left[:, :rank], size[:rank], right[:rank].T, right[rank:].T)


class Constraints:
    """The constraints of a scene, of which the state of the last residual is read off.

    Parameters
    ----------
    compiled : Compiled
    data : scratch of the equations that they belong to
    """

    def __init__(self, compiled: Compiled, data: Data) -> None:
        self._compiled, self._model, self._data = compiled, compiled.model, data
        self._system: System | None = None
        self.names = tuple(one.name for one in compiled.scene.constraints)
        closures = self._model.closures
        self.rows = len(closures.rule)
        # what makes rows pure numbers: those in m over the length
        length = closures.length[0] if self.rows else 1.0
        self.unit = np.where(closures.rule == TURN, 1.0, length)

    def __len__(self) -> int:
        return len(self.names)

    def index(self, name: str) -> int:
        """Return which constraint has a name.

        Raises
        ------
        NoSuchPlace
            if none has
        """
        if name not in self.names:
            known = ", ".join(self.names) or "(none)"
            raise NoSuchPlace(name, f"one of the constraints {known}")
        return self.names.index(name)

    def rows_of(self, k: int) -> slice:
        """Return the rows of constraint k."""
        return slice(*self._model.closures.ptr[k : k + 2].tolist())

    def acting(self, time: float) -> NDArray[np.bool_]:
        """Return which rows (R,) act at a time in s."""
        on = np.zeros(len(self), dtype=bool)
        for k in range(len(self)):
            on[k] = in_force_now(self._model.closures, self._data.closed.held, k, time)
        return np.repeat(on, np.diff(self._model.closures.ptr))

    @property
    def value(self) -> Floats:
        """How far each row (R,) is from being met, m or rad."""
        return self._data.closed.value.copy()

    def jacobian(self) -> Floats:
        """Return ∂f/∂q (R, n) of the rows."""
        sites, arms = self._sites(), np.zeros((6 * len(self._model.closures.site), self.rows))
        lever(self._model.closures, self._data, arms)
        return np.asarray(arms.T @ sites)

    def curvature(self) -> Floats:
        """Return −∂(Gᵀλ)/∂q (n, n), but for what the chain's own derivative has of it."""
        sites = self._sites()
        matrix = np.zeros((len(sites), len(sites)))
        bends(self._model.closures, self._data, matrix)
        return np.asarray(sites.T @ matrix @ sites)

    def _sites(self) -> Floats:
        """Return the spatial Jacobians (6F, n) of the nodes that constraints push.

        They are what the tangent hands from block to block, so the cost is linear in the blocks.
        """
        model, data, columns = self._model, self._data, self._model.block_col
        if self._system is None:
            self._system = new_system(model)
        system = self._system
        tangent(model, data, (1.0, 0.0, 0.0), system)
        parents = model.tree.block
        out = np.zeros((len(model.closures.site), 6, int(columns[-1])))
        for own, block in zip(out, model.closures.site[:, 1].tolist(), strict=True):
            while block >= 0:
                begin, end = columns[block], columns[block + 1]
                first, last = system.column[block], system.column[block + 1]
                motion = system.motion[MOTION * first : MOTION * last].reshape(MOTION, -1)
                own[:, begin:end] = motion[:6, : end - begin]
                block = int(parents[block]) if len(parents) else block - 1
        return out.reshape(-1, int(columns[-1]))

    def frames(self, k: int) -> tuple[Floats, Floats]:
        """Return both frames (4, 4) of constraint k in the base frame."""
        found = []
        for row in self._data.closed.frame[k]:
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = row[:9].reshape(3, 3), row[9:]
            found.append(pose)
        return found[0], found[1]

    def reaction(self, name: str, multipliers: Floats) -> Reaction:
        """Return what a constraint does with multipliers (R,)."""
        k = self.index(name)
        rows, closed = self.rows_of(k), self._data.closed
        wrench = multipliers[rows] @ closed.wrench[rows]
        place = closed.frame[k, 0, 9:]
        turn, origin = self._compiled.base[:3, :3], self._compiled.base[:3, 3]
        moment = wrench[:3] - np.cross(place, wrench[3:])
        return Reaction(turn @ wrench[3:], turn @ moment, origin + turn @ place, multipliers[rows])

    def here(self, k: int) -> Floats:
        """Return the second frame (12,) of constraint k in its node's if it were at the first."""
        node = self._model.closures.node[k, 1]
        turn = self._data.rotation[node].reshape(3, 3)
        pose = self.frames(k)[0]
        spot = turn.T @ (pose[:3, 3] - self._data.position[node])
        return np.concatenate([(turn.T @ pose[:3, :3]).ravel(), spot])

    def apart(self, k: int) -> tuple[float, float]:
        """Return how far the frames of constraint k are apart along what it holds, in m and rad."""
        closures, rows = self._model.closures, self.rows_of(k)
        turn = closures.rule[rows] == TURN
        value = self._data.closed.value[rows]
        distance = float(np.linalg.norm(value[~turn]))
        one, two = self.frames(k)
        between = two[:3, :3].T @ one[:3, :3]
        if np.count_nonzero(turn) == 3:
            pose = np.eye(4)
            pose[:3, :3] = between
            return distance, float(np.linalg.norm(se3.log(pose)[:3]))
        if turn.any():  # a hinge: the angle between its axes
            axis = closures.vector[rows][turn][0, 1]
            cross = np.cross(axis, between @ axis)
            return distance, float(np.arctan2(np.linalg.norm(cross), axis @ between @ axis))
        return distance, 0.0

    def worst(self, acting: NDArray[np.bool_]) -> tuple[str, float, float]:
        """Return the constraint that is furthest from being met, and by how many m and rad."""
        found = [
            (*self.apart(k), name)
            for k, name in enumerate(self.names)
            if acting[self.rows_of(k)].any()
        ]
        length = float(self._model.closures.length[0])
        distance, angle, name = max(found, key=lambda item: item[0] / length + item[1])
        return name, distance, angle

    def refuse_gap(self, acting: NDArray[np.bool_], limit: float = GAP) -> None:
        """Refuse a state further off than what is put right, over the length or in rad.

        Raises
        ------
        NotMet
            which names the constraint that is worst, and how far off it is
        """
        name, distance, angle = self.worst(acting)
        if not (distance <= limit * self._model.closures.length[0] and angle <= limit):
            why = "initial.state: equilibrium closes such gaps, or give it where its frames are"
            raise NotMet(name, distance, angle, why)

    def redundant(self, acting: NDArray[np.bool_]) -> dict[str, Redundancy]:
        """Return which constraints say what others before them say, at the last residual."""
        rows = self.jacobian() / self._model.weight / self.unit[:, None]
        parts = [(name, rows[self.rows_of(k)]) for k, name in enumerate(self.names)]
        chosen = [
            (name, part) for k, (name, part) in enumerate(parts) if acting[self.rows_of(k)].any()
        ]
        return redundancies([name for name, _ in chosen], [part for _, part in chosen])

    def contradicted(self, acting: NDArray[np.bool_]) -> NotMet:
        """Return the error for rows that cannot all be met: the worst, and what it contradicts."""
        name, distance, angle = self.worst(acting)
        others = dict.fromkeys(
            one
            for late, found in self.redundant(acting).items()
            for one in (late, *found.beside)
            if name in (late, *found.beside) and one != name
        )
        by = ", ".join(others)
        why = f"it contradicts {by}" if by else "it asks for more than joints and rods can do"
        return NotMet(name, distance, angle, why)

    def states(self) -> dict[str, float]:
        """Return of each constraint whether it is released, held or goes by its schedule."""
        return dict(zip(self.names, self._data.closed.held[:, MODE].tolist(), strict=True))
