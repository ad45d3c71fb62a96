"""What steps a compiled scene: its arrays and kernels, and the state in them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from soft_sim_ros.core.arguments import whole
from soft_sim_ros.core.backend.interrupts import wholly
from soft_sim_ros.core.compile.overflow import LATEST, refuse_energy, whole_nanoseconds
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.integrators.entry import Entry
from soft_sim_ros.core.integrators.problem import (
    ACTUATOR_WORK,
    ADAPTIVE,
    BOOKED,
    DISSIPATED,
    ELASTIC,
    GRAVITY,
    KINETIC,
    LOAD_WORK,
    REFERENCE,
    Held,
    Problem,
    forget,
    new_state,
    new_work,
)
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.model.model import Live, new_data, new_live
from soft_sim_ros.core.terms.driven import bring
from soft_sim_ros.errors import BadArgument, OtherModel

from .bristles import held_bristles, recall_bristles
from .fits import known_to_fit, note_fit, refuse_misfit, refuse_readings
from .initial import check_mass, initial_coordinates
from .mark import ModelMark
from .memory import SolverMemory
from .shared import shared_by
from .state import SimulationState

if TYPE_CHECKING:
    from .sensing import Sensing


class Stepper:
    """A compiled scene that can be stepped, in no state yet.

    Parameters
    ----------
    compiled : Compiled
    prune : whether a planar motion is computed in its plane
    """

    def __init__(self, compiled: Compiled, prune: bool = True) -> None:
        self._prune = prune
        self.compiled, self.scene = compiled, compiled.scene
        self.dynamics = Dynamics(compiled)
        self.n_coordinates, self.n_actuators = self.dynamics.n, self.dynamics.actuators
        self.step_ns = whole_nanoseconds(self.scene)
        self._most_steps = LATEST // self.step_ns
        self._shared = shared_by(compiled, prune)
        method = self._shared.method
        stages = max(method.tableau.shape[0], method.starter.shape[0]) - 1
        if method.kind != ADAPTIVE:
            stages = method.tableau.shape[0] - 1
        stepped = self._shared.model
        if self.dynamics.attached:
            stepped = stepped._replace(inertia=self.dynamics.model.inertia)
        self._work, self._state = new_work(stepped, stages), new_state(stepped)
        self._q, self._v = self._state.q, self._state.v
        self.q, self.v = self._q[: self.n_coordinates], self._v[: self.n_coordinates]
        self.q.flags.writeable = self.v.flags.writeable = False
        self._held = Held(
            gravity=compiled.gravity.copy(),
            effort=self._safe_efforts(),
            tip=np.zeros(6),
            follows=np.zeros(1, dtype=np.int64),
            live=new_live(len(compiled.loads.push), len(stepped.driven)),
        )
        data = new_data(stepped, len(compiled.loads.push))
        # one array for both: the equations know at any time what is held, and where
        told = self.dynamics.scratch.closed.held
        self._problem = Problem(
            model=stepped,
            loads=compiled.loads,
            data=data._replace(closed=data.closed._replace(held=told)),
            work=self._work,
            method=method,
            held=self._held,
            state=self._state,
            calls=np.zeros(6, dtype=np.int64),
        )
        self._closed = self._problem.data.closed
        self._sensing: Sensing | None = None
        if self.scene.sensors:
            from .sensing import Sensing  # scenes without any need not load it

            self._sensing = Sensing(compiled, self.step_ns)
        self._entry = Entry(self._problem, self.dynamics.calls(), self._shared.packed)

    @property
    def _mark(self) -> ModelMark:
        return self._shared.mark

    def _safe_efforts(self) -> Floats:
        """Return the efforts (A,) that the actuators hold when nobody commands them."""
        return np.array([actuator.safe for actuator in self.scene.actuators], dtype=np.float64)

    @property
    def step_index(self) -> int:
        """Steps made since construction; it can be set, to begin at another time."""
        return int(self._state.steps[0])

    @step_index.setter
    def step_index(self, index: int) -> None:
        self._state.steps[0] = whole("step_index", index, 0, self._most_steps)
        if len(self.compiled.model.driven):  # at another time they are elsewhere
            self._begin(self.q.copy(), self.v.copy())
        self._sense_anew()

    @property
    def time_ns(self) -> int:
        """Simulation time in ns: a whole number of steps."""
        return self.step_index * self.step_ns

    @property
    def time(self) -> float:
        """Simulation time in s."""
        return self.time_ns / 1e9

    def held(self) -> tuple[Floats, Floats, bool]:
        """Return the efforts (A,) held now, the wrench (6,) on the tip, and whether it follows it.

        The wrench is along world axes, or along those of the tip if it follows.
        """
        held, turn = self._held, self.compiled.base[:3, :3]
        follows = bool(held.follows[0])
        wrench = held.tip if follows else (turn @ held.tip.reshape(2, 3).T).T.ravel()
        return held.effort.copy(), wrench.copy(), follows

    def live(self) -> Live:
        """Return what is commanded besides, for `Equations.forcing`."""
        return Live(*(array.copy() for array in self._held.live))

    def state(self) -> SimulationState:
        """Return all that decides how it goes on, as an immutable value.

        It can be compared, pickled, saved to a file, and put back with `restore`.
        """
        state, held, n = self._state, self._held, self.n_coordinates
        now = SimulationState(
            model=self._mark,
            step_index=self.step_index,
            q=self.q,
            v=self.v,
            dashpots=np.array([self._q[n:], self._v[n:]]),
            efforts=held.effort,
            wrench=held.tip,
            wrench_follows=bool(held.follows[0]),
            pushes=held.live.push,
            pushes_follow=held.live.follows,
            courses=held.live.course,
            attached=np.array(self.dynamics.attached, dtype=np.int64),
            dissipated=float(state.ledger[DISSIPATED]),
            load_work=float(state.ledger[LOAD_WORK]),
            actuator_work=float(state.account[BOOKED]),
            reference=float(state.account[REFERENCE]),
            ports=state.settled,
            held=self._closed.held,
            acts=self._closed.on,
            multipliers=self._closed.multiplier,
            solver=SolverMemory.of(self._work),
            bristles=np.concatenate([part.ravel() for part in held_bristles(self._problem.data)]),
            sensed=np.zeros(0) if self._sensing is None else self._sensing.packed(),
        )
        return note_fit(now, self._mark)

    def restore(self, state: SimulationState) -> None:
        """Go to a state that `state` returned, time included, and go on from there as it would.

        With the same bits, whatever was done before and in whichever simulation of the model.

        Raises
        ------
        OtherModel
            if it belongs to another model
        StateError
            if there is something in it that no state holds, because somebody wrote its file
        """
        if not isinstance(state, SimulationState):
            raise BadArgument("state", state, "a SimulationState")
        if difference := self._mark.difference(state.model):
            raise OtherModel(self.scene.name, state.scene, difference)
        if not known_to_fit(state, self._mark):
            payloads = len(self.dynamics.attached)
            refuse_misfit(state, self._problem, self.n_coordinates, payloads, self._most_steps)
            refuse_readings(state, self._sensing)
            note_fit(state, self._mark)
        wholly(lambda: self._put(state))

    def _put(self, state: SimulationState) -> None:
        mine, held, n = self._state, self._held, self.n_coordinates
        mine.steps[0] = state.step_index
        self._q[:n], self._v[:n] = state.q, state.v
        self._q[n:], self._v[n:] = state.dashpots
        held.effort[:], held.tip[:], held.follows[0] = (
            state.efforts,
            state.wrench,
            state.wrench_follows,
        )
        held.live.push[:], held.live.follows[:] = state.pushes, state.pushes_follow
        held.live.course[:] = state.courses
        self.dynamics.carry(state.attached.astype(bool).tolist())
        mine.ledger[DISSIPATED], mine.ledger[LOAD_WORK] = state.dissipated, state.load_work
        mine.account[BOOKED], mine.account[REFERENCE] = state.actuator_work, state.reference
        mine.settled[:] = state.ports
        closed = self._closed
        closed.held[:], closed.on[:], closed.multiplier[:] = (
            state.held,
            state.acts,
            state.multipliers,
        )
        state.solver.recall(self._work)
        recall_bristles(self._problem.data, state.bristles)
        if self._sensing is not None:
            self._sensing.unpack(state.sensed)

    def _begin(self, q: Floats, v: Floats) -> None:
        """Set coordinates and rates (n,); dashpots are where nothing pulls at them, and rest.

        Bristles of friction are not deflected.

        Driven coordinates are where they are told to be now.

        What the solver remembers is void, and the ledger counts from here.
        """
        n = self.n_coordinates
        self._q[:n], self._v[:n] = q, v
        if len(self.compiled.model.driven):
            course = self._held.live.course
            bring(self.compiled.loads.drives, course, self.time, self._q, self._v)
        if len(self.dynamics.constraints):
            self._meet()
        self._q[n:], self._v[n:] = self._q[: len(self._q) - n], 0.0
        forget(self._work)
        recall_bristles(self._problem.data, None)
        state = self._state
        state.ledger[:] = 0.0
        # the work of the efforts held so far: exact, since they were constant
        self._entry.take_stock()
        state.account[BOOKED] = state.account[ACTUATOR_WORK]
        state.settled[:] = state.position
        state.account[BOOKED] = 0.0
        state.account[REFERENCE] = state.account[[KINETIC, ELASTIC, GRAVITY]].sum()
        self._sense_anew()

    def _sense_anew(self) -> None:
        """Let sensors measure the state that motion begins in, if there are any."""

    def _meet(self) -> None:
        """Put the state onto the constraints that act now, and note what they do."""
        n, closed, dynamics = self.n_coordinates, self._closed, self.dynamics
        self._q[:n], self._v[:n] = dynamics.met(self.q, self.v, self.time)
        efforts, tip, follows = self.held()
        dynamics.reactions_of_constraints(
            self.q, self.v, efforts, self.time, tip, follows, self._held.live
        )
        own = dynamics.scratch.closed
        closed.on[:], closed.multiplier[:] = own.on, own.multiplier

    def _to_start(self) -> None:
        """Go to the state that the scene begins in; the first of a model finds it for all."""
        if self._shared.initial is None:
            self._to_shape(*initial_coordinates(self.dynamics, self._safe_efforts()))
            self._shared.initial = self.state()
        self.restore(self._shared.initial)

    def _to_shape(self, q: Floats, v: Floats) -> None:
        """Go to coordinates and rates (n,), if motion can go on from there."""
        check_mass(self.dynamics, q)
        self._begin(q, v)
        refuse_energy(self.scene, self.ledger())

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
