"""The motion of a simulation at the end of a step, as its sensors see it."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.compile.samples import Place, samples_at
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.integrators.adaptive import BEGIN, FIRST, LENGTH, SINCE
from soft_sim_ros.core.integrators.problem import (
    A0,
    A1,
    ADAPTIVE,
    ALPHA,
    DIRK,
    Q0,
    Q1,
    V0,
    V1,
    Problem,
)
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.gauges import Gauge
from soft_sim_ros.core.mechanics.instant import Instant
from soft_sim_ros.core.recursion.motions import WIDTH, sample_motions
from soft_sim_ros.core.recursion.rnea import place

from .held import Holding

BEFORE = 2e-9  # of a step: loads that switch at its end are those before it


class Seen:
    """What sensors that feel accelerations and wrenches see.

    Parameters
    ----------
    compiled : the arm
    gauges : those that are in a frame are told which of ``Instant.motions`` is theirs
    """

    def __init__(self, compiled: Compiled, gauges: list[Gauge]) -> None:
        # scratch of its own: nothing else notices
        moving = any(gauge.moving for gauge in gauges)
        self._dynamics = Dynamics(compiled) if moving else None
        places: list[Place] = []
        for gauge in gauges:
            if gauge.place is not None:
                gauge.row = len(places)
                places.append(gauge.place)
        self._samples = samples_at(places)
        self._motions = np.zeros((len(places), WIDTH))

    def instant(self, arm: Holding, problem: Problem, made: bool) -> Instant:
        """Return the motion of a simulation now.

        Accelerations are those with which the last step ended, where the method has them. Where it
        has not, and before the first step, they are those of the equations of motion.

        Parameters
        ----------
        made : whether a step has just been made
        """
        dynamics, n = self._dynamics, arm.n_coordinates
        base, there = arm.compiled.base, arm.dynamics.attached
        if dynamics is None:  # no sensor asks for more than coordinates
            return Instant(arm.q, arm.v, None, self._motions, arm.time, base, there, None)
        dynamics.carry(there)
        step = arm.step_ns * 1e-9
        now = arm.step_index * arm.step_ns * 1e-9
        if made:
            now -= max(BEFORE * step, 2e-15 * abs(now))
        efforts, wrench, follows = arm.held()
        data = dynamics.forcing(efforts, now, 1.0, wrench, follows, arm.live())
        if len(data.touch.bristle):
            data.touch.bristle[:] = problem.data.touch.bristle
        closed, own = problem.data.closed, data.closed
        own.held[:] = closed.held
        a = solved(problem, n, step) if made else None
        if a is None:
            pulled = dashpots(dynamics, arm, problem)
            a = dynamics.accelerations(arm.q, arm.v, data, now, pulled)
        else:
            own.on[:], own.multiplier[:] = closed.on, closed.multiplier
            a[dynamics.model.driven[:, 0]] = data.driven[:, 2]
        dynamics.residual(arm.q, arm.v, a, data)
        place(dynamics.model, data)
        if len(self._motions):
            sample_motions(data, self._samples, arm.q, arm.v, a, self._motions)
        return Instant(arm.q, arm.v, data, self._motions, now, base, there, None)


def dashpots(dynamics: Dynamics, arm: Holding, problem: Problem) -> Floats | None:
    """Return the force (n,) of Maxwell branches; None without any."""
    if not len(arm.compiled.model.branch):
        return None
    return np.asarray(dynamics.branch_matrix() @ (arm.q - problem.state.q[arm.n_coordinates :]))


def solved(problem: Problem, n: int, step: float) -> Floats | None:
    """Return the accelerations (n,) at the end of the last step of ``step`` s, if it has any.

    Those of a chart that was left at the end of the step are none.
    """
    work, method = problem.work, problem.method
    if method.kind == ADAPTIVE:
        closed = len(problem.model.closures.node) > 0
        return None if closed else interpolated(problem, n, step)
    last = method.tableau.shape[0] - 2
    at_end = method.kind == ALPHA or (method.kind == DIRK and method.tableau[last, last + 1] == 1.0)
    return work.a[:n].copy() if at_end and work.restart[0] == 0 else None


def interpolated(problem: Problem, n: int, step: float) -> Floats:
    """Return the second derivative (n,) of the polynomial of the adaptive method's present step.

    It is that of ``integrators/adaptive.py``, ``interpolate``.
    """
    clock, span = problem.work.clock, problem.work.span
    h = clock[LENGTH]
    x = (clock[SINCE] * step - clock[BEGIN]) / h
    q, v, a = span[[Q0, V0, A0], :n]
    way, speed, end = span[Q1, :n] - q - h * v, h * (span[V1, :n] - v), h * h * span[A1, :n]
    if clock[FIRST] != 0.0:
        c2, c3 = 6.0 * way - 3.0 * speed + 0.5 * end, 5.0 * speed - 8.0 * way - end
        c4, c5 = 0.5 * end - 2.0 * speed + 3.0 * way, np.zeros(n)
    else:
        c2 = 0.5 * h * h * a
        way, speed, end = way - c2, speed - 2.0 * c2, end - 2.0 * c2
        c3 = 10.0 * way - 4.0 * speed + 0.5 * end
        c4 = -15.0 * way + 7.0 * speed - end
        c5 = 6.0 * way - 3.0 * speed + 0.5 * end
    curve = 2.0 * c2 + 6.0 * c3 * x + 12.0 * c4 * x**2 + 20.0 * c5 * x**3
    return np.asarray(curve / h**2)
