"""Static equilibrium: the one on the load path from nothing to the full load."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.closing import Closing
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.history import refuse_constraints
from soft_sim_ros.core.refine.space_error import Forcing, tell_if_coarse
from soft_sim_ros.errors import StaticsFailed, UndampedFlutter

from .load_steps import Question, unresolved, walk
from .relaxation import sink
from .stability import unstable_directions

__all__ = ["equilibrium", "unstable_directions"]


def equilibrium(
    dynamics: Dynamics,
    q: Floats | None = None,
    *,
    efforts: Floats | None = None,
    time: float = 0.0,
    tip: Floats | None = None,
    tip_follows: bool = False,
    tolerance: float = 1e-12,
    iterations: int = 25,
    free: np.ndarray | None = None,
    stable: bool = True,
    thorough: bool = True,
    check: bool | None = None,
) -> Floats:
    """Return q (n,) with r(q, 0, 0) = 0.

    Driven joints move as they are told at ``time``, all others not: an arm on a table that turns,
    or on a carriage that accelerates, is at rest relative to it.

    Parameters
    ----------
    dynamics : the arm
    q : (n,) start; the reference shape by default
    efforts : (A,) actuator efforts in scene order
    time : s at which scheduled loads are taken
    tip : (6,) moment and force at the tip along world axes, or (``tip_follows``) those of the tip
    tolerance : largest last correction, as a displacement of the tip in arm lengths
    iterations : Newton steps allowed for one load step
    free : (n,) bool, coordinates to be found; the others keep their start value
    stable : whether only stable equilibria will do
    thorough : whether a load path that ends is looked at again, by arc length and with finer
        numerics; that takes some times as long as all the rest
    check : whether to ask a finer basis how far off the tip is, and to warn; by default, where the
        scene's author wrote no basis. It costs about as much as the solution, and once per arm the
        compilation of a finer one: False for loops

    Raises
    ------
    StaticsFailed
        if the load path cannot be followed to the full load; it says why, and what helps.

    Warns
    -----
    NotResolved
        if basis and nodes are too coarse for this state (``check``, space_error.py)
    UndampedFlutter
        if small swings about the equilibrium grow and the scene has no damping that could decide
        whether they would in an arm that has some (``stable``).

    Notes
    -----
    Weight, loads and efforts grow together from zero to their full size along the path of
    equilibria that starts at q, so of several equilibria the one on the load path is found. A limit
    point ends it, and so does (``stable``) the loss of stability, as in buckling or flutter: it is
    looked for after every load step, up to WATCHED coordinates (stability.py). ``thorough``, the
    path is then followed by arc length, and if it comes to a stable equilibrium under the full load
    beyond all limit points, that is the answer. An arm with a string or a cable in it has no such
    path, since only its load holds it: it sinks into a stable equilibrium under the full load
    (relaxation.py).
    """
    n = dynamics.n
    state = np.zeros(n) if q is None else dynamics.coordinates(q).copy()
    mask: NDArray[np.bool_] = np.ones(n, dtype=bool) if free is None else np.asarray(free)
    if mask.shape != (n,) or mask.dtype != bool:
        raise ValueError(f"free must be {n} truth values, not {free!r}")
    if not dynamics.free.all():
        mask = mask & dynamics.free
        state = np.where(dynamics.free, state, dynamics.guided(time)[0])
    if not mask.any():
        return state
    question = Question(
        dynamics, mask, efforts, time, tip, tip_follows, tolerance, iterations, stable
    )
    start = state
    limp = any(m.pivot for m in dynamics.compiled.chain.rods.values())
    if limp:
        refuse_constraints(dynamics.compiled.scene, "an equilibrium with a string or a cable")
        start = sink(dynamics, state, mask, question.forcing(1.0), time)
    closing = None
    if len(dynamics.constraints) and dynamics.constraints.acting(time).any():
        closing = Closing(dynamics, start, time)
        question = replace(question, closing=closing)
    try:
        end = walk(question, start)
    finally:
        if closing is not None:
            closing.at(1.0)
    if not end.whole and thorough and not limp and question.closing is None:
        from .second_look import look_again  # which compiles finer models

        end = look_again(question, state, end)
    if not end.whole:
        why = end.why + unresolved(dynamics, end.q)
        raise StaticsFailed(end.share, end.size, time, why)
    if end.verdict is not None and end.verdict.unstable:
        flutter = UndampedFlutter(end.verdict.growth, end.verdict.hertz)
        warnings.warn(flutter, stacklevel=2)
    if check or (check is None and not dynamics.compiled.scene.numerics.space_written):
        tell_if_coarse(dynamics, end.q, Forcing(efforts, time, 1.0, tip, tip_follows), mask)
    return end.q
