"""Modes and frequencies of small motion about a state of rest."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from .dynamics import Dynamics
from .model import Floats


def modes(
    dynamics: Dynamics, q: Floats, efforts: Floats | None = None, time: float = 0.0
) -> tuple[Floats, Floats]:
    """Return angular frequencies (n,) in rad/s, ascending, and mode shapes (n, n).

    Shapes are columns with φᵀ M φ = 1.

    From the symmetric part of the exact tangent at q; an unstable direction has a negative
    "frequency".
    """
    zero = np.zeros(dynamics.n)
    stiffness, _, mass = dynamics.tangents(q, zero, zero, efforts, time)
    values, shapes = eigh(0.5 * (stiffness + stiffness.T), 0.5 * (mass + mass.T))
    return np.sign(values) * np.sqrt(np.abs(values)), shapes


def frequencies(dynamics: Dynamics, q: Floats | None = None, count: int = 5) -> Floats:
    """Return the lowest ``count`` frequencies in Hz at q (the reference shape by default)."""
    state = np.zeros(dynamics.n) if q is None else q
    return modes(dynamics, state)[0][:count] / (2.0 * np.pi)


def recommended_step(dynamics: Dynamics, q: Floats) -> float:
    """Return a step in s that resolves the slowest motions.

    It is 1/100 of the period of the third lowest mode. Stiffer motion is stable at any step and
    damped out; only its detail is lost. Rounded down to 1, 2 or 5 · 10^k.
    """
    omega = np.abs(modes(dynamics, q)[0])
    omega = omega[omega > 1e-6][:3]
    if len(omega) == 0:
        return 0.01
    step = min(2.0 * np.pi / omega[-1] / 100.0, 0.02)
    power = 10.0 ** np.floor(np.log10(step))
    return float(max(m for m in (1.0, 2.0, 5.0) if m * power <= step * (1 + 1e-12)) * power)
