"""Frames along a moving arm."""

from __future__ import annotations

import copy
from typing import Any, Protocol

import numpy as np

from soft_sim_ros.core.arguments import real
from soft_sim_ros.core.compile.samples import sample_frames
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import new_data
from soft_sim_ros.core.recursion.output import sample_poses
from soft_sim_ros.errors import BadArgument

ROUNDING = 1e-9  # of the length


class Moving(Protocol):
    """A simulation, or anything else with coordinates."""

    @property
    def q(self) -> Floats:
        """Coordinates (n,), read at every call."""


class Sampler:
    """Frames at fixed arc lengths ``s`` (N,) in m; quaternions keep their sign from call to call.

    Parameters
    ----------
    compiled : Compiled
    q : (n,) the coordinates to look at, contiguous doubles, read anew at every call
    s : (N,) arc lengths in m along all rods, base to tip
    of : the simulation whose coordinates these are: a copy or a pickle of both belongs together

    Notes
    -----
    A shallow copy reads the same coordinates, a deep copy reads copied ones.
    """

    def __init__(self, compiled: Compiled, q: Floats, s: Floats, of: Moving | None = None) -> None:
        n = len(compiled.coordinate_names)
        if not (isinstance(q, np.ndarray) and q.shape == (n,)):
            raise BadArgument("q", q, f"{n} numbers")
        if not (q.dtype == np.float64 and q.dtype.isnative and q.flags.c_contiguous):
            raise BadArgument("q", q, f"{n} numbers as a contiguous array of doubles")
        most = compiled.length * (1.0 + ROUNDING)
        s = real("s", s)
        if s.ndim != 1 or not np.all((s >= 0.0) & (s <= most)):
            raise BadArgument("s", s, f"arc lengths (N,) in m, each in [0, {compiled.length:g}]")
        self.s = s
        self._compiled, self._of = compiled, of
        self._model, self._q = compiled.model, q
        self._data = new_data(compiled.model)
        self._samples = sample_frames(compiled, s)
        self._base = np.concatenate([compiled.base[:3, :3].ravel(), compiled.base[:3, 3]])
        self._poses = np.zeros((len(s), 7))
        self._poses[:, 6] = 1.0
        self._zero = np.zeros(n)

    def poses(self) -> Floats:
        """Return poses (N, 7) x y z qx qy qz qw in the world, reused by the next call."""
        sample_poses(
            self._model, self._data, self._samples, self._base, self._q, self._zero, self._poses
        )
        return self._poses

    def __copy__(self) -> Sampler:
        return self._restored(self._compiled, self._of, self._q)

    def __deepcopy__(self, memo: dict[int, Any]) -> Sampler:
        of = copy.deepcopy(self._of, memo)
        return self._restored(self._compiled, of, copy.deepcopy(self._q, memo))

    def __getstate__(self) -> tuple[Any, ...]:
        own = self._q if self._of is None else None
        return self._compiled, self._of, own, self.s, self._poses

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        compiled, of, q, s, poses = state
        Sampler.__init__(self, compiled, q if of is None else of.q, s, of)
        self._poses[:] = poses

    def _restored(self, compiled: Compiled, of: Moving | None, q: Floats) -> Sampler:
        new = object.__new__(type(self))
        new.__setstate__((compiled, of, q, self.s, self._poses))
        return new
