"""Integrators of the scene's ``numerics.integrator``: tableaux and parameters, one row each.

Rules: one-step, implicit, at least second order; no memory of inputs before the step (inputs jump
at every command).

========================  =====
======================================================================
name                      order  stability
========================  =====
======================================================================
sdirk2                    2      L-stable, stiffly accurate (Alexander 1977); the default
sdirk3                    3      L-stable, stiffly accurate (Alexander 1977)
sdirk4                    4      L-stable, stiffly accurate (Hairer & Wanner, Solving ODEs II,
table IV.6.5)
implicit_midpoint         2      A-stable, symplectic, no numerical damping
generalized_alpha         2      A-stable, spectral radius at infinity ``options.rho`` ∈ [0, 1]
========================  =====
======================================================================
"""

from __future__ import annotations

import math

import numpy as np

from ..errors import SceneError
from ..scene import Scene
from .model import Floats

DEFAULT_RHO = 0.6


def _stiffly_accurate(rows: list[list[float]]) -> Floats:
    """Return the tableau A | c over b | 0 with b = last row of A."""
    s = len(rows)
    table = np.zeros((s + 1, s + 1))
    for i, row in enumerate(rows):
        table[i, : len(row)] = row
        table[i, s] = sum(row)
    table[s, :s] = table[s - 1, :s]
    return table


def _sdirk3() -> Floats:
    # γ is the root of x³ − 3x² + 3x/2 − 1/6 near 0.4359 (L-stability)
    g = float(np.sort(np.roots([1.0, -3.0, 1.5, -1.0 / 6.0]).real)[1])
    b1 = -(6.0 * g * g - 16.0 * g + 1.0) / 4.0
    b2 = (6.0 * g * g - 20.0 * g + 5.0) / 4.0
    return _stiffly_accurate([[g], [0.5 * (1.0 - g), g], [b1, b2, g]])


def _sdirk4() -> Floats:
    return _stiffly_accurate(
        [
            [1 / 4],
            [1 / 2, 1 / 4],
            [17 / 50, -1 / 25, 1 / 4],
            [371 / 1360, -137 / 2720, 15 / 544, 1 / 4],
            [25 / 24, -49 / 48, 125 / 16, -85 / 12, 1 / 4],
        ]
    )


_GAMMA = 1.0 - 0.5 * math.sqrt(2.0)
TABLEAUX: dict[str, Floats] = {
    "sdirk2": _stiffly_accurate([[_GAMMA], [1.0 - _GAMMA, _GAMMA]]),
    "sdirk3": _sdirk3(),
    "sdirk4": _sdirk4(),
    "implicit_midpoint": np.array([[0.5, 0.5], [1.0, 0.0]]),
    "generalized_alpha": np.zeros((1, 1)),
}
ORDERS = {"sdirk2": 2, "sdirk3": 3, "sdirk4": 4, "implicit_midpoint": 2, "generalized_alpha": 2}


def method_of(scene: Scene) -> tuple[Floats, float]:
    """Return (tableau, rho) for the kernels; refuse options that have no effect."""
    numerics = scene.numerics
    allowed = ("rho",) if numerics.integrator == "generalized_alpha" else ()
    for key, value in numerics.options.items():
        if key not in allowed:
            expected = f"no such option: it has no effect on {numerics.integrator}"
            raise SceneError(scene.file, f"numerics.options.{key}", value, expected)
    rho = float(numerics.options.get("rho", DEFAULT_RHO))
    if not 0.0 <= rho <= 1.0:
        raise SceneError(scene.file, "numerics.options.rho", rho, "a number in [0, 1]")
    return TABLEAUX[numerics.integrator], rho
