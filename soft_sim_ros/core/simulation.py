"""A scene that moves: state, inputs held between calls, steps, and what can be read off."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import Diverged
from ..scene import Scene
from .dynamics import Dynamics
from .initial import check_mass, initial_state
from .integrators import method_of
from .kernels.entry import Entry
from .kernels.newton import REASONS
from .kernels.problem import (
    ACTUATOR_WORK,
    ADAPTIVE,
    BOOKED,
    ELASTIC,
    EVALUATIONS,
    FACTORISATIONS,
    GRAVITY,
    ITERATIONS,
    KINETIC,
    REFERENCE,
    REFUSED,
    REJECTED,
    STEPS,
    Held,
    Problem,
    forget,
    new_state,
    new_work,
)
from .model import Floats, in_its_plane
from .sampler import Sampler

LEDGER = (
    "kinetic",
    "elastic",
    "gravity",
    "actuator_work",
    "load_work",
    "dissipated",
    "residual",
)


class Statistics(NamedTuple):
    """Counters since construction.

    steps : steps of the method: those of the grid or pieces of them, or its own
    evaluations : of the residual (nfev elsewhere)
    factorisations : of the Newton matrix, each after a tangent (njev, nlu)
    iterations : of Newton's method
    refused : steps that failed and were tried again smaller
    rejected : steps of the adaptive method whose error was too large
    """

    steps: int
    evaluations: int
    factorisations: int
    iterations: int
    refused: int
    rejected: int


class Simulation:
    """A soft arm in motion.

    Parameters
    ----------
    scene : Scene
    prune : bool
        whether a planar motion is computed in its plane (same numbers, less work)

    Attributes
    ----------
    q, v : (n,) read-only views of the generalised coordinates and their rates
    time_ns, step_ns : simulation time and step in whole nanoseconds

    Notes
    -----
    The motion is a pure function of the scene and of the calls made, in steps: how steps are
    grouped into
    ``advance`` calls does not change a bit of it.
    """

    def __init__(self, scene: Scene, prune: bool = True) -> None:
        self.dynamics = Dynamics(scene)
        self.compiled = self.dynamics.compiled
        self.scene = scene = self.compiled.scene
        self.model = self.compiled.model
        self.coordinate_names = self.compiled.coordinate_names
        self.actuator_names = tuple(actuator.name for actuator in scene.actuators)
        self.n_coordinates = len(self.coordinate_names)
        self.n_actuators = len(self.actuator_names)
        self.length = self.compiled.length
        self.step_ns = round(scene.numerics.step * 1e9)
        self.step_index = 0
        method = method_of(scene)
        stages = max(method.tableau.shape[0], method.starter.shape[0]) - 1
        if method.kind != ADAPTIVE:
            stages = method.tableau.shape[0] - 1
        # dashpots of Maxwell branches follow the coordinates in all that a step moves
        parts = 2 if len(self.model.branch) else 1
        held = np.diag(self.dynamics.branch_matrix()) > 0.0
        weight = np.concatenate([self.model.weight, self.model.weight * held])
        stepped = self.model._replace(weight=weight[: parts * self.n_coordinates])
        # steps run in the plane of the motion if there is one; what is read off sees all of space
        stepped = in_its_plane(stepped) if prune else stepped
        self._work, self._state = new_work(stepped, stages), new_state(stepped)
        self._q, self._v = self._state.q, self._state.v
        self.q, self.v = self._q[: self.n_coordinates], self._v[: self.n_coordinates]
        self.q.flags.writeable = self.v.flags.writeable = False
        self._efforts = np.array([actuator.safe for actuator in scene.actuators], dtype=np.float64)
        self._held = Held(
            gravity=self.compiled.gravity.copy(),
            effort=self._efforts,
            tip=np.zeros(6),
            follows=np.zeros(1, dtype=np.int64),
        )
        self._problem = Problem(
            model=stepped,
            loads=self.compiled.loads,
            data=self.dynamics.forcing(self._efforts),
            work=self._work,
            method=method,
            held=self._held,
            state=self._state,
            calls=np.zeros(5, dtype=np.int64),
        )
        self._entry = Entry(self._problem, self.dynamics.calls())
        self._start = initial_state(self.dynamics, self._efforts)
        check_mass(self.dynamics, self._start[0])
        self.reset()

    @property
    def time_ns(self) -> int:
        """Simulation time in ns: a whole number of steps."""
        return self.step_index * self.step_ns

    @property
    def time(self) -> float:
        """Simulation time in s."""
        return self.time_ns / 1e9

    def reset(self) -> None:
        """Go back to the initial state, with safe efforts and no wrench at the tip.

        Time goes on.
        """
        self._place(*self._start)
        self._efforts[:] = [actuator.safe for actuator in self.scene.actuators]
        self._held.tip[:] = 0.0
        self._held.follows[:] = 0
        self._forget()

    def _place(self, q: Floats, v: Floats) -> None:
        """Set coordinates and rates; dashpots are where nothing pulls at them, and rest."""
        parts = len(self._q) // self.n_coordinates if self.n_coordinates else 1
        self._q[:], self._v[:] = np.tile(q, parts), 0.0
        self._v[: self.n_coordinates] = v

    def _forget(self) -> None:
        """Start the solver's memory and the ledger anew from the present state."""
        forget(self._work)
        state = self._state
        state.ledger[:] = 0.0
        self._settle()
        state.account[BOOKED] = 0.0
        state.account[REFERENCE] = state.account[[KINETIC, ELASTIC, GRAVITY]].sum()

    def _settle(self) -> None:
        """Book the work of the efforts held so far: exact, since they were constant."""
        self._entry.take_stock()
        self._state.account[BOOKED] = self._state.account[ACTUATOR_WORK]
        self._state.settled[:] = self._state.position

    def set_state(self, q: Floats, v: Floats) -> None:
        """Set coordinates and rates (n,), Maxwell branches relaxed; the ledger counts from here."""
        for name, value in (("q", q), ("v", v)):
            array = np.asarray(value, dtype=np.float64)
            if array.shape != self.q.shape or not np.isfinite(array).all():
                raise ValueError(f"{name} must be {self.q.shape} finite numbers, not {value!r}")
        self._place(q, v)
        self._forget()

    def set_efforts(self, efforts: Floats) -> None:
        """Hold efforts (A,) in scene order, in N·m, N or Pa (lengths in m), from now on."""
        given = np.array(efforts, dtype=np.float64)
        if given.shape != self._efforts.shape or not self._entry.hold(given):
            expected = f"{self._efforts.shape} finite numbers"
            raise ValueError(f"efforts must be {expected}, not {efforts!r}")

    def set_tip_wrench(self, wrench: Floats, frame: str = "world") -> None:
        """Hold a wrench (6,), moment N·m then force N, on the tip.

        Along world axes, or ("tip") following it.
        """
        wrench = np.asarray(wrench, dtype=np.float64)
        if wrench.shape != (6,) or not np.isfinite(wrench).all():
            raise ValueError(f"a wrench is 6 finite numbers, not {wrench!r}")
        if frame not in ("world", "tip"):
            raise ValueError(f"frame must be 'world' or 'tip', not {frame!r}")
        follows = frame == "tip"
        local = wrench if follows else self.dynamics.to_base(wrench)
        held = self._held
        if follows == held.follows[0] and np.array_equal(local, held.tip):
            return
        held.tip[:], held.follows[0] = local, follows
        self._work.restart[0] = 1

    def held(self) -> tuple[Floats, Floats, bool]:
        """Return the efforts (A,) held now, the wrench (6,) on the tip, and whether it follows it.

        The wrench is along world axes, or along those of the tip if it follows.
        """
        held, turn = self._held, self.compiled.base[:3, :3]
        follows = bool(held.follows[0])
        wrench = held.tip if follows else (turn @ held.tip.reshape(2, 3).T).T.ravel()
        return held.effort.copy(), wrench.copy(), follows

    def advance(self, steps: int) -> None:
        """Make ``steps`` steps. The GIL is free meanwhile.

        Raises
        ------
        Diverged
            if a step is refused even when cut into small pieces; state and time are those of the
            last good step.
        """
        made, status = self._entry.advance(self.time_ns, self.step_ns, steps)
        self.step_index += made
        if status:
            raise Diverged(self.time, REASONS[status])

    def ports(self) -> tuple[Floats, Floats, Floats]:
        """Return position, velocity and effort (A,) of the actuator ports.

        Effort · velocity is power into the arm; the effort of a tendon is its tension, also where
        its length is commanded.
        """
        self._entry.take_stock()
        state = self._state
        return state.position.copy(), state.rate.copy(), state.acting.copy()

    def ledger(self) -> Floats:
        """Return the energies and works of LEDGER in J.

        The residual is H − H₀ − work + dissipated: what the time integration lost or made of
        energy.
        """
        self._entry.take_stock()
        kinetic, elastic, gravity, work, reference, _ = self._state.account.tolist()
        dissipated, load_work = self._state.ledger.tolist()
        residual = kinetic + elastic + gravity - reference - work - load_work + dissipated
        return np.array([kinetic, elastic, gravity, work, load_work, dissipated, residual])

    @property
    def time_error(self) -> float:
        """Sum of the errors of all steps since the last state set, in arm lengths.

        Estimated by the embedded method of the adaptive integrator; 0 for others, which have none.
        Errors that damping has extinguished are still in it.
        """
        return float(self._work.measure[1])

    def statistics(self) -> Statistics:
        """Return the solver's counters."""
        c = self._work.counters
        picks = (STEPS, EVALUATIONS, FACTORISATIONS, ITERATIONS, REFUSED, REJECTED)
        return Statistics(*(int(c[i]) for i in picks))

    @property
    def nbytes(self) -> int:
        """Memory in bytes of model, state and solver."""
        return _bytes(self._problem)

    def sampler(self, poses: int) -> Sampler:
        """Return a sampler of ``poses`` frames, equally spaced in arc length from base to tip.

        The last one is the frame at the end of the chain, beyond joints and bodies after the rods.
        """
        return Sampler(self.compiled, self.q, np.linspace(0.0, self.length, poses))


def _bytes(value: object) -> int:
    """Return the memory of nested tuples of arrays."""
    if isinstance(value, np.ndarray):
        return value.nbytes
    return sum(map(_bytes, value)) if isinstance(value, tuple) else 0
