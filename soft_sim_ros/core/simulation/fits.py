"""Whether a state can be one of a solver: what comes from a file may be anything."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from soft_sim_ros.core.integrators.adaptive import BEGIN, LENGTH, SINCE
from soft_sim_ros.core.integrators.problem import CQ, KNOWN, Problem
from soft_sim_ros.errors import StateError

from .bristles import held_bristles
from .mark import ModelMark
from .memory import ARRAYS, EXCHANGED, SolverMemory, factors_of
from .state import SimulationState

if TYPE_CHECKING:
    from .sensing import Sensing


def known_to_fit(state: SimulationState, mark: ModelMark) -> bool:
    """Return whether a state is known to be one of a model: nothing in it changes."""
    return vars(state).get("_fit") is mark


def note_fit(state: SimulationState, mark: ModelMark) -> SimulationState:
    """Note that a state is one of a model, and return it."""
    object.__setattr__(state, "_fit", mark)
    return state


def refuse_misfit(
    state: SimulationState, problem: Problem, n: int, payloads: int, most_steps: int
) -> None:
    """Refuse a state that no simulation of a problem of n coordinates can be in.

    payloads : of the scene
    most_steps : so many steps can be made before time ends

    Raises
    ------
    StateError
        which names the part that is not as it should be
    """
    live = problem.held.live
    where, actuators = f"state of {state.scene!r}", len(problem.held.effort)
    closed = problem.data.closed
    shapes: dict[str, tuple[int, ...]] = {
        **{"q": (n,), "v": (n,), "dashpots": (2, len(problem.state.q) - n)},
        **{"efforts": (actuators,), "wrench": (6,), "ports": (actuators,)},
        **{"pushes": live.push.shape, "pushes_follow": live.follows.shape},
        "courses": live.course.shape,
        "attached": (payloads,),
        "bristles": (sum(part.size for part in held_bristles(problem.data)),),
        **{"held": closed.held.shape, "acts": closed.on.shape},
        **{"multipliers": closed.multiplier.shape},
        **dict.fromkeys(("dissipated", "load_work", "actuator_work", "reference"), ()),
    }
    for key, shape in shapes.items():
        _refuse(where, key, getattr(state, key), shape)
    for key in ("pushes_follow", "attached"):
        if not np.isin(getattr(state, key), [0, 1]).all():
            raise StateError(where, key, str(getattr(state, key).tolist()), "0 or 1")
    if not 0 <= state.step_index <= most_steps:
        expected = f"a whole number in [0, {most_steps}]"
        raise StateError(where, "step_index", str(state.step_index), expected)
    _refuse_memory(where, state.solver, problem, 1e-9 * state.step_ns)


def refuse_readings(state: SimulationState, sensing: Sensing | None) -> None:
    """Refuse readings that the sensors of a simulation cannot have made.

    Raises
    ------
    StateError
        which says what is expected
    """
    where = f"state of {state.scene!r}"
    _refuse(where, "sensed", state.sensed, (0 if sensing is None else sensing.size,))
    begin = 0
    for channel in () if sensing is None else sensing.channels.values():
        rows = state.sensed[begin : begin + channel.size].reshape(channel.most, -1)
        begin += channel.size
        steps = rows[rows[:, 0] >= 0.0, 0]
        first = len(steps) and np.all(rows[: len(steps), 0] == steps)
        first = first and np.all(rows[len(steps) :, 0] == -1.0)  # none
        whole = np.all(steps == np.floor(steps)) and np.all(np.diff(steps) > 0.0)
        if not (first and whole and steps[0] >= 0.0 and steps[-1] <= state.step_index):
            expected = f"the steps at which {channel.sensor.name} measured, in their order"
            raise StateError(where, "sensed", str(rows[:, 0].tolist())[:100], expected)


def _refuse_memory(where: str, memory: SolverMemory, problem: Problem, step: float) -> None:
    """Refuse what no solver with steps of ``step`` s can remember."""
    work = problem.work
    shapes = {name: getattr(work, array).shape for name, array in ARRAYS.items()}
    factored = memory.key.shape == shapes["key"] and memory.key[CQ] >= 0.0
    shapes["factors"] = (sum(x.size for x in factors_of(work)) if factored else 0,)
    shapes["couplings"] = getattr(work.system, EXCHANGED).shape
    shapes["time_error"] = ()
    for name, shape in shapes.items():
        _refuse(where, f"solver.{name}", getattr(memory, name), shape)
    begin, length, since = memory.clock[[BEGIN, LENGTH, SINCE]].tolist()
    # the present step of the adaptive method reaches to now, else it would have to be caught up
    behind = begin + length < (since - 1e-6) * step and not memory.restart.any()
    rows = len(memory.couplings)
    allowed = {
        "couplings": (memory.couplings >= 0) & (memory.couplings < rows),
        "better": np.isin(memory.better, [0, 1]),
        "restart": np.isin(memory.restart, [0, 1]),
        "age": np.isin(memory.age[KNOWN], [0, 1, 2, 3]),
        "clock": (memory.clock >= 0.0) & (not behind),
        "counters": memory.counters >= 0,
        "time_error": np.array(memory.time_error >= 0.0),
    }
    for name, fits in allowed.items():
        if not fits.all():
            found = str(np.asarray(getattr(memory, name)).tolist())[:100]
            raise StateError(where, f"solver.{name}", found, "what a solver leaves there")


def _refuse(where: str, key: str, given: Any, shape: tuple[int, ...]) -> None:
    """Refuse an array of another shape, or with something in it that is no number."""
    given = np.asarray(given)
    if given.shape != shape:
        raise StateError(where, key, f"of shape {given.shape}", f"shape {shape}")
    if not np.isfinite(given).all():
        wrong = given[~np.isfinite(given)].flat[0]
        raise StateError(where, key, f"{wrong} somewhere", "finite numbers")
