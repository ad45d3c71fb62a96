"""Frames along a moving arm."""

from __future__ import annotations

import numpy as np

from .compile import Compiled
from .kernels.output import sample_poses
from .model import Floats, new_data
from .samples import sample_frames


class Sampler:
    """Frames at fixed arc lengths ``s`` (N,) in m; quaternions keep their sign from call to call.

    Parameters
    ----------
    compiled : Compiled
    q : (n,) the coordinates to look at, read anew at every call
    s : (N,) arc lengths in m along all rods, base to tip
    """

    def __init__(self, compiled: Compiled, q: Floats, s: Floats) -> None:
        if q.shape != (len(compiled.coordinate_names),):
            raise ValueError(f"q must be {len(compiled.coordinate_names)} numbers, not {q!r}")
        self.s = s
        self._model, self._q = compiled.model, q
        self._data = new_data(compiled.model)
        self._samples = sample_frames(compiled, s)
        self._base = np.concatenate([compiled.base[:3, :3].ravel(), compiled.base[:3, 3]])
        self._poses = np.zeros((len(s), 7))
        self._poses[:, 6] = 1.0
        self._zero = np.zeros(len(q))

    def poses(self) -> Floats:
        """Return poses (N, 7) x y z qx qy qz qw in the world, reused by the next call."""
        sample_poses(
            self._model, self._data, self._samples, self._base, self._q, self._zero, self._poses
        )
        return self._poses
