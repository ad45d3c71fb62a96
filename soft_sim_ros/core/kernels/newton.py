"""Newton's method for one implicit stage, and the scratch that steps share."""

import math
from typing import NamedTuple

import numpy as np

from ..model import Data, Floats, Ints, Model
from .fibres import lawful
from .jit import address, bare, call_residual, call_tangent, unit
from .maxwell import branch_forces, branch_tangent, relax
from .momentum import uphold
from .sweep import inverse_dynamics
from .system import System, factor, new_system, solve
from .tangent import tangent

CONVERGED, TOO_MANY, NOT_FINITE, SINGULAR, UNRESOLVED, INVERTED, TOO_FAR = 0, 1, 2, 3, 4, 5, 6
LAWLESS = 7
# In words, for errors.
REASONS = {
    1: "Newton's method does not converge, even with 1/4096 of the step",
    2: "the state is not finite",
    3: "the Newton matrix is singular",
    4: "a rod bends or twists by more than half a turn within one segment (more elements or nodes "
    "resolve it, if it is meant)",
    5: "a rod is compressed to nothing",
    6: "the tip moves by more than an arm length (or a hinge by a radian) in a fraction of a step",
    7: "a fibre is stretched or compressed beyond where the law of its material holds",
}
# A contraction slower than this is worth new factors.
SLOW = 0.2
# counters
STEPS, EVALUATIONS, FACTORISATIONS, ITERATIONS, REFUSED = 0, 1, 2, 3, 4


class Work(NamedTuple):
    """Scratch of a solver for n coordinates and s stages."""

    system: System  # factors of the Newton matrix
    key: Floats  # (2,) the (cq, cv) it was made for
    residual: Floats  # (n,)
    zero: Floats  # (n,) zeros, the rates of a state at rest
    momentum: Floats  # (2, 10) of a free body, before and after a piece of a step
    start_q: Floats
    start_v: Floats
    q: Floats
    v: Floats
    stage_v: Floats  # (s, n)
    stage_a: Floats  # (s, n)
    a: Floats  # (n,) acceleration, carried from step to step as a predictor
    memory: Floats  # (2, n) accelerations a method remembers, to predict the next
    # (1,) size in s of the step they are from; generalised-α: power in W of loads at its end
    last: Floats
    restart: Ints  # (1,) 1: the memory is void, because an input jumped
    saved: Floats  # (3, n) q, v, a at the start of the step
    before: Floats  # (2, n) q, v at the start of the piece of the step at hand
    counters: Ints  # (5,)
    measure: Floats  # (2,) last Newton measure, largest residual of the last step


def new_work(model: Model, stages: int) -> Work:
    """Allocate zeroed scratch."""
    n = len(model.weight)
    return Work(
        system=new_system(model),
        key=np.array([-1.0, -1.0]),
        residual=np.zeros(n),
        zero=np.zeros(n),
        momentum=np.zeros((2, 10)),
        start_q=np.zeros(n),
        start_v=np.zeros(n),
        q=np.zeros(n),
        v=np.zeros(n),
        stage_v=np.zeros((stages, n)),
        stage_a=np.zeros((stages, n)),
        a=np.zeros(n),
        memory=np.zeros((2, n)),
        last=np.ones(1),
        restart=np.ones(1, dtype=np.int64),
        saved=np.zeros((3, n)),
        before=np.zeros((2, n)),
        counters=np.zeros(5, dtype=np.int64),
        measure=np.zeros(2),
    )


@unit
def admissible(model, data):
    """Return CONVERGED if the rods of the last sweep are rods still, else what is wrong with them.

    Beyond half a turn within one segment the Magnus step means nothing, and at a stretch of zero
    the rod is crushed: equilibria and motions there solve the equations, but no physics.
    """
    model, data = bare(model), bare(data)
    for k in range(len(model.half)):
        if model.kappa[k] == 0.0:
            continue
        wx, wy, wz = data.omega[k, 0, 0], data.omega[k, 0, 1], data.omega[k, 0, 2]
        if not wx * wx + wy * wy + wz * wz < math.pi**2:
            return UNRESOLVED
        if not (data.xi[k, 0, 0, 3] > 0.0 and data.xi[k, 1, 0, 3] > 0.0):
            return INVERTED
    return CONVERGED if lawful(model.fibres, data.section) else LAWLESS


@unit
def solve_stage(calls, model, data, work, cq, cv, tolerance, limit):
    """Find work.a with r(q, v, a) = 0 at q = start_q + cq a, v = start_v + cv a.

    The measure of convergence is the largest correction of a velocity, each coordinate weighed by
    how far it moves the tip, in arm lengths per second. Factors are kept, across steps too, while
    they contract well. calls: addresses of inverse_dynamics, tangent and this function.
    """
    model, data, work = bare(model), bare(data), bare(work)
    n = len(work.a)
    stale = work.key[0] != cq or work.key[1] != cv
    before = 0.0
    refreshed = -1
    for iteration in range(limit):
        for i in range(n):
            work.q[i] = work.start_q[i] + cq * work.a[i]
            work.v[i] = work.start_v[i] + cv * work.a[i]
        relax(model, work, cq, cv)
        call_residual(calls[0], model, data, work.q, work.v, work.a, work.residual)
        branch_forces(model, work.v, work.residual)
        work.counters[EVALUATIONS] += 1
        if stale:
            call_tangent(calls[1], model, data, (cq, cv, 1.0), work.system)
            branch_tangent(model, cq, cv, work.system)
            work.counters[FACTORISATIONS] += 1
            work.key[0], work.key[1] = cq, cv
            if not factor(model, work.system):
                work.key[0] = -1.0
                return SINGULAR
            stale = False
            refreshed = iteration
        solve(model, work.system, work.residual)
        size = 0.0
        for i in range(n):
            work.a[i] -= work.residual[i]
            change = abs(work.residual[i]) * model.weight[i]
            if not change <= size:  # so that NaN gets through
                size = change
        size *= cv
        work.counters[ITERATIONS] += 1
        work.measure[0] = size
        if not math.isfinite(size):
            work.key[0] = -1.0
            return NOT_FINITE
        # what is left after this correction, if it goes on contracting like this
        if iteration == 0:
            left = size
            rate = 0.0
        else:
            rate = size / before if before > 0.0 else 0.0
            left = size * rate / (1.0 - rate) if rate < 1.0 else math.inf
        if left <= tolerance:
            for i in range(n):
                work.q[i] = work.start_q[i] + cq * work.a[i]
                work.v[i] = work.start_v[i] + cv * work.a[i]
            relax(model, work, cq, cv)
            return admissible(model, data)
        if iteration > 0 and rate > SLOW:
            if refreshed >= 0 and iteration > refreshed + 2 and rate > 2.0:
                break  # exact factors, and still moving away
            stale = True
        before = size
    work.key[0] = -1.0
    return TOO_MANY


def addresses(model: Model, data: Data, work: Work) -> tuple[int, int, int, int]:
    """Return the addresses of inverse_dynamics, tangent, solve_stage and uphold (0: not needed)."""
    state = (work.q, work.v, work.a, work.residual)
    first = address(inverse_dynamics, model, data, *state)
    second = address(tangent, model, data, (1.0, 1.0, 1.0), work.system)
    calls = (first, second, 0, 0)
    third = address(solve_stage, calls, model, data, work, 1.0, 1.0, 1.0, 1)
    # a free base has a chart too; a scene without either does without this kernel
    fourth = address(uphold, model, data, work, 1.0, *state[:2]) if len(model.chart) else 0
    return first, second, third, fourth
