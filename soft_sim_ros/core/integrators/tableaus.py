"""Integrators of the scene's ``numerics.integrator``: tableaux and parameters, one row each.

The contract. A method is one file in ``integrators/`` with one function ``step(at, t, h)``
that brings ``State.q``, ``State.v`` and ``State.ledger`` (dissipated energy, work of loads) of the
Problem at address ``at`` from time t to t + h in s and returns CONVERGED, or leaves all three as
they are and returns one of newton.REASONS. It is called from ``integrators/advance.py``, and

* finds accelerations with ``call_stage``, nothing else: r(q, q̇, q̈) = 0 at q = q* + c_q q̈, q̇ = q̇*
  + c_v q̈, by Newton's method on the analytic tangent, which also counts evaluations of the residual
  (nfev), and tangents and their factors (njev = nlu), in Work.counters;
* applies loads at times from ``forcing.inside``, so that a load that switches at an end of the step
  belongs to one side only; no load switches within a step;
* takes nothing from before the step if Work.restart is set, because an input has jumped (a guess
  for Newton's method excepted), and clears it;
* keeps what it remembers in Work, so that ``problem.forget`` makes it forget, and uses no absolute
  times in it: a motion has the same bits whenever it starts, and however its steps are grouped
  into calls;
* is implicit and at least of second order.

=================== ===== =====================================================================
name                order stability
=================== ===== =====================================================================
sdirk2              2     L-stable, stiffly accurate (Alexander 1977); the default
sdirk3              3     L-stable, stiffly accurate (Alexander 1977)
sdirk4              4     L-stable, stiffly accurate (Hairer & Wanner, Solving ODEs II, table
                          IV.6.5)
implicit_midpoint   2     A-stable, symplectic, no numerical damping
generalized_alpha   2     A-stable, spectral radius at infinity ``options.rho`` ∈ [0, 1]
energy_midpoint     2     implicit midpoint rule that closes the energy ledger
adaptive            4     L-stable, stiffly accurate ESDIRK4(3)6L[2]SA (Kennedy & Carpenter 2003)
                          with steps of its own: each makes an error of at most ``options.error``
=================== ===== =====================================================================
"""

from __future__ import annotations

import math

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import Scene

from .problem import ADAPTIVE, ALPHA, DIRK, ENERGY, Method

DEFAULT_RHO = 0.6
DEFAULT_ERROR = 1e-6
# What Newton's method may leave by default, as an acceleration of the tip in arm lengths/s²: its
# effect on the motion then does not depend on the step. Methods of high order are given less. And
# as a velocity in arm lengths/s never more than COARSEST.
COARSE, FINE, COARSEST = 1e-3, 1e-6, 1e-6


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


_GAMMA = 1.0 - 0.5 * math.sqrt(2.0)
_SDIRK4 = _stiffly_accurate(
    [
        [1 / 4],
        [1 / 2, 1 / 4],
        [17 / 50, -1 / 25, 1 / 4],
        [371 / 1360, -137 / 2720, 15 / 544, 1 / 4],
        [25 / 24, -49 / 48, 125 / 16, -85 / 12, 1 / 4],
    ]
)
# b − b̂ with the embedded method of third order of the same table
_SDIRK4_EMBEDDED = np.array([-3 / 16, -27 / 32, 25 / 32, 0.0, 1 / 4])
_ESDIRK4 = _stiffly_accurate(
    [
        [0.0],
        [1 / 4, 1 / 4],
        [8611 / 62500, -1743 / 31250, 1 / 4],
        [5012029 / 34652500, -654441 / 2922500, 174375 / 388108, 1 / 4],
        [
            15267082809 / 155376265600,
            -71443401 / 120774400,
            730878875 / 902184768,
            2285395 / 8070912,
            1 / 4,
        ],
        [82889 / 524892, 0.0, 15625 / 83664, 69875 / 102672, -2260 / 8211, 1 / 4],
    ]
)
_ESDIRK4_EMBEDDED = np.array(
    [
        -31666707 / 9881966720,
        0.0,
        256875 / 105007616,
        2768025 / 128864768,
        -169839 / 3864644,
        5247 / 225920,
    ]
)
_ONE_STAGE = np.array([[0.5, 0.5], [1.0, 0.0]])

KINDS: dict[str, tuple[int, int, Floats]] = {
    "sdirk2": (DIRK, 2, _stiffly_accurate([[_GAMMA], [1.0 - _GAMMA, _GAMMA]])),
    "sdirk3": (DIRK, 3, _sdirk3()),
    "sdirk4": (DIRK, 4, _SDIRK4),
    "implicit_midpoint": (DIRK, 2, _ONE_STAGE),
    "generalized_alpha": (ALPHA, 2, _ONE_STAGE),
    "energy_midpoint": (ENERGY, 2, _ONE_STAGE),
    "adaptive": (ADAPTIVE, 4, _ESDIRK4),
}
OPTIONS = {"generalized_alpha": ("rho",), "adaptive": ("error",)}


def method_of(scene: Scene) -> Method:
    """Return the method for the kernels; refuse options that have no effect."""
    numerics = scene.numerics
    name, options = numerics.integrator, numerics.options
    for key, value in options.items():
        if key not in OPTIONS.get(name, ()):
            expected = f"no such option: it has no effect on {name}"
            raise SceneError(scene.file, f"numerics.options.{key}", value, expected)
    rho = float(options.get("rho", DEFAULT_RHO))
    if not 0.0 <= rho <= 1.0:
        raise SceneError(scene.file, "numerics.options.rho", rho, "a number in [0, 1]")
    error = float(options.get("error", DEFAULT_ERROR))
    if not 1e-13 <= error <= 0.1:
        raise SceneError(scene.file, "numerics.options.error", error, "a number in [1e-13, 0.1]")
    kind, order, tableau = KINDS[name]
    tolerance = numerics.newton_tolerance
    if tolerance is None:
        tolerance = min(COARSEST, numerics.step * (FINE if order > 3 else COARSE))
    return Method(
        kind=kind,
        order=order,
        tableau=tableau,
        embedded=_ESDIRK4_EMBEDDED,
        starter=_SDIRK4,
        starter_embedded=_SDIRK4_EMBEDDED,
        rho=rho,
        error=error,
        tolerance=tolerance,
        limit=numerics.max_iterations,
    )
