"""The way from Python into the kernels of a simulation: a few numbers, one address."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, NoReturn

from soft_sim_ros.core.backend.jit import (
    Call,
    address,
    call_account,
    call_advance,
    call_hold,
    signature_of,
    unit,
)
from soft_sim_ros.core.backend.structs import Packed
from soft_sim_ros.core.backend.together import compile_together
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import NotCopied

from .adaptive import adaptive_step
from .advance import advance
from .alpha import alpha_step
from .closed import close
from .conservative import conservative_step
from .dirk import dirk_step
from .ledger import hold, take_stock
from .newton import called
from .problem import ADAPTIVE, ALPHA, DIRK, ENERGY, Problem

STEPS = {
    DIRK: dirk_step,
    ALPHA: alpha_step,
    ENERGY: conservative_step,
    ADAPTIVE: adaptive_step,
}


@unit
def _advance(function, problem, step_ns, steps, most):
    return call_advance(function, problem, step_ns, steps, most)


@unit
def _take_stock(function, problem):
    call_account(function, problem)


@unit
def _hold(function, problem, efforts):
    return call_hold(function, problem, efforts)


class _Addresses(NamedTuple):
    """Where the machine code of the units of a problem is."""

    calls: tuple[int, ...]  # Problem.calls
    own: tuple[int, int, int]  # advance, take_stock, hold


_found: dict[Any, _Addresses] = {}


def _compiled(problem: Problem, calls: list[Call], besides: list[Call]) -> _Addresses:
    own: list[tuple[Any, ...]] = [(advance, problem, 1, 1, 1), (take_stock, problem)]
    own.append((hold, problem, problem.held.effort))
    compile_together([*calls, *own, *besides])
    one, two, three = (address(*call) for call in own)
    return _Addresses(tuple(address(*call) if call else 0 for call in calls), (one, two, three))


class Entry:
    """The kernels of one problem, whose arrays are known by address and may not be exchanged.

    besides: calls that will be made, to be compiled together with those of the problem; shared:
    parts of the problem that are packed already.
    """

    def __init__(
        self, problem: Problem, besides: list[Call], shared: Sequence[Packed] = ()
    ) -> None:
        (kind,) = signature_of([problem])
        self._packed = Packed(problem, kind, shared)
        self._problem = self._packed.address
        calls = [*called(problem), (STEPS[problem.method.kind], problem, 1.0, 1.0)]
        closed = len(problem.model.closures.node) > 0
        calls.append((close, problem, 0, 1.0, 1.0) if closed else None)
        # arrays of other lengths and content are no reason to look for kernels again
        key = kind, problem.method.kind, tuple(call is None for call in calls)
        found = _found.get(key)
        if found is None:
            found = _found[key] = _compiled(problem, calls, besides)
        problem.calls[:] = found.calls
        self._advance, self._take_stock, self._hold = found.own

    def __reduce_ex__(self, protocol: object) -> NoReturn:
        """Refuse to be copied or pickled: addresses would be those of the original's arrays."""
        raise NotCopied("the entry into kernels", "it holds addresses; copy its Simulation")

    def advance(self, step_ns: int, steps: int, most: int) -> int:
        """Make up to ``steps`` steps (advance.py); return newton.REASONS' key, or 0."""
        return int(_advance(self._advance, self._problem, step_ns, steps, most))

    def take_stock(self) -> None:
        """Bring the energies and works of the State up to date."""
        _take_stock(self._take_stock, self._problem)

    def hold(self, efforts: Floats) -> bool:
        """Hold efforts (A,), writable C-contiguous float64; return False if they are not finite."""
        return bool(_hold(self._hold, self._problem, efforts))
