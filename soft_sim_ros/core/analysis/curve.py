"""The curve r(q, λ) = 0 of equilibria in scaled unknowns, and Newton's method back to it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.arguments import real
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.integrators.newton import CONVERGED, REASONS, admissible
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.history import refuse_constraints, refuse_driven
from soft_sim_ros.core.model.model import Data
from soft_sim_ros.errors import BadArgument

from .load_path import LoadPath
from .small_motion import unit_scale

SHIFT = 1e-3  # of the range of λ, in difference quotients
ITERATIONS = 12
LOADS = "two finite loads, low < high"


class State(NamedTuple):
    """A point on a branch, scaled."""

    u: Floats  # (n + 1,)
    tangent: Floats  # (n + 1,) of unit length
    stiffness: Floats  # (n, n)
    slope: Floats  # (n,) ∂r/∂λ
    iterations: int


class Curve:
    """The curve r(u) = 0 in scaled unknowns."""

    def __init__(self, dynamics: Dynamics, path: LoadPath, within: tuple[float, float]) -> None:
        ends = real("within", within, LOADS)
        if ends.shape != (2,) or not (np.isfinite(ends).all() and ends[0] < ends[1]):
            raise BadArgument("within", within, LOADS)
        refuse_driven(dynamics.compiled.scene, "a branch of equilibria")
        refuse_constraints(dynamics.compiled.scene, "a branch of equilibria")
        low, high = ends
        self.dynamics, self.path, self.within = dynamics, path, (float(low), float(high))
        self.range = self.within[1] - self.within[0]
        self.scale = np.append(1.0 / dynamics.model.weight, self.range)
        self.zero = np.zeros(dynamics.n)
        self.why = ""

    def unit(self, stiffness: Floats) -> Floats:
        """Return the scale (n,) in which a scaled stiffness is 1 where the arm is only elastic."""
        weight = self.dynamics.model.weight
        law = self.dynamics.law_at_rest / weight**2
        return unit_scale(stiffness, law, np.ones_like(weight))

    def split(self, u: Floats) -> tuple[Floats, float]:
        whole = u * self.scale
        return whole[:-1], float(whole[-1])

    def residual(self, u: Floats) -> Floats:
        q, load = self.split(u)
        data = self.path(load)
        return self.dynamics.residual(q, self.zero, self.zero, data) * self.scale[:-1]

    def matrices(self, u: Floats) -> tuple[Floats, Floats, Floats]:
        """Return r, ∂r/∂(w q), ∂r/∂(λ/range) in scaled rows; exact for loads linear in λ."""
        shift = np.zeros(len(u))
        shift[-1] = SHIFT
        slope = (self.residual(u + shift) - self.residual(u - shift)) / (2.0 * SHIFT)
        residual = self.residual(u)
        stiffness = self.dynamics.last_tangent((1.0, 0.0, 0.0))
        return residual, stiffness * np.outer(self.scale[:-1], self.scale[:-1]), slope

    def correct(self, guess: Floats, tangent: Floats, tolerance: float) -> State | None:
        """Return the point in the plane through ``guess`` across ``tangent``, or None."""
        u = guess.copy()
        before = np.inf
        for iteration in range(ITERATIONS):
            residual, stiffness, slope = self.matrices(u)
            matrix = np.vstack([np.column_stack([stiffness, slope]), tangent])
            if not (np.isfinite(matrix).all() and np.isfinite(residual).all()):
                self.why = "it is not finite"
                return None
            # least squares: a direction that costs no energy at all is left alone
            wrong = np.append(residual, tangent @ (u - guess))
            rows = _sizes(matrix)
            step = np.linalg.lstsq(matrix / rows[:, None], wrong / rows, rcond=1e-13)[0]
            u -= step
            size = float(np.abs(step).max())
            if size <= tolerance:
                return self._accept(u, tangent, iteration + 1)
            if not size < 2.0 * before:
                break
            before = size
        self.why = "Newton's method does not converge"
        return None

    def _accept(self, u: Floats, tangent: Floats, iterations: int) -> State | None:
        _, stiffness, slope = self.matrices(u)
        status = admissible(self.dynamics.model, self.path_data(u))
        if status != CONVERGED:
            self.why = REASONS[status]
            return None
        matrix = np.vstack([np.column_stack([stiffness, slope]), tangent])
        if not np.isfinite(matrix).all():
            self.why = "it is not finite"
            return None
        rows = _sizes(matrix)
        ahead = np.zeros(len(u))
        ahead[-1] = 1.0 / rows[-1]
        new = np.linalg.lstsq(matrix / rows[:, None], ahead, rcond=1e-13)[0]
        new /= np.linalg.norm(new)
        tangent_there: Floats = np.asarray(new, dtype=np.float64)
        return State(u, tangent_there, stiffness, slope, iterations)

    def path_data(self, u: Floats) -> Data:
        """Return the scratch of a sweep at u."""
        q, load = self.split(u)
        data = self.path(load)
        self.dynamics.residual(q, self.zero, self.zero, data)
        return data


def _sizes(matrix: Floats) -> Floats:
    """Return the largest size in every row; 1 for a row of zeros: nothing holds that coordinate."""
    sizes = np.abs(matrix).max(axis=1)
    return np.asarray(np.where(sizes > 0.0, sizes, 1.0))
