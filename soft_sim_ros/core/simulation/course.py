"""The way of a driven coordinate from where it is to where it was commanded to be."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.floats import Floats


def course_to(
    time: float, now: Floats, within: float, position: float | None, velocity: float | None
) -> Floats:
    """Return a row of ``Live.course``: the way from now on, smooth in position, rate, acceleration.

    A polynomial of fifth degree, of fourth if no position is commanded. It ends without
    acceleration; from then on the rate stays.

    Parameters
    ----------
    time : now, s
    now : (3,) position in rad or m, rate and acceleration
    within : s that it takes
    position : where it is then, rad or m; None: wherever the rate leads to
    velocity : its rate then, rad/s or m/s; None: 0
    """
    rate = 0.0 if velocity is None else velocity
    q, v, a = now[0], now[1] * within, 0.5 * now[2] * within * within
    slope, bend = rate * within - v - 2.0 * a, -2.0 * a
    if position is None:
        fourth = 0.25 * (bend - 2.0 * slope)
        rest = [(slope - 4.0 * fourth) / 3.0, fourth, 0.0]
    else:
        way = position - q - v - a
        rest = [
            10.0 * way - 4.0 * slope + 0.5 * bend,
            -15.0 * way + 7.0 * slope - bend,
            6.0 * way - 3.0 * slope + 0.5 * bend,
        ]
    return np.array([time, within, q, v, a, *rest, rate])
