"""Bristles of friction in contact as part of a state."""

from __future__ import annotations

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Data


def held_bristles(data: Data) -> tuple[Floats, Floats, Floats]:
    """Return all that decides how bristles go on: what ``recall_bristles`` takes, part by part."""
    return data.touch.bristle, data.touch.ends, data.touch.final


def recall_bristles(data: Data, bristles: Floats | None) -> None:
    """Put bristles back, in one array; None: none is deflected, and nothing touches yet."""
    touch = data.touch
    begin = 0
    for part in held_bristles(data):
        part[...] = 0.0
        if bristles is not None:
            part[...] = bristles[begin : begin + part.size].reshape(part.shape)
        begin += part.size
    for scratch in (touch.start, touch.after, touch.rates):
        scratch[...] = 0.0
    touch.kept[:] = 0
    touch.near[:, 3:] = -1.0
    touch.alive[:1] = int(bool(touch.bristle.any() or touch.ends.any()))
