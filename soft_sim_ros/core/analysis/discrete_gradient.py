"""A method in time that keeps the port-Hamiltonian structure: Gonzalez' discrete gradient.

The structure is Dynamics of Soft Robots (1.44). (1.45) then holds for every step, to round-off.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.algebra import charts, se3
from soft_sim_ros.core.arguments import number, vector_or_zeros
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.errors import BadArgument, Diverged, NewtonFailed
from soft_sim_ros.scene import Scene

from .gradient_step import ITERATIONS, TOLERANCE, GradientStep
from .port_hamiltonian import PortHamiltonian

CUTS = 5


class Balance(NamedTuple):
    """Energies in J of a step or a motion: stored = supplied − dissipated.

    Dynamics of Soft Robots (1.45).
    """

    stored: float
    supplied: float
    dissipated: float


class DiscreteGradient:
    """Steps of a port-Hamiltonian system with the structure of Dynamics of Soft Robots (1.44).

    Parameters
    ----------
    system : PortHamiltonian, Dynamics or Scene
    q, v : (n,) initial coordinates and rates; the reference shape at rest by default

    Attributes
    ----------
    q, p : (n,) coordinates and momenta
    time : s
    balance : Balance since the beginning; the last step's is what ``step`` returns

    Notes
    -----
    x⁺ − x = h (J − R) ∇̄H + h G u with Gonzalez' discrete gradient: ∇H at the midpoint, corrected
    along Δq, in the metric W = K + 4M/h², so that ∇̄H · (x⁺ − x) = H(x⁺) − H(x). Ports work uᵀ Δy,
    loads their force at the midpoint times Δq, damping takes Δqᵀ R Δq / h ≥ 0: so no step can
    make energy, however long it is, and Property 1.1 holds for the discrete motion. Second order,
    symmetric. A balance proves no motion: an arm that stands still with p⁺ = −p keeps H, too, and
    c grows as large as that takes. So a step is taken only where c is small and the midpoint rule
    agrees with the trapezoidal rule. Loads are taken in the middle of a step; one that switches
    within it is not hit exactly. Between steps rotation vectors change their chart as in
    ``Simulation``. Dense linear algebra: for some dozens of coordinates.
    """

    def __init__(
        self,
        system: PortHamiltonian | Dynamics | Scene,
        q: Floats | None = None,
        v: Floats | None = None,
    ) -> None:
        self.system = system if isinstance(system, PortHamiltonian) else PortHamiltonian(system)
        n = self.system.n
        self.q = _checked("q", q, n).copy()
        self.p = self.system.momentum(self.q, _checked("v", v, n))
        self.time = 0.0
        self.balance = Balance(0.0, 0.0, 0.0)
        self._energy = self.system.hamiltonian(self.q, self.p)

    @property
    def v(self) -> Floats:
        """Rates q̇ (n,) of the present state."""
        return self.system.velocity(self.q, self.p)

    def step(self, h: float, efforts: Floats | None = None, tau: Floats | None = None) -> Balance:
        """Advance by h in s with efforts (A,) and generalised forces tau (n,) held.

        A step that Newton's method cannot make is cut in half, up to ``CUTS`` times. A step back
        (h < 0) undoes one forward.

        Raises
        ------
        NewtonFailed, Diverged
            if that does not help: no solution, or one that is no motion; the state is that of the
            last good piece.
        ValueError
            if h is 0, or something is not finite or not as long as it should be
        """
        if (h := number("h", h)) == 0.0:
            raise BadArgument("h", h, "a time in s other than 0")
        u = _checked("efforts", efforts, self.system.dynamics.actuators)
        force = _checked("tau", tau, self.system.n)
        before = self.balance
        self._advance(h, u, force, CUTS)
        return Balance(*(a - b for a, b in zip(self.balance, before, strict=True)))

    def _advance(self, h: float, efforts: Floats, tau: Floats, cuts: int) -> None:
        start = self.q, self.p, self.time, self._energy
        problem = GradientStep(self.system, start, h, efforts, tau)
        try:
            move = problem.solve()
            q, p, energy = problem.end(move)
            problem.check(move, p)
        except (NewtonFailed, Diverged, np.linalg.LinAlgError) as failure:
            if cuts == 0:
                if not isinstance(failure, np.linalg.LinAlgError):
                    raise
                raise NewtonFailed(self.time, ITERATIONS, np.inf, TOLERANCE) from failure
            for _ in range(2):
                self._advance(0.5 * h, efforts, tau, cuts - 1)
            return
        ports = problem.port_position(q) - problem.port_position(self.q)
        outside = tau + self.system.load_force(self.q + 0.5 * move, self.time + 0.5 * h)
        one = (
            energy - self._energy,
            float(efforts @ ports + outside @ move),
            float(move @ problem.damping(move) @ move) / h,
        )
        self.balance = Balance(*(a + b for a, b in zip(self.balance, one, strict=True)))
        self.q, self.p, self._energy = q, p, energy
        self.time += h
        self._change_charts()

    def _change_charts(self) -> None:
        """Shorten rotation vectors beyond charts.LONGEST: other numbers, one motion.

        Momenta are covectors: p stays the same linear form, p′ = M(q′) q̇′.
        """
        long = [
            turn
            for first in self.system.dynamics.model.chart
            if np.linalg.norm(self.q[turn := slice(first, first + 3)]) > charts.LONGEST
        ]
        if not long:
            return
        q, v = self.q.copy(), self.v
        for turn in long:
            spin = _rotation_tangent(q[turn]) @ v[turn]
            q[turn] *= 1.0 - 2.0 * np.pi / np.linalg.norm(q[turn])
            v[turn] = np.linalg.solve(_rotation_tangent(q[turn]), spin)
        self.q, self.p = q, self.system.momentum(q, v)
        self._energy = self.system.hamiltonian(self.q, self.p)


def _checked(name: str, value: Floats | None, size: int) -> Floats:
    """Return an argument as finite numbers (size,), zeros by default."""
    return vector_or_zeros(name, value, size, finite=True)


def _rotation_tangent(w: Floats) -> Floats:
    """Return T(w) (3, 3): T ẇ is the angular velocity in the turned frame."""
    return se3.right_tangent(np.concatenate([w, np.zeros(3)]))[:3, :3]
