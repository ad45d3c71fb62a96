"""Frames along a moving arm."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from soft_sim_ros.core.arguments import real
from soft_sim_ros.core.compile.samples import Place, places_along, samples_at
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


class Frames:
    """Frames at P places; quaternions keep their sign from call to call.

    Parameters
    ----------
    compiled : Compiled
    q : (n,) the coordinates to look at, contiguous doubles, read anew at every call
    places : P of them (compile/samples.py)
    of : the simulation whose coordinates these are: a copy or a pickle of both belongs together

    Notes
    -----
    A shallow copy reads the same coordinates, a deep copy reads copied ones.
    """

    def __init__(
        self, compiled: Compiled, q: Floats, places: Sequence[Place], of: Moving | None = None
    ) -> None:
        n = len(compiled.coordinate_names)
        if not (isinstance(q, np.ndarray) and q.shape == (n,)):
            raise BadArgument("q", q, f"{n} numbers")
        if not (q.dtype == np.float64 and q.dtype.isnative and q.flags.c_contiguous):
            raise BadArgument("q", q, f"{n} numbers as a contiguous array of doubles")
        self._compiled, self._of, self._places = compiled, of, list(places)
        self._model, self._q = compiled.model, q
        self._data = new_data(compiled.model)
        self._samples = samples_at(self._places)
        self._base = np.concatenate([compiled.base[:3, :3].ravel(), compiled.base[:3, 3]])
        self._poses = np.zeros((len(self._places), 7))
        self._poses[:, 6] = 1.0
        self._zero = np.zeros(n)

    def poses(self) -> Floats:
        """Return poses (P, 7) x y z qx qy qz qw in the world, reused by the next call."""
        sample_poses(
            self._model, self._data, self._samples, self._base, self._q, self._zero, self._poses
        )
        return self._poses

    def __copy__(self) -> Frames:
        return self._restored(self._of, self._q)

    def __deepcopy__(self, memo: dict[int, Any]) -> Frames:
        of = copy.deepcopy(self._of, memo)
        return self._restored(of, copy.deepcopy(self._q, memo))

    def __getstate__(self) -> tuple[Any, ...]:
        own = self._q if self._of is None else None
        return self._compiled, self._of, own, self._places, self._poses, self._more()

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        compiled, of, q, places, poses, more = state
        Frames.__init__(self, compiled, q if of is None else of.q, places, of)
        self._poses[:] = poses
        self.__dict__.update(more)

    def _more(self) -> dict[str, Any]:
        """Return what a subclass has besides."""
        return {}

    def _restored(self, of: Moving | None, q: Floats) -> Frames:
        new = object.__new__(type(self))
        new.__setstate__((self._compiled, of, q, self._places, self._poses, self._more()))
        return new


class Sampler(Frames):
    """Frames at fixed arc lengths ``s`` (P,) in m.

    Parameters
    ----------
    compiled, q, of : as for Frames
    s : (P,) arc lengths in m along the rods of a backbone, base to tip
    backbone : its name; the last one by default, in a chain the only one
    """

    def __init__(
        self,
        compiled: Compiled,
        q: Floats,
        s: Floats,
        of: Moving | None = None,
        backbone: str | None = None,
    ) -> None:
        branch = compiled.backbone(backbone)
        length = branch.length or 1.0
        s = real("s", s)
        if s.ndim != 1 or not np.all((s >= 0.0) & (s <= length * (1.0 + ROUNDING))):
            raise BadArgument("s", s, f"arc lengths (N,) in m, each in [0, {length:g}]")
        super().__init__(compiled, q, places_along(compiled.chain, branch, s), of)
        self.s = s

    def _more(self) -> dict[str, Any]:
        return {"s": self.s}
