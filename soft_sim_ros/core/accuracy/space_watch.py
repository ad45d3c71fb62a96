"""Inputs that estimate the spatial error of a run: by single checks, or by a finer companion."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.tips import apart
from soft_sim_ros.core.refine.prolong import finer
from soft_sim_ros.core.refine.space_error import Forcing, limit_of, motion_error, trust
from soft_sim_ros.core.simulation.bounds import Bounds
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.core.simulation.orders import Order
from soft_sim_ros.core.simulation.simulation import Simulation
from soft_sim_ros.errors import NotResolved, SolverError

BEAT = 1.0  # s between two checks of a run of unknown length
# A check may show half of the error that builds up; written numerics were not tried in any motion.
UNSEEN = 2.0
LARGE = 600  # no checks beyond this many coordinates


def has_space(simulation: Simulation) -> bool:
    """Whether the scene has a rod that can be refined, and a check is cheap."""
    return bool(simulation.compiled.chain.rods) and 0 < simulation.n_coordinates <= LARGE


class SpaceInputs(Inputs):
    """Inputs of a simulation with an estimate of its tip's error in space.

    Parameters
    ----------
    simulation, command_timeout, ramp, bounds : as for Inputs
    complain : receives one message when the estimate exceeds the limit

    Attributes
    ----------
    space_rel : largest estimate since the last reset, over the length; NaN before a check
    space_limit : beyond which a warning is given
    """

    def __init__(
        self,
        simulation: Simulation,
        command_timeout: float,
        ramp: float,
        complain: Callable[[str], None] = lambda text: None,
        bounds: Bounds | None = None,
    ) -> None:
        super().__init__(simulation, command_timeout, ramp, bounds)
        self.space_rel, self.space_limit = float("nan"), limit_of(simulation.dynamics)
        self._complain = complain

    @property
    def coarse(self) -> bool:
        """Whether the estimate is beyond the limit."""
        return self.space_rel > self.space_limit

    def told(self) -> str:
        """Say how far off the tip may be."""
        return str(NotResolved(self.simulation.scene.name, self.space_rel, self.space_limit))

    def space(self) -> dict[str, float]:
        """Return estimate and limit by their keys in summary.json."""
        return {"error_rel": self.space_rel, "limit": self.space_limit}

    def look(self) -> None:
        """Look at the state of now."""
        raise NotImplementedError

    def reset(self) -> None:
        """Go back to the initial state; the estimate begins anew."""
        super().reset()
        self.space_rel = float("nan")

    def _note(self, error: float) -> None:
        before = self.coarse
        self.space_rel = error if np.isnan(self.space_rel) else max(self.space_rel, error)
        if self.coarse and not before:
            self._complain(f"at t = {self.simulation.time:.9g} s {self.told()}")


class _Seen(NamedTuple):
    """The data of a check: the arguments of `motion_error`."""

    q: Floats
    v: Floats
    forcing: Forcing
    elapsed: float
    moved: float


class LookedInputs(SpaceInputs):
    """Inputs of a simulation that is looked at now and then (`motion_error`): no companion.

    Parameters
    ----------
    simulation, command_timeout, ramp, complain, bounds : as for SpaceInputs
    beat : s between two looks, which fall on the ends of calls of `advance`
    later : whether `advance` only keeps what it sees, for `catch_up` in another thread: a look
        takes some milliseconds
    """

    def __init__(
        self,
        simulation: Simulation,
        command_timeout: float,
        ramp: float,
        complain: Callable[[str], None] = lambda text: None,
        bounds: Bounds | None = None,
        beat: float = BEAT,
        later: bool = False,
    ) -> None:
        super().__init__(simulation, command_timeout, ramp, complain, bounds)
        # a model of its own: what steps need of the simulation's is not touched
        self._model = Dynamics(simulation.compiled)
        finer(self._model)  # compiled before the run, not during it
        self._later = later
        self._seen: _Seen | None = None
        self._beat = max(1, round(beat * 1e9 / simulation.step_ns))
        self._began = self._last = simulation.step_index
        self._doubtful = UNSEEN if simulation.scene.numerics.written else 1.0
        self._tips = simulation.tips()
        self._start, self._moved = self._tips.poses()[:, :3].copy(), 0.0
        if later:
            self.look()  # once before the run, so that its kernels are compiled

    def advance(self, steps: int) -> None:
        """Advance by ``steps``, and look if it is time."""
        super().advance(steps)
        if self.simulation.step_index - self._last >= self._beat:
            self._see()
            if not self._later:
                self.catch_up()

    def look(self) -> None:
        """Look at the state of now."""
        self._see()
        self.catch_up()

    def catch_up(self) -> None:
        """Check the state kept last, if it was not checked yet; one thread at a time."""
        seen, self._seen = self._seen, None
        if seen is None:
            return
        error = motion_error(self._model, *seen)
        self._note(self._doubtful * error)

    def _see(self) -> None:
        """Keep the present state."""
        simulation = self.simulation
        self._last = simulation.step_index
        elapsed = (simulation.step_index - self._began) * simulation.step_ns * 1e-9
        compiled = simulation.compiled
        way = compiled.length * apart(self._tips.poses()[:, :3], self._start, compiled)
        self._moved = max(self._moved, float(way))
        q, v = simulation.q.copy(), simulation.v.copy()
        self._seen = _Seen(q, v, acting(simulation), elapsed, self._moved)

    def reset(self) -> None:
        """Go back to the initial state; the estimate begins anew."""
        super().reset()
        self._began = self._last = self.simulation.step_index
        self._moved, self._seen = 0.0, None


class AccompaniedInputs(SpaceInputs):
    """Inputs of a simulation and of a companion with a finer space, which makes the same steps.

    Parameters
    ----------
    simulation, command_timeout, ramp, complain : as for SpaceInputs
    """

    def __init__(
        self,
        simulation: Simulation,
        command_timeout: float,
        ramp: float,
        complain: Callable[[str], None] = lambda text: None,
    ) -> None:
        super().__init__(simulation, command_timeout, ramp, complain)
        self.companion = Simulation(finer(simulation.dynamics).compiled)
        self._shadow = Inputs(self.companion, command_timeout, ramp)
        self._pair = [s.tips() for s in (simulation, self.companion)]
        self._trust = trust(simulation.dynamics)
        self.look()

    def take(self, order: Order) -> None:
        """Hold the values of ``order`` from the next `update` on, both."""
        super().take(order)
        self._shadow.take(order)

    def advance(self, steps: int) -> None:
        """Advance both by ``steps``, and compare their tips."""
        super().advance(steps)
        if self.space_rel == np.inf:
            return
        try:
            # after an interrupt the companion may be behind
            self._shadow.advance(self.simulation.step_index - self.companion.step_index)
        except SolverError:
            self._note(np.inf)
            return
        self.look()

    def look(self) -> None:
        """Compare the tips of now."""
        one, other = (tips.poses()[:, :3] for tips in self._pair)
        self._note(self._trust * float(apart(one, other, self.simulation.compiled)))

    def reset(self) -> None:
        """Go back to the initial state, both; the estimate begins anew."""
        super().reset()
        self._shadow.reset()
        self.companion.step_index = self.simulation.step_index  # it may have given up, or not


def acting(simulation: Simulation) -> Forcing:
    """Return the present forcing of a simulation, along world axes or those of the tip."""
    efforts, wrench, follows = simulation.held()
    return Forcing(efforts, simulation.time, 1.0, wrench, follows, simulation.live())


def as_json(space: dict[str, float]) -> dict[str, float | None]:
    """Return an estimate that JSON can hold: null where there is none."""
    return {key: value if np.isfinite(value) else None for key, value in space.items()}
