"""A scene as a first-order system y' = f(t, y), y = (q, q̇), for scipy.integrate.

An independent check of the integrators, not a way to be fast: it shares the equations of motion
with them, but neither steps nor error control, and takes any method of ``solve_ivp``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import lu_factor, lu_solve

from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.scene import Scene

from .dynamics import Dynamics
from .history import refuse_constraints


class FirstOrder:
    """The right-hand side of a scene under constant efforts, and its Jacobian.

    Parameters
    ----------
    scene : Scene, Compiled or Dynamics
    efforts : (A,) in the units of their commands, in scene order; zero by default

    Attributes
    ----------
    nfev, njev : calls of the residual and of the tangent
    """

    def __init__(self, scene: Scene | Compiled | Dynamics, efforts: Floats | None = None) -> None:
        self.dynamics = scene if isinstance(scene, Dynamics) else Dynamics(scene)
        self.efforts = efforts
        refuse_constraints(self.dynamics.compiled.scene, "a system of first order")
        self.nfev = self.njev = 0

    def __call__(self, t: float, y: Floats) -> Floats:
        """Return (q̇, q̈) (2n,) at time t in s."""
        self.nfev += 1
        q, v = np.split(y, 2)
        return np.concatenate([v, self.dynamics.forward_dynamics(q, v, self.efforts, t)])

    def jacobian(self, t: float, y: Floats) -> Floats:
        """Return ∂f/∂y (2n, 2n), from the exact tangent."""
        self.njev += 1
        n = self.dynamics.n
        q, v = np.split(y, 2)
        a = self.dynamics.forward_dynamics(q, v, self.efforts, t)
        stiffness, damping, mass = self.dynamics.tangents(q, v, a, self.efforts, t)
        free = np.flatnonzero(self.dynamics.free)
        factors = lu_factor(mass[np.ix_(free, free)])
        out = np.zeros((2 * n, 2 * n))
        out[:n, n:] = np.eye(n)
        out[n + free, :n] = -lu_solve(factors, stiffness[free])
        out[n + free, n:] = -lu_solve(factors, damping[free])
        return out


def solve(
    scene: Scene | Compiled | Dynamics,
    times: Floats,
    q: Floats,
    v: Floats,
    *,
    efforts: Floats | None = None,
    method: str = "Radau",
    rtol: float = 1e-8,
    atol: float | Floats | None = None,
    **options: Any,
) -> tuple[Floats, Floats]:
    """Return q and q̇ (T, n) at ``times`` (T,) in s, starting from q, v (n,) at the first.

    Parameters
    ----------
    atol : absolute tolerance; by default a displacement of the tip by ``rtol`` arm lengths
    method, options : of scipy.integrate.solve_ivp; implicit ones get the exact Jacobian

    Raises
    ------
    RuntimeError
        if scipy gives up.

    Notes
    -----
    Loads that switch between two of the times are not stepped on exactly.
    """
    system = FirstOrder(scene, efforts)
    if atol is None:
        atol = np.tile(rtol / system.dynamics.model.weight, 2)
    if method in ("Radau", "BDF", "LSODA"):
        options["jac"] = system.jacobian
    span = (float(times[0]), float(times[-1]))
    found = solve_ivp(
        system,
        span,
        np.concatenate([q, v]),
        method=method,
        t_eval=times,
        rtol=rtol,
        atol=atol,
        **options,
    )
    if not found.success:
        raise RuntimeError(f"{method} gave up: {found.message}")
    n = system.dynamics.n
    return found.y[:n].T, found.y[n:].T
