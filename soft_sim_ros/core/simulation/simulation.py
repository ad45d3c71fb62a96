"""Simulation of a scene: state, inputs held between calls, steps, and outputs."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from soft_sim_ros.core.arguments import number, vector, whole
from soft_sim_ros.core.backend.copying import arrays_of
from soft_sim_ros.core.backend.interrupts import next_pace, wholly
from soft_sim_ros.core.compile.samples import at_node
from soft_sim_ros.core.compile.scene import Compiled, compile_scene
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.integrators.newton import REASONS, SINGULAR, UNMET
from soft_sim_ros.core.integrators.problem import (
    EVALUATIONS,
    FACTORISATIONS,
    ITERATIONS,
    REFUSED,
    REJECTED,
    STEPS,
    TIME_ERROR,
    forget,
)
from soft_sim_ros.core.mechanics.closures import Reaction
from soft_sim_ros.core.mechanics.contacts import Contact, ContactReader
from soft_sim_ros.core.mechanics.sampler import Frames, Sampler
from soft_sim_ros.core.terms.closures import FREED, HELD, MODE, TARGET
from soft_sim_ros.errors import Diverged
from soft_sim_ros.scene import Scene

from .sensed import Sensed
from .state import SimulationState
from .statistics import Statistics
from .stepper import Stepper

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
LATCH = 1e-4  # of the length, or rad: further apart frames cannot be that are made to hold


class Simulation(Sensed):
    """A soft arm in motion.

    Parameters
    ----------
    model : Scene or Compiled
        a scene is compiled first; what `compile_scene` returned may serve many simulations
    state : SimulationState or None
        what it begins in; None: the state that the scene begins in (`initial_state`)
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

    def __init__(
        self, model: Scene | Compiled, state: SimulationState | None = None, prune: bool = True
    ) -> None:
        self._build(model if isinstance(model, Compiled) else compile_scene(model), prune)
        if state is None:
            self._to_start()
        else:
            self.restore(state)
        self._start = self.state()

    def _build(self, compiled: Compiled, prune: bool) -> None:
        Stepper.__init__(self, compiled, prune)
        self.model = compiled.model
        self.coordinate_names = compiled.coordinate_names
        self.actuator_names = tuple(actuator.name for actuator in self.scene.actuators)
        self.length = compiled.length
        self._pace = 1
        self._contacts: ContactReader | None = None
        self._own = frozenset(vars(self)) | {"_own", "_start"}

    def reset(self) -> None:
        """Go back to the state it began in: that of the scene, or the one it was made with.

        Time goes on, and so do the counters of ``statistics``.
        """
        start = self._start
        counters = self._work.counters.copy()
        solver = replace(start.solver, counters=counters)
        again = replace(start, step_index=self.step_index, solver=solver)

        def begin() -> None:
            self._put(again)
            if len(self.model.driven):  # they are not where they were at the start
                self._begin(start.q, start.v)
            self._sense_anew()

        wholly(begin)

    def set_state(self, q: Floats, v: Floats) -> None:
        """Set coordinates and rates (n,), Maxwell branches relaxed; the ledger counts from here."""
        q = vector("q", q, self.n_coordinates, finite=True)
        v = vector("v", v, self.n_coordinates, finite=True)
        wholly(lambda: self._begin(q, v))

    def forget_attempts(self) -> None:
        """Let a step that failed have no influence on the next one: the state alone counts."""
        forget(self._work)

    def release(self, name: str) -> None:
        """Release a constraint from now on, whatever its schedule says.

        Raises
        ------
        NoSuchPlace
            if there is none of that name
        """
        k = self.dynamics.constraints.index(name)

        def let_go() -> None:
            self._closed.held[k, MODE] = FREED
            self._work.restart[0] = 1

        wholly(let_go)

    def hold(self, name: str, here: bool = False) -> None:
        """Let a constraint act from now on, whatever its schedule says.

        Bodies that move against each other stop there: what that loses of the energy is booked as
        dissipated.

        Parameters
        ----------
        here : whether the second frame is first put to where the first one is now

        Raises
        ------
        NoSuchPlace
            if there is none of that name
        NotMet
            if its frames are apart
        """
        constraints = self.dynamics.constraints
        k = constraints.index(name)
        self.dynamics.residual(self.q, self.v, self.v, self.dynamics.forcing(time=self.time))
        acting = np.zeros(constraints.rows, dtype=bool)
        acting[constraints.rows_of(k)] = True
        target = self._closed.held[k, TARGET:].copy()
        if here:
            target = constraints.here(k)
        else:
            constraints.refuse_gap(acting, LATCH)

        def catch() -> None:
            self._closed.held[k, MODE], self._closed.held[k, TARGET:] = HELD, target
            self._work.restart[0] = 1

        wholly(catch)

    def reactions(self) -> dict[str, Reaction]:
        """Return what every constraint does now: force and moment on its first frame."""
        dynamics, (efforts, tip, follows) = self.dynamics, self.held()
        if self.scene.numerics.integrator == "adaptive":
            return dynamics.reactions_of_constraints(
                self.q, self.v, efforts, self.time, tip, follows, self.live()
            )
        dynamics.residual(self.q, self.v, self.v, dynamics.forcing(time=self.time))
        own = dynamics.constraints
        return {name: own.reaction(name, self._closed.multiplier) for name in own.names}

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
        entry, made, step_ns = self._entry, self._state.steps, self.step_ns
        index = made.item()
        last = index + whole("steps", steps, 0, self._most_steps - index)
        sensing = self._sensing
        while True:
            stop = last if sensing is None else min(last, self._until_sensed(sensing))
            begin = time.perf_counter()
            if status := entry.advance(step_ns, stop - index, self._pace):
                raise Diverged(self.time, REASONS[status] + self._unmet(status))
            index = made.item()
            if sensing is not None:
                self._sense(sensing)
            if index >= last:
                return
            if index == stop:
                continue
            # grouping does not change results, so it may depend on the speed of the machine
            self._pace = next_pace(self._pace, time.perf_counter() - begin)

    def _unmet(self, status: int) -> str:
        """Return which constraint a step cannot meet, and by how much, where that is the reason.

        Where the first step after the last good state would find it if only drives moved.
        """
        if status not in (UNMET, SINGULAR) or not len(self.dynamics.constraints):
            return ""
        dynamics, ahead = self.dynamics, self.time + 1e-9 * self.step_ns
        told = dynamics.guided(ahead, self._held.live)[0]
        q, still = np.where(dynamics.free, self.q, told), np.zeros(self.n_coordinates)
        dynamics.residual(q, still, still, dynamics.forcing(time=ahead))
        constraints = dynamics.constraints
        acting = constraints.acting(self.time) | constraints.acting(ahead)
        return f": {constraints.contradicted(acting)}" if acting.any() else ""

    def ports(self) -> tuple[Floats, Floats, Floats]:
        """Return position, velocity and effort (A,) of the actuator ports.

        Effort · velocity is power into the arm; the effort of a tendon is its tension, also where
        its length is commanded.
        """
        self._entry.take_stock()
        state = self._state
        return state.position.copy(), state.rate.copy(), state.acting.copy()

    @property
    def time_error(self) -> float:
        """Sum of the errors of all steps since the last state set, in arm lengths.

        Estimated by the embedded method of the adaptive integrator; 0 for others, which have none.
        Errors that damping has extinguished are still in it.
        """
        return float(self._work.measure[TIME_ERROR])

    def statistics(self) -> Statistics:
        """Return the solver's counters."""
        c = self._work.counters
        picks = (STEPS, EVALUATIONS, FACTORISATIONS, ITERATIONS, REFUSED, REJECTED)
        return Statistics(*(int(c[i]) for i in picks))

    @property
    def nbytes(self) -> int:
        """Memory in bytes of model, state and solver."""
        return sum(array.nbytes for array in arrays_of(self._problem))

    def contacts(self, gap: float = 0.0) -> tuple[Contact, ...]:
        """Return what touches now, or is not further apart than a gap in m, base to tip.

        Empty for scenes without an environment. ``resultants`` sums them up by pairs.
        """
        if not len(self.model.contact.node):
            return ()
        if self._contacts is None:
            self._contacts = ContactReader(self.compiled)
        return self._contacts.near(
            self.q, self.v, number("gap", gap), self._problem.data.touch.bristle
        )

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
