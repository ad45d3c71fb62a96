"""What a solver remembers of the steps behind it, as a value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from soft_sim_ros.core.floats import Floats, Ints
from soft_sim_ros.core.integrators.adaptive import BEGIN, LENGTH, SINCE
from soft_sim_ros.core.integrators.problem import CQ, KNOWN, TIME_ERROR, Work
from soft_sim_ros.core.recursion.elimination import System
from soft_sim_ros.errors import StateError

from .value import Value

# of System: what is no factor but scratch, and rows that were exchanged
SCRATCH, EXCHANGED = ("scratch", "vectors", "small_x"), "small_pivot"
# part of the memory → array of Work
_ARRAYS = {
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
        factored = work.key[CQ] >= 0.0
        none: Floats = np.zeros(0)
        return cls(
            factors=np.concatenate(
                [x.ravel() for x in _factors(work.system)] if factored else none
            ),
            couplings=getattr(work.system, EXCHANGED),
            time_error=float(work.measure[TIME_ERROR]),
            **{name: getattr(work, array) for name, array in _ARRAYS.items()},
        )

    def recall(self, work: Work) -> None:
        """Let a solver remember this, and nothing else that matters."""
        begin = 0
        for array in _factors(work.system) if len(self.factors) else []:
            array[...] = self.factors[begin : begin + array.size].reshape(array.shape)
            begin += array.size
        getattr(work.system, EXCHANGED)[:] = self.couplings
        work.measure[TIME_ERROR] = self.time_error
        for name, field in _ARRAYS.items():
            getattr(work, field)[...] = getattr(self, name)

    def check(self, work: Work, step: float, where: object) -> None:
        """Refuse what no solver of this kind with steps of ``step`` s can remember.

        Raises
        ------
        StateError
        """
        sizes = {name: getattr(work, array).shape for name, array in _ARRAYS.items()}
        whole = sum(array.size for array in _factors(work.system))
        sizes["factors"] = (whole if self.key.shape == (2,) and self.key[CQ] >= 0.0 else 0,)
        sizes["couplings"] = getattr(work.system, EXCHANGED).shape
        for name, shape in sizes.items():
            refuse_unfit(where, f"solver.{name}", getattr(self, name), shape)
        begin, length, since = self.clock[[BEGIN, LENGTH, SINCE]]
        behind = begin + length < (since - 1e-6) * step and not self.restart[0]
        allowed = {
            "couplings": (self.couplings >= 0) & (self.couplings < len(self.couplings)),
            "better": (self.better == 0) | (self.better == 1),
            "restart": (self.restart == 0) | (self.restart == 1),
            "age": np.isin(self.age[KNOWN], [0.0, 1.0, 2.0, 3.0]),
            "clock": np.array((self.clock >= 0.0).all() and not behind),
            "counters": self.counters >= 0,
            "time_error": np.array(0.0 <= self.time_error < np.inf),
        }
        for name, fits in allowed.items():
            if not fits.all():
                found = str(getattr(self, name).tolist() if name != "time_error" else "no number")
                raise StateError(where, f"solver.{name}", found[:100], "what a solver writes there")


def _factors(system: System) -> list[Floats]:
    """Return the arrays that factors of the Newton matrix are in."""
    return [
        array
        for name, array in system._asdict().items()
        if array.dtype.kind == "f" and name not in SCRATCH
    ]


def refuse_unfit(where: object, key: str, given: Any, shape: tuple[int, ...]) -> None:
    """Refuse an array of another shape, or with something in it that is no number."""
    if given.shape != shape:
        raise StateError(where, key, f"of shape {given.shape}", f"shape {shape}")
    if not np.isfinite(given).all():
        wrong = given[~np.isfinite(given)][0]
        raise StateError(where, key, f"{wrong} somewhere", "finite numbers")
