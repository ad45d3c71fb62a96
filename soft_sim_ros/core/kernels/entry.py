"""The way from Python into the kernels of a simulation: a few numbers, one address."""

from __future__ import annotations

from .account import take_stock
from .adaptive import adaptive_step
from .advance import advance
from .alpha import alpha_step
from .conservative import conservative_step
from .dirk import dirk_step
from .jit import address, call_account, call_advance, unit
from .memory import pack, pointer_to
from .newton import addresses
from .problem import ADAPTIVE, ALPHA, DIRK, ENERGY, Problem

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


class Entry:
    """The kernels of one problem, whose arrays are known by address and may not be exchanged."""

    def __init__(self, problem: Problem) -> None:
        self._kept = problem
        self._packed = pack(problem)
        self._problem = int(self._packed.ctypes.data)
        pointer = pointer_to(problem)
        step = address(STEPS[problem.method.kind], pointer, 1.0, 1.0)
        problem.calls[:] = (*addresses(problem), step)
        self._advance = address(advance, pointer, 1, 1, 1)
        self._take_stock = address(take_stock, pointer)

    def advance(self, start_ns: int, step_ns: int, steps: int) -> tuple[int, int]:
        """Make up to ``steps`` steps; return how many were made and newton.REASONS' key, or 0."""
        made, status = _advance(self._advance, self._problem, start_ns, step_ns, steps)
        return int(made), int(status)

    def take_stock(self) -> None:
        """Bring the energies and works of the State up to date."""
        _take_stock(self._take_stock, self._problem)
