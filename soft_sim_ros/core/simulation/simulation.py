"""Simulation of a scene: state, inputs held between calls, steps, and outputs."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from soft_sim_ros.core.arguments import vector, whole
from soft_sim_ros.core.backend.copying import arrays_of
from soft_sim_ros.core.backend.interrupts import next_pace, wholly
from soft_sim_ros.core.compile.overflow import LATEST, refuse_energy, whole_nanoseconds
from soft_sim_ros.core.compile.samples import at_node
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.integrators.entry import Entry
from soft_sim_ros.core.integrators.newton import REASONS
from soft_sim_ros.core.integrators.problem import (
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
from soft_sim_ros.core.integrators.tableaus import method_of
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.sampler import Frames, Sampler
from soft_sim_ros.core.model.model import in_its_plane
from soft_sim_ros.core.terms.driven import bring
from soft_sim_ros.errors import BadArgument, Diverged
from soft_sim_ros.scene import Scene

from .initial import check_mass, initial_state
from .statistics import Statistics
from .twins import Twins

LEDGER = (
    "kinetic",
    "elastic",
    "gravity",
    "actuator_work",
    "load_work",
    "dissipated",
    "residual",
)

MOST_POSES = 100_000


class Simulation(Twins):
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
    grouped into ``advance`` calls does not change a bit of it.
    """

    def __init__(self, scene: Scene, prune: bool = True) -> None:
        self._build(Dynamics(scene), prune)
        self._start = initial_state(self.dynamics, self._efforts)
        check_mass(self.dynamics, self._start[0])
        self.reset()
        refuse_energy(self.scene, self.ledger())

    def _build(self, dynamics: Dynamics, prune: bool) -> None:
        """Make everything but the state."""
        self.dynamics, self._prune = dynamics, prune
        self.compiled = self.dynamics.compiled
        self.scene = scene = self.compiled.scene
        self.model = self.compiled.model
        self.coordinate_names = self.compiled.coordinate_names
        self.actuator_names = tuple(actuator.name for actuator in scene.actuators)
        self.n_coordinates = len(self.coordinate_names)
        self.n_actuators = len(self.actuator_names)
        self.length = self.compiled.length
        self.step_ns = whole_nanoseconds(scene)
        self._most_steps = LATEST // self.step_ns
        self._pace = 1
        method = method_of(scene)
        stages = max(method.tableau.shape[0], method.starter.shape[0]) - 1
        if method.kind != ADAPTIVE:
            stages = method.tableau.shape[0] - 1
        # dashpots of Maxwell branches follow the coordinates in all that a step moves
        parts = 2 if len(self.model.branch) else 1
        held = np.diag(self.dynamics.branch_matrix()) > 0.0
        # what is told to a driven coordinate is no matter of Newton's method, nor of its errors
        own = np.where(self.dynamics.free, self.model.weight, 0.0)
        weight = np.concatenate([own, own * held])
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
        self._own = frozenset(vars(self)) | {"_own", "_start"}

    @property
    def _moving(self) -> tuple[Any, ...]:
        """All arrays that a step or a command may change."""
        return self._work, self._state, self._held, self._problem.data

    @property
    def step_index(self) -> int:
        """Steps made since construction; it can be set, to begin at another time."""
        return int(self._state.clock[0])

    @step_index.setter
    def step_index(self, index: int) -> None:
        self._state.clock[0] = whole("step_index", index, 0, self._most_steps)

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

        def begin() -> None:
            self._place(*self._start)
            self._efforts[:] = [actuator.safe for actuator in self.scene.actuators]
            self._held.tip[:] = 0.0
            self._held.follows[:] = 0
            self._forget()

        wholly(begin)

    def _place(self, q: Floats, v: Floats) -> None:
        """Set coordinates and rates; dashpots are relaxed and at rest."""
        parts = len(self._q) // self.n_coordinates if self.n_coordinates else 1
        self._q[:], self._v[:] = np.tile(q, parts), 0.0
        self._v[: self.n_coordinates] = v
        if not self.dynamics.free.all():
            bring(self.compiled.loads.drives, self.time, self._q, self._v)

    def _forget(self) -> None:
        """Start the solver's memory and the ledger anew from the present state."""
        forget(self._work)
        state = self._state
        state.ledger[:] = 0.0
        self._settle()
        state.account[BOOKED] = 0.0
        state.account[REFERENCE] = state.account[[KINETIC, ELASTIC, GRAVITY]].sum()

    def forget_attempts(self) -> None:
        """Let a step that failed have no influence on the next one: the state alone counts."""
        forget(self._work)

    def _settle(self) -> None:
        """Book the work of the efforts held so far: exact, since they were constant."""
        self._entry.take_stock()
        self._state.account[BOOKED] = self._state.account[ACTUATOR_WORK]
        self._state.settled[:] = self._state.position

    def set_state(self, q: Floats, v: Floats) -> None:
        """Set coordinates and rates (n,), Maxwell branches relaxed; the ledger counts from here."""
        q = vector("q", q, self.n_coordinates, finite=True)
        v = vector("v", v, self.n_coordinates, finite=True)

        def begin() -> None:
            self._place(q, v)
            self._forget()

        wholly(begin)

    def set_efforts(self, efforts: Floats) -> None:
        """Hold efforts (A,) in scene order, in N·m, N or Pa (lengths in m), from now on."""
        given = vector("efforts", efforts, self.n_actuators)
        if not self._entry.hold(given):
            raise BadArgument("efforts", efforts, f"{self.n_actuators} finite numbers")

    def set_tip_wrench(self, wrench: Floats, frame: str = "world") -> None:
        """Hold a wrench (6,), moment N·m then force N, on the tip.

        Along world axes, or ("tip") following it.
        """
        wrench = vector("wrench", wrench, 6, finite=True)
        if frame not in ("world", "tip"):
            raise BadArgument("frame", frame, "'world' or 'tip'")
        follows = frame == "tip"
        local = wrench if follows else self.dynamics.to_base(wrench)
        if not np.isfinite(local).all():  # overflows when rotated
            raise BadArgument("wrench", wrench, "6 finite numbers, also along the axes of the base")
        held = self._held
        if follows == held.follows[0] and np.array_equal(local, held.tip):
            return

        def push() -> None:
            held.tip[:], held.follows[0] = local, follows
            self._work.restart[0] = 1

        wholly(push)

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

        An interrupt (Ctrl-C) is heeded between two of them, within SLICE or so; state, time and
        ledger then are those of the last step made.

        Raises
        ------
        BadArgument
            if ``steps`` is no whole number, below zero, or leads past the last time that 64 bits
            of nanoseconds hold
        Diverged
            if a step is refused even when cut into small pieces; state and time are those of the
            last good step.
        """
        entry, clock, step_ns = self._entry, self._state.clock, self.step_ns
        index = clock.item()
        last = index + whole("steps", steps, 0, self._most_steps - index)
        while True:
            begin = time.perf_counter()
            if status := entry.advance(step_ns, last - index, self._pace):
                raise Diverged(self.time, REASONS[status])
            index = clock.item()
            if index >= last:
                return
            # grouping does not change results, so it may depend on the speed of the machine
            self._pace = next_pace(self._pace, time.perf_counter() - begin)

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
        return sum(array.nbytes for array in arrays_of(self._problem))

    def sampler(self, poses: int, backbone: str | None = None) -> Sampler:
        """Return a sampler of ``poses`` frames, equally spaced in arc length along a backbone.

        The last one is the frame at the end of it, beyond joints and bodies after the rods.

        backbone : one of ``Compiled.backbones``; the last of them by default, in a chain the only
            one
        """
        poses = whole("poses", poses, 1, MOST_POSES)
        branch = self.compiled.backbone(backbone)
        s = np.linspace(0.0, branch.length or 1.0, poses)
        return Sampler(self.compiled, self.q, s, of=self, backbone=backbone)

    def tips(self) -> Frames:
        """Return the frames of all tips; each call of ``poses()`` reads the present state."""
        places = [at_node(node) for node in self.compiled.tips]
        return Frames(self.compiled, self.q, places, of=self)
