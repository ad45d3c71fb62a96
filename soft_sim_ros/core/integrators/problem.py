"""All data of a step of a simulation, as one struct passed to kernels by address."""

from typing import Any, NamedTuple

import numpy as np

from soft_sim_ros.core.backend.structs import struct
from soft_sim_ros.core.floats import Floats, Ints
from soft_sim_ros.core.model.model import Data, Live, Loads, Model
from soft_sim_ros.core.recursion.elimination import System, new_system

# What Method.kind may be: the file of the step.
DIRK, ALPHA, ENERGY, ADAPTIVE = 0, 1, 2, 3
# counters
STEPS, EVALUATIONS, FACTORISATIONS, ITERATIONS, REFUSED, REJECTED = 0, 1, 2, 3, 4, 5
# Problem.calls: inverse_dynamics, tangent, solve_stage, uphold, the step of the method, close
RESIDUAL, TANGENT, STAGE, UPHOLD, STEP, CLOSE = 0, 1, 2, 3, 4, 5
# What CLOSE is asked to do (closed.py): for Newton's method, before and after a piece of a step,
# for the end of a trial, for the start of the next step of the adaptive method
FACTOR, CORRECT, BEFORE_PIECE, AFTER_PIECE, AFTER_TRIAL, BEFORE_NEXT = 0, 1, 2, 3, 4, 5
# Work.span
Q0, V0, A0, Q1, V1, A1, QN, VN = 0, 1, 2, 3, 4, 5, 6, 7
# State.ledger
DISSIPATED, LOAD_WORK = 0, 1
# State.account, the rest of what the ledger is made of
KINETIC, ELASTIC, GRAVITY, ACTUATOR_WORK, REFERENCE, BOOKED = 0, 1, 2, 3, 4, 5
# Work.key: ∂q/∂a and ∂v/∂a
CQ, CV = 0, 1
# and, where there is contact, what touched: Touch.pattern
PATTERN = 2
# Work.measure
CORRECTION, TIME_ERROR = 0, 1
# Work.age
KNOWN, SIZE = 0, 1
# Work.memory
NEWEST, SECOND, THIRD = 0, 1, 2
# rows of Work.saved and Work.before
Q, V = 0, 1
# Work.booked: both ends of the present step and that of a trial; after DISSIPATED and LOAD_WORK
# their rates
START, END, TRIAL = 0, 1, 2
LOST, POWER = 2, 3


@struct
class Method(NamedTuple):
    """An integrator: its tableau of s stages, and numbers."""

    kind: int
    order: int
    tableau: Floats  # (s + 1, s + 1) of A | c over b | 0; generalised-α: one stage, unused
    embedded: Floats  # (s,) b − b̂ of an embedded method, adaptive only
    starter: Floats  # (r + 1, r + 1) tableau after a jump, all stages implicit, adaptive only
    starter_embedded: Floats  # (r,)
    rho: float  # generalised-α: spectral radius at infinite frequency
    error: float  # adaptive: largest error of one step, tip displacement in arm lengths
    tolerance: float  # of Newton's method in arm lengths/s; not used if adaptive
    limit: int  # iterations


@struct
class Held(NamedTuple):
    """Gravity, efforts, tip wrench and other inputs that are held, in the base frame."""

    gravity: Floats  # (3,) m/s²
    effort: Floats  # (A,) N·m, N or Pa; m of a tendon whose length is commanded
    tip: Floats  # (6,) moment N·m and force N on the tip
    follows: Ints  # (1,) 1: along the axes of the tip, 0: along those of the base
    live: Live


@struct
class State(NamedTuple):
    """State and the works and losses booked so far."""

    q: Floats  # (n,)
    v: Floats  # (n,)
    ledger: Floats  # (2,) dissipated energy and work of loads, J
    # (6,) energies, work of the actuators, energy that the ledger began with, and work of the
    # actuators up to ``settled``, J
    account: Floats
    settled: Floats  # (A,) port positions up to which actuator work is booked
    position: Floats  # (A,) port positions
    rate: Floats  # (A,) port velocities
    acting: Floats  # (A,) port efforts
    steps: Ints  # (1,) steps of the scene's grid made so far


@struct
class Work(NamedTuple):
    """Scratch of a solver for n coordinates and s stages."""

    system: System  # factors of the Newton matrix
    key: Floats  # (2,) the (CQ, CV) it was made for; CQ < 0: no factors; with contact a PATTERN
    rate: Floats  # (1,) contraction of Newton's method seen with these factors, 1: unknown
    residual: Floats  # (n,)
    zero: Floats  # (n,) zeros, the rates of a state at rest
    momentum: Floats  # (F + 1, 10) of what free joints carry, before a piece of a step; scratch
    start_q: Floats
    start_v: Floats
    q: Floats
    v: Floats
    a: Floats  # (n,) acceleration, carried from step to step
    guesses: Floats  # (2, n) predictors of a, on a line and on a parabola
    better: Ints  # (s,) which of them was nearer last time
    stage_v: Floats  # (s, n)
    stage_a: Floats  # (s, n)
    memory: Floats  # (3, s, n) stage_a of the last three steps, newest first
    # (2,) how many of them are KNOWN, and the step SIZE in s they belong to
    age: Floats
    restart: Ints  # (1,) 1: an input jumped, what is remembered of the past is void
    # (8, n) adaptive: q, q̇, q̈ at both ends of its present step; q, q̇ from which the next starts;
    # generalised-α: accelerations
    span: Floats
    clock: Floats  # (CLOCK,) adaptive: see adaptive.py
    # (3, 4) adaptive: the ledger and its rates, at START, END and that of a TRIAL; generalised-α:
    # [END, POWER]
    booked: Floats
    saved: Floats  # (2, n) Q, V at the start of the step
    before: Floats  # (2, n) Q, V at the start of the piece of the step at hand
    counters: Ints  # (6,)
    measure: Floats  # (2,) last CORRECTION of Newton's method; sum of the errors in time


@struct
class Problem(NamedTuple):
    """Model, method, forcing, state and scratch.

    calls: addresses of inverse_dynamics, tangent, solve_stage, uphold (0: none), the step of the
    method, and close (0: none); kernels that a scene does not call are not compiled.
    """

    model: Model
    loads: Loads
    data: Data
    work: Work
    method: Method
    held: Held
    state: State
    calls: Ints  # (6,) RESIDUAL … CLOSE


CLOCK = 8
NO_FACTORS = -1.0  # Work.key


def new_work(model: Model, stages: int) -> Work:
    """Allocate scratch without memory of earlier steps."""
    n = len(model.weight)
    vectors = ("residual", "zero", "start_q", "start_v", "q", "v", "a")
    work = Work(
        system=new_system(model),
        key=np.zeros(3 if len(model.contact.node) else 2),
        rate=np.zeros(1),
        momentum=np.zeros((len(model.free) + 1, 10)),
        guesses=np.zeros((2, n)),
        better=np.zeros(stages, dtype=np.int64),
        stage_v=np.zeros((stages, n)),
        stage_a=np.zeros((stages, n)),
        memory=np.zeros((3, stages, n)),
        age=np.zeros(2),
        restart=np.ones(1, dtype=np.int64),
        span=np.zeros((8, n)),
        clock=np.zeros(CLOCK),
        booked=np.zeros((3, 4)),
        saved=np.zeros((2, n)),
        before=np.zeros((2, n)),
        counters=np.zeros(6, dtype=np.int64),
        measure=np.zeros(2),
        **{name: np.zeros(n) for name in vectors},
    )
    forget(work)
    return work


def forget(work: Work) -> None:
    """Clear the solver's memory (factors, guesses), so the future depends on the state only."""
    kept: Any = ("system", "counters")
    for name, array in work._asdict().items():
        if name not in kept:
            array[...] = 0
    work.key[:] = NO_FACTORS
    work.rate[:] = 1.0
    work.restart[:] = 1


def new_state(model: Model) -> State:
    """Allocate a state at rest in the reference shape."""
    n, actuators = len(model.weight), len(model.port_ptr) - 1
    return State(
        q=np.zeros(n),
        v=np.zeros(n),
        ledger=np.zeros(2),
        account=np.zeros(6),
        settled=np.zeros(actuators),
        position=np.zeros(actuators),
        rate=np.zeros(actuators),
        acting=np.zeros(actuators),
        steps=np.zeros(1, dtype=np.int64),
    )
