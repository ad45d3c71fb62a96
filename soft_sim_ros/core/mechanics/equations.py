"""The equations of motion of a scene as functions of state, efforts and time, by recursion.

r(q, q̇, q̈) = M q̈ + C q̇ + g + k + R q̇ − loads − actuators, its exact derivatives, and its solution
for q̈. ``dynamics.py`` takes it apart.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from soft_sim_ros.core.arguments import number, vector
from soft_sim_ros.core.backend.copying import take_rest
from soft_sim_ros.core.backend.jit import Call
from soft_sim_ros.core.compile.scene import Compiled, compile_scene
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Data, Live, new_data, new_live
from soft_sim_ros.core.recursion.elimination import dense, factor, new_system, solve
from soft_sim_ros.core.recursion.rnea import inverse_dynamics
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.terms.driven import hold_still, known_motions
from soft_sim_ros.core.terms.forcing import apply_loads
from soft_sim_ros.errors import BadArgument
from soft_sim_ros.scene import Scene


class Equations:
    """A compiled scene as a function of state, efforts and time.

    Parameters
    ----------
    scene : Scene or Compiled

    Attributes
    ----------
    free : (n,) whether a coordinate is free to move; the others are driven

    Notes
    -----
    ``efforts`` (A,) in scene order default to zero. Loads are those of the scene at ``time`` in s,
    times ``share``.
    Gravity is multiplied by ``share`` too: a static load path scales one number.
    """

    def __init__(self, scene: Scene | Compiled) -> None:
        self.compiled = scene if isinstance(scene, Compiled) else compile_scene(scene)
        self.model = self.compiled.model
        self.n = len(self.compiled.coordinate_names)
        self.actuators = len(self.model.port_ptr) - 1
        self._data = new_data(self.model, len(self.compiled.loads.push))
        self._system = new_system(self.model)
        self._zero = np.zeros(self.n)
        self._no_tip = np.zeros(6)
        self._at_rest = new_live(len(self.compiled.loads.push), len(self.model.driven))
        self.free = np.ones(self.n, dtype=bool)
        self.free[self.model.driven[:, 0]] = False

    # Copies have their own scratch; the compiled scene is immutable and shared.

    def __copy__(self) -> Equations:
        return self._twin(None)

    def __deepcopy__(self, memo: dict[int, Any]) -> Equations:
        return self._twin(memo)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.compiled,)

    def _twin(self, memo: dict[int, Any] | None) -> Equations:
        new = type(self)(self.compiled)
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

    def calls(self) -> list[Call]:
        """Return the kernels that a mass matrix needs, with arguments, to be compiled ahead."""
        state, alpha = (self._zero, self._zero, self._zero, self._zero), (1.0, 1.0, 1.0)
        matrix = np.zeros((self.n, self.n))
        return [
            (inverse_dynamics, self.model, self._data, *state),
            (tangent, self.model, self._data, alpha, self._system),
            (dense, self.model, self._system, matrix),
        ]

    def residual(self, q: Floats, v: Floats, a: Floats, data: Data) -> Floats:
        """Return M a + C v + g + k + R v − loads − actuators (n,)."""
        q, v, a = self.coordinates(q), self.coordinates(v, "v"), self.coordinates(a, "a")
        if data is not self._data:
            raise BadArgument("data", type(data), "what ``forcing`` of the same object returned")
        out = np.zeros(self.n)
        inverse_dynamics(self.model, data, q, v, a, out)
        return out

    def inverse_dynamics(
        self, q: Floats, v: Floats, a: Floats, efforts: Floats | None = None, time: float = 0.0
    ) -> Floats:
        """Return the generalised force (n,) that the motion needs besides loads and efforts."""
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

        Driven coordinates accelerate as they are told at ``time``. Other arguments: ``forcing``.

        Raises
        ------
        numpy.linalg.LinAlgError
            if a coordinate moves no mass
        """
        told = self.guided(time, live)[2]
        data = self.forcing(efforts, time, 1.0, tip, tip_follows, live)
        out = self.residual(q, v, told, data)
        tangent(self.model, self._data, (0.0, 0.0, 1.0), self._system)
        out[~self.free] = 0.0
        hold_still(self.model, self._system)
        if not factor(self.model, self._system):
            raise np.linalg.LinAlgError("the mass matrix is singular")
        solve(self.model, self._system, out)
        return np.where(self.free, -out, told)

    def _command(self, live: Live | None) -> None:
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
        a = self.forward_dynamics(q, v, efforts, time, tip, tip_follows, live)
        data = self.forcing(efforts, time, 1.0, tip, tip_follows, live)
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
        """Return ∂r/∂q, ∂r/∂q̇, ∂r/∂q̈ (n, n) of the residual, exact; arguments of ``forcing``."""
        self.residual(q, v, a, self.forcing(efforts, time, 1.0, tip, tip_follows))

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
        return matrix

    def coordinates(self, values: Floats, name: str = "q") -> Floats:
        """Return (n,) numbers for a kernel; refuse any other number of them."""
        return vector(name, values, self.n)

    def to_base(self, wrench: Floats) -> Floats:
        """Return the base-frame components of a wrench (6,) given along the world axes."""
        return self.compiled.to_base(wrench)
