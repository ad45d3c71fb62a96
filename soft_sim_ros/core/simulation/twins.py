"""Copies and pickles of a Simulation."""

from __future__ import annotations

from typing import Any

import numpy as np

from soft_sim_ros.core.backend.copying import arrays_of, pour, take_rest
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.mechanics.dynamics import Dynamics


class Twins:
    """Makes copies of a Simulation independent simulations in the same state.

    Shallow ones, deep ones and those unpickled; the solver's memory and the ledger are in the
    state, so they go on with the same bits. Scene and model are immutable, and shared but by
    pickles.
    """

    compiled: Compiled
    _prune: bool
    _start: tuple[np.ndarray, np.ndarray]
    _own: frozenset[str]  # attributes of a Simulation by itself

    def _build(self, dynamics: Dynamics, prune: bool) -> None:
        raise NotImplementedError

    @property
    def _moving(self) -> tuple[Any, ...]:
        raise NotImplementedError

    def __copy__(self) -> Any:
        return self._twin(None)

    def __deepcopy__(self, memo: dict[int, Any]) -> Any:
        return self._twin(memo)

    def _twin(self, memo: dict[int, Any] | None) -> Any:
        new = object.__new__(type(self))
        if memo is not None:
            memo[id(self)] = new
        new._restore(self.compiled, self._prune, self._start, list(arrays_of(self._moving)))
        take_rest(new, self, memo)
        return new

    def _restore(
        self,
        compiled: Compiled,
        prune: bool,
        start: tuple[np.ndarray, np.ndarray],
        content: list[np.ndarray],
    ) -> None:
        self._build(Dynamics(compiled), prune)
        self._start = start
        pour("a Simulation", content, self._moving)

    def __getstate__(self) -> tuple[Any, ...]:
        rest = {name: value for name, value in vars(self).items() if name not in self._own}
        return self.compiled, self._prune, self._start, list(arrays_of(self._moving)), rest

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        *parts, rest = state
        self._restore(*parts)
        vars(self).update(rest)
