"""The equations of motion of a scene as functions of state, efforts and time, by recursion.

r(q, q̇, q̈) = M q̈ + C q̇ + g + k + R q̇ − loads − actuators, its exact derivatives, and its solution
for q̈. ``dynamics.py`` takes it apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from soft_sim_ros.core.arguments import number, vector
from soft_sim_ros.core.backend.copying import take_rest
from soft_sim_ros.core.backend.jit import Call
from soft_sim_ros.core.compile.scene import Compiled, compile_scene
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Data, Live, new_data, new_live
from soft_sim_ros.core.recursion.closing import close_factor, close_solve, closed_dynamics, meet
from soft_sim_ros.core.recursion.elimination import dense, factor, new_system, solve
from soft_sim_ros.core.recursion.rnea import inverse_dynamics
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.terms.driven import hold_still, known_motions
from soft_sim_ros.core.terms.forcing import apply_loads
from soft_sim_ros.errors import BadArgument
from soft_sim_ros.scene import Scene

from .closures import Constraints, Reaction
from .redundancy import Redundancy


class Equations:
    """A compiled scene as a function of state, efforts and time.

    Parameters
    ----------
    scene : Scene or Compiled

    Attributes
    ----------
    free : (n,) whether a coordinate is free to move; the others are driven
    attached : (P,) whether the payloads of the scene are there
    constraints : what holds frames at frames

    Notes
    -----
    ``efforts`` (A,) in scene order default to zero. Loads are those of the scene at ``time`` in s,
    times ``share``.
    Gravity is multiplied by ``share`` too: a static load path scales one number.
    """

    def __init__(self, scene: Scene | Compiled) -> None:
        self.compiled = scene if isinstance(scene, Compiled) else compile_scene(scene)
        self.model = self.compiled.model
        self.attached: tuple[bool, ...] = tuple(
            bool(body.attached) for body in self.compiled.scene.payloads
        )
        if self.attached:  # masses that change are one's own
            self.model = self.model._replace(inertia=self.model.inertia.copy())
        self.n = len(self.compiled.coordinate_names)
        self.actuators = len(self.model.port_ptr) - 1
        self._data = new_data(self.model, len(self.compiled.loads.push))
        self._system = new_system(self.model)
        self._zero = np.zeros(self.n)
        self._no_tip = np.zeros(6)
        self._commanded = False
        self._at_rest = new_live(len(self.compiled.loads.push), len(self.model.driven))
        self.free = np.ones(self.n, dtype=bool)
        self.free[self.model.driven[:, 0]] = False
        self.constraints = Constraints(self.compiled, self._data)

    @property
    def scratch(self) -> Data:
        """What the last residual left."""
        return self._data

    # Copies have their own scratch; the compiled scene is immutable and shared.

    def __copy__(self) -> Equations:
        return self._twin(None)

    def __deepcopy__(self, memo: dict[int, Any]) -> Equations:
        return self._twin(memo)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.compiled,)

    def _twin(self, memo: dict[int, Any] | None) -> Equations:
        new = type(self)(self.compiled)
        new.carry(self.attached)
        new._data.closed.held[:] = self._data.closed.held
        if memo is not None:
            memo[id(self)] = new
        take_rest(new, self, memo)
        return new

    def forcing(
        self,
        efforts: Floats | None = None,
        time: float = 0.0,
        share: float = 1.0,
        tip: Floats | None = None,
        tip_follows: bool = False,
        live: Live | None = None,
    ) -> Data:
        """Return scratch with gravity, loads, efforts and a tip wrench (6,) set.

        The wrench is along world axes, or (``tip_follows``) along those of the tip.

        live : what is commanded besides; None: nothing is
        """
        time, share = number("time", time), number("share", share)
        tip = self._no_tip if tip is None else vector("tip", tip, 6)
        if not tip_follows:
            tip = self.to_base(tip)
        data = self._data
        if len(self.constraints):
            data.closed.multiplier[:] = 0.0
        data.gravity[:] = share * self.compiled.gravity
        data.effort[:] = 0.0
        if efforts is not None:
            data.effort[:] = share * vector("efforts", efforts, self.actuators)
        self._command(live)
        apply_loads(
            self.compiled.loads,
            tip,
            bool(tip_follows),
            time,
            share,
            data,
        )
        return data

    def carry(self, attached: Sequence[bool]) -> None:
        """Let just these (P,) payloads be there from now on."""
        if len(attached) != len(self.attached):
            raise BadArgument("attached", attached, f"{len(self.attached)} truth values")
        if self.attached != tuple(attached):
            self.model.inertia[:] = self.compiled.chain.inertia_with(attached)
            self.attached = tuple(attached)

    def calls(self) -> list[Call]:
        """Return the kernels that a mass matrix needs, with arguments, to be compiled ahead."""
        state, alpha = (self._zero, self._zero, self._zero, self._zero), (1.0, 1.0, 1.0)
        matrix = np.zeros((self.n, self.n))
        residual = closed_dynamics if len(self.constraints) else inverse_dynamics
        return [
            (residual, self.model, self._data, *state),
            (tangent, self.model, self._data, alpha, self._system),
            (dense, self.model, self._system, matrix),
        ]

    def residual(self, q: Floats, v: Floats, a: Floats, data: Data) -> Floats:
        """Return M a + C v + g + k + R v − loads − actuators (n,).

        Constraints push with the multipliers in ``data.closed``; ``forcing`` sets them to zero.
        """
        q, v, a = self.coordinates(q), self.coordinates(v, "v"), self.coordinates(a, "a")
        if data is not self._data:
            raise BadArgument("data", type(data), "what ``forcing`` of the same object returned")
        out = np.zeros(self.n)
        if len(self.constraints):
            closed_dynamics(self.model, data, q, v, a, out)
        else:
            inverse_dynamics(self.model, data, q, v, a, out)
        return out

    def inverse_dynamics(
        self, q: Floats, v: Floats, a: Floats, efforts: Floats | None = None, time: float = 0.0
    ) -> Floats:
        """Return the generalised force (n,) that the motion needs besides loads and efforts.

        What constraints give is part of it.
        """
        return self.residual(q, v, a, self.forcing(efforts, time))

    def forward_dynamics(
        self,
        q: Floats,
        v: Floats,
        efforts: Floats | None = None,
        time: float = 0.0,
        tip: Floats | None = None,
        tip_follows: bool = False,
        live: Live | None = None,
    ) -> Floats:
        """Return q̈ (n,), by elimination from tips to base: the cost is linear in the blocks.

        Driven coordinates accelerate as they are told at ``time``, and constraints are heeded.
        Other arguments: ``forcing``.

        Raises
        ------
        numpy.linalg.LinAlgError
            if a coordinate moves no mass
        """
        data = self.forcing(efforts, time, 1.0, tip, tip_follows, live)
        return self.accelerations(q, v, data, time)

    def accelerations(
        self, q: Floats, v: Floats, data: Data, time: float, besides: Floats | None = None
    ) -> Floats:
        """Return q̈ (n,); multipliers of constraints are left in ``data.closed``.

        besides : (n,) forces that resist, more than those of a state at rest
        """
        time, told = number("time", time), np.zeros(self.n)
        told[self.model.driven[:, 0]] = data.driven[:, 2]  # ``forcing`` has set it
        out = self.residual(q, v, told, data)
        if besides is not None:
            out += vector("besides", besides, self.n)
        self._factor_mass(time)
        out[~self.free] = 0.0
        solve(self.model, self._system, out)
        if len(self.constraints):
            close_solve(self.model, data, self._system, out)
        return np.where(self.free, -out, told)

    def _factor_mass(self, time: float) -> None:
        """Factor the mass matrix at the last residual, with the constraints that act."""
        tangent(self.model, self._data, (0.0, 0.0, 1.0), self._system)
        hold_still(self.model, self._system)
        if not factor(self.model, self._system):
            raise np.linalg.LinAlgError("the mass matrix is singular")
        if not len(self.constraints):
            return
        rows, closed = self.constraints.acting(time), self._data.closed
        closed.on[:] = [rows[self.constraints.rows_of(k)].any() for k in range(len(closed.on))]
        if not close_factor(self.model, self._data, self._system, 0.0):
            raise np.linalg.LinAlgError("the constraints are singular")

    def reactions_of_constraints(
        self,
        q: Floats,
        v: Floats | None = None,
        efforts: Floats | None = None,
        time: float = 0.0,
        tip: Floats | None = None,
        tip_follows: bool = False,
        live: Live | None = None,
    ) -> dict[str, Reaction]:
        """Return what every constraint does in a state, at rest by default.

        Of rows that others imply the multipliers are zero: which of them carry what is not known.
        """
        v = self._zero if v is None else v
        data = self.forcing(efforts, time, 1.0, tip, tip_follows, live)
        self.accelerations(q, v, data, time)
        found = data.closed.multiplier.copy()
        return {name: self.constraints.reaction(name, found) for name in self.constraints.names}

    def redundant_constraints(self, q: Floats, time: float = 0.0) -> dict[str, Redundancy]:
        """Return which constraints say at q (n,) what others before them say, at a time in s.

        These rows are left out of every step, and their multipliers are zero.
        """
        self.residual(self.coordinates(q), self._zero, self._zero, self.forcing(time=time))
        return self.constraints.redundant(self.constraints.acting(time))

    def met(self, q: Floats, v: Floats, time: float = 0.0) -> tuple[Floats, Floats]:
        """Return the state (n,), (n,) nearest by its mass that meets the constraints at a time.

        Raises
        ------
        NotMet
            if a constraint is far from being met, or cannot be
        """
        q, v = self.coordinates(q).copy(), self.coordinates(v, "v").copy()
        time = number("time", time)
        acting = self.constraints.acting(time)
        if not acting.any():
            return q, v
        self.residual(q, v, self._zero, self.forcing(time=time))
        self.constraints.refuse_gap(acting)
        self._factor_mass(time)
        if not meet(self.model, self._data, self._system, q, v, self._zero):
            raise self.constraints.contradicted(acting)
        return q, v

    def _command(self, live: Live | None) -> None:
        if live is None and not self._commanded:
            return
        self._commanded = live is not None
        for own, given in zip(
            self._data.live, self._at_rest if live is None else live, strict=True
        ):
            own[:] = given

    def guided(self, time: float = 0.0, live: Live | None = None) -> tuple[Floats, Floats, Floats]:
        """Return positions, rates and accelerations (n,) of driven coordinates at a time in s.

        All others are zero.

        live : what those that follow commands were commanded; None: nothing
        """
        self._command(live)
        drives, out = self.compiled.loads.drives, np.zeros((3, self.n))
        told = np.zeros((len(drives.column), 3))
        known_motions(drives, self._data.live.course, number("time", time), told)
        out[:, drives.column] = told.T
        return out[0], out[1], out[2]

    def drive_forces(
        self,
        q: Floats,
        v: Floats,
        efforts: Floats | None = None,
        time: float = 0.0,
        tip: Floats | None = None,
        tip_follows: bool = False,
        live: Live | None = None,
    ) -> Floats:
        """Return the forces (D,) in N·m or N that drives must give in a state, beyond springs."""
        data = self.forcing(efforts, time, 1.0, tip, tip_follows, live)
        a = self.accelerations(q, v, data, time)
        return self.residual(q, v, a, data)[~self.free]

    def tangents(
        self,
        q: Floats,
        v: Floats,
        a: Floats,
        efforts: Floats | None = None,
        time: float = 0.0,
        tip: Floats | None = None,
        tip_follows: bool = False,
    ) -> tuple[Floats, Floats, Floats]:
        """Return ∂r/∂q, ∂r/∂q̇, ∂r/∂q̈ (n, n) of the residual, exact; arguments of ``forcing``.

        Constraints push as they do in a motion through (q, v).
        """
        data = self.forcing(efforts, time, 1.0, tip, tip_follows)
        if len(self.constraints):
            self.accelerations(q, v, data, time)
        self.residual(q, v, a, data)

        unit = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        return self.last_tangent(unit[0]), self.last_tangent(unit[1]), self.last_tangent(unit[2])

    def last_tangent(self, alpha: tuple[float, float, float]) -> Floats:
        """Return α₀ ∂r/∂q + α₁ ∂r/∂q̇ + α₂ ∂r/∂q̈ at the last ``residual``.

        Any call in between may overwrite that state; ``tangents`` takes the state explicitly.
        """
        matrix = np.zeros((self.n, self.n))
        factors = vector("alpha", alpha, 3).tolist()
        tangent(self.model, self._data, (factors[0], factors[1], factors[2]), self._system)
        dense(self.model, self._system, matrix)
        if factors[0] != 0.0 and self._data.closed.multiplier.any():
            matrix += factors[0] * self.constraints.curvature()
        return matrix

    def coordinates(self, values: Floats, name: str = "q") -> Floats:
        """Return (n,) numbers for a kernel; refuse any other number of them."""
        return vector(name, values, self.n)

    def to_base(self, wrench: Floats) -> Floats:
        """Return the base-frame components of a wrench (6,) given along the world axes."""
        return self.compiled.to_base(wrench)
