"""Copies and pickles of a Simulation."""

from __future__ import annotations

from typing import Any

from soft_sim_ros.core.backend.copying import take_rest
from soft_sim_ros.core.compile.scene import Compiled

from .state import SimulationState
from .stepper import Stepper


class Twins(Stepper):
    """What makes copies of a Simulation simulations of their own in the same state.

    Shallow ones, deep ones and those unpickled: each is built anew of the compiled scene, which
    never changes and is shared but by pickles, and gets the state of the original.
    """

    _start: SimulationState
    _own: frozenset[str]  # attributes of a Simulation by itself

    def _build(self, compiled: Compiled, prune: bool) -> None:
        """Make everything but the state."""
        raise NotImplementedError

    def __copy__(self) -> Any:
        return self._twin(None)

    def __deepcopy__(self, memo: dict[int, Any]) -> Any:
        return self._twin(memo)

    def _twin(self, memo: dict[int, Any] | None) -> Any:
        new = object.__new__(type(self))
        if memo is not None:
            memo[id(self)] = new
        new._build(self.compiled, self._prune)
        new._start = self._start
        new._put(self.state())
        take_rest(new, self, memo)
        return new

    def __getstate__(self) -> tuple[Any, ...]:
        rest = {name: value for name, value in vars(self).items() if name not in self._own}
        return self.compiled, self._prune, self._start, self.state(), rest

    def __setstate__(self, pickled: tuple[Any, ...]) -> None:
        compiled, prune, self._start, state, rest = pickled
        self._build(compiled, prune)
        self.restore(state)
        vars(self).update(rest)
