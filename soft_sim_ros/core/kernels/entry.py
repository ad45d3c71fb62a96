"""The way from Python into the kernels of a simulation: a few numbers, one address."""

from __future__ import annotations

from ..model import Floats
from .account import hold, take_stock
from .adaptive import adaptive_step
from .advance import advance
from .alpha import alpha_step
from .conservative import conservative_step
from .dirk import dirk_step
from .jit import Call, address, call_account, call_advance, call_hold, unit
from .memory import Packed
from .newton import called
from .problem import ADAPTIVE, ALPHA, DIRK, ENERGY, Problem
from .together import compile_together

STEPS = {
    DIRK: dirk_step,
    ALPHA: alpha_step,
    ENERGY: conservative_step,
    ADAPTIVE: adaptive_step,
}


@unit
def _advance(function, problem, start_ns, step_ns, steps):
    return call_advance(function, problem, start_ns, step_ns, steps)


@unit
def _take_stock(function, problem):
    call_account(function, problem)


@unit
def _hold(function, problem, efforts):
    return call_hold(function, problem, efforts)


class Entry:
    """The kernels of one problem, whose arrays are known by address and may not be exchanged.

    besides: calls that will be made, to be compiled together with those of the problem.
    """

    def __init__(self, problem: Problem, besides: list[Call]) -> None:
        self._packed = Packed(problem)
        self._problem = self._packed.address
        calls = [*called(problem), (STEPS[problem.method.kind], problem, 1.0, 1.0)]
        own: list[Call] = [(advance, problem, 1, 1, 1), (take_stock, problem)]
        own += [(hold, problem, problem.held.effort)]
        compile_together([*calls, *own, *besides])
        problem.calls[:] = [address(*call) if call else 0 for call in calls]
        self._advance = address(advance, problem, 1, 1, 1)
        self._take_stock = address(take_stock, problem)
        self._hold = address(hold, problem, problem.held.effort)

    def advance(self, start_ns: int, step_ns: int, steps: int) -> tuple[int, int]:
        """Make up to ``steps`` steps; return how many were made and newton.REASONS' key, or 0."""
        made, status = _advance(self._advance, self._problem, start_ns, step_ns, steps)
        return int(made), int(status)

    def take_stock(self) -> None:
        """Bring the energies and works of the State up to date."""
        _take_stock(self._take_stock, self._problem)

    def hold(self, efforts: Floats) -> bool:
        """Hold efforts (A,), writable C-contiguous float64; return False if they are not finite."""
        return bool(_hold(self._hold, self._problem, efforts))
