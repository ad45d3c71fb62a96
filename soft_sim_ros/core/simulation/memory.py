"""What a solver remembers of the steps behind it, as a value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.core.floats import Floats, Ints
from soft_sim_ros.core.integrators.problem import CQ, TIME_ERROR, Work

from .value import Value

# of System: what is no factor but scratch, and rows that were exchanged
NO_FACTOR, EXCHANGED = ("scratch", "vectors", "small_x"), "small_pivot"
# of Work: what is written in a step before it is read, and so decides nothing after it
SCRATCH = (
    *("residual", "momentum", "start_q", "start_v", "q", "v", "guesses"),
    *("stage_v", "stage_a", "saved", "before"),
)
# part of the memory → array of Work
ARRAYS = {
    "key": "key",
    "contraction": "rate",
    "acceleration": "a",
    "stages": "memory",
    "better": "better",
    "age": "age",
    "restart": "restart",
    "span": "span",
    "clock": "clock",
    "booked": "booked",
    "counters": "counters",
}


@dataclass(frozen=True, eq=False)
class SolverMemory(Value):
    """What a solver remembers of the steps behind it: without it the next steps have other bits.

    Sizes: N numbers are stepped, the n coordinates and, with Maxwell branches, as many of their
    dashpots; a step has s stages.

    Attributes
    ----------
    key : (2,) factors of q̈ in q and q̇ that the Newton matrix was factored for; < 0: no factors
    contraction : (1,) of Newton's method with these factors
    factors : (F,) the factors, one array after the other; (0,) if there are none
    couplings : (R,) rows that were exchanged in the factors of what ties blocks together
    acceleration : (N,) of the last stage, rad/s² or the like
    stages : (3, s, N) accelerations of the stages of the last three steps, newest first
    better : (s,) which guess of a stage was the nearer one: 0 on a line, 1 on a parabola
    age : (2,) how many of these steps are known, and their size in s
    restart : (1,) 1 if an input jumped, so that the next step begins anew
    span : (8, N) ends of the present step of the adaptive method; carried accelerations of the
        generalised-α method
    clock : (8,) times of the adaptive method in s, see integrators/adaptive.py
    booked : (3, 4) work of damping and loads in J, and power in W, at the ends of that step
    time_error : sum of the errors of all steps in arm lengths, adaptive method only
    counters : (6,) counters of `Statistics`
    """

    key: Floats
    contraction: Floats
    factors: Floats
    couplings: Ints
    acceleration: Floats
    stages: Floats
    better: Ints
    age: Floats
    restart: Ints
    span: Floats
    clock: Floats
    booked: Floats
    time_error: float
    counters: Ints

    @classmethod
    def of(cls, work: Work) -> SolverMemory:
        """Return what a solver remembers now."""
        factors = factors_of(work) if work.key[CQ] >= 0.0 else []
        return cls(
            factors=np.concatenate([np.zeros(0), *(array.ravel() for array in factors)]),
            couplings=getattr(work.system, EXCHANGED),
            time_error=float(work.measure[TIME_ERROR]),
            **{name: getattr(work, array) for name, array in ARRAYS.items()},
        )

    def recall(self, work: Work) -> None:
        """Let a solver remember this, and nothing else that matters."""
        begin = 0
        for array in factors_of(work) if len(self.factors) else []:
            array[...] = self.factors[begin : begin + array.size].reshape(array.shape)
            begin += array.size
        getattr(work.system, EXCHANGED)[:] = self.couplings
        work.measure[TIME_ERROR] = self.time_error
        for name, field in ARRAYS.items():
            getattr(work, field)[...] = getattr(self, name)


def factors_of(work: Work) -> list[Floats]:
    """Return the arrays that factors of the Newton matrix are in."""
    return [
        array
        for name, array in work.system._asdict().items()
        if array.dtype.kind == "f" and name not in NO_FACTOR
    ]
