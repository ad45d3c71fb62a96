"""One step of the discrete-gradient method: its equation, its solution, and what is refused."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.integrators.advance import REACH
from soft_sim_ros.core.integrators.newton import CONVERGED, REASONS, TOO_FAR, admissible
from soft_sim_ros.errors import Diverged, NewtonFailed

from .port_hamiltonian import PortHamiltonian

ROUND_OFF = 32.0 * float(np.finfo(np.float64).eps)
ITERATIONS = 60
DEPTH = 5  # of Anderson's mixing
LONGEST = 0.3  # arm lengths that one iteration may move the tip
POLISH = 4  # converged iterates of which the best is taken
TOLERANCE = 1e-11  # of the last correction, as a displacement of the tip in arm lengths
# What closes the balance may be no more than this part of the midpoint rule that it corrects, and
# the rates at both ends of a step may disagree with its way by so many arm lengths (or radians).
MOST, APART = 0.1, 0.02
RESTING = 1e-9  # of the stored energy: with less kinetic energy there is no motion to be shown
HELP = "(a shorter one, or an integrator of numerics, shows it)"


class GradientStep:
    """The equation of one step for the displacement Δq; momenta follow from it.

    Δq = h M⁻¹ p̄ makes p̄ = M(q̄) Δq/h and p⁺ = 2p̄ − p, which leaves

        (2/h)(p̄ − p) + ∂V/∂q − ∂T/∂q + c W Δq + R Δq/h − τ = 0.

    Parameters
    ----------
    system : PortHamiltonian
    start : q, p (n,), time in s and H in J at the start of the step
    h : its length in s
    efforts, tau : (A,) efforts and (n,) generalised forces, held
    """

    def __init__(
        self,
        system: PortHamiltonian,
        start: tuple[Floats, Floats, float, float],
        h: float,
        efforts: Floats,
        tau: Floats,
    ) -> None:
        self.system, self.dynamics = system, system.dynamics
        self.q, self.p, self.time, energy = start
        self.h, self.efforts, self.tau = h, efforts, tau
        self.stiffness = self.dynamics.stiffness_matrix()
        self.start = energy - self._port_work(self.q)
        self.scale = self.share = 0.0
        self._zero = np.zeros(len(self.q))

    def damping(self, move: Floats) -> Floats:
        """Return R (n, n) at the midpoint."""
        return self.dynamics.damping_matrix(self.q + 0.5 * move)

    def port_position(self, q: Floats) -> Floats:
        """Return the positions (A,) of the actuator ports."""
        return self.dynamics.ports(q, np.zeros(len(q)))[0]

    def _port_work(self, q: Floats) -> float:
        return float(self.efforts @ self.port_position(q)) if len(self.efforts) else 0.0

    def end(self, move: Floats) -> tuple[Floats, Floats, float]:
        """Return q⁺, p⁺ and H(q⁺, p⁺)."""
        mean = self.dynamics.mass_matrix(self.q + 0.5 * move) @ move / self.h
        q, p = self.q + move, 2.0 * mean - self.p
        return q, p, self.system.hamiltonian(q, p)

    def check(self, move: Floats, p: Floats) -> None:
        """Refuse a solution that is no motion, p (n,) its momenta at the end.

        Rods crushed or turned over, a jump too far, or a way that the rates do not lead.
        """
        weight = self.dynamics.model.weight
        rates = self.system.velocity(self.q, self.p), self.system.velocity(self.q + move, p)
        kinetic = 0.5 * max(float(self.p @ rates[0]), float(p @ rates[1]))
        stored = self.dynamics.energies(self.q, self._zero)
        # at rest c is a quotient of round-off; in linear motion c W Δq is added to W Δq / 2
        if kinetic > RESTING * float(np.abs(stored).sum()) and not 2.0 * abs(self.share) <= MOST:
            raise self._unshown(
                f"its energy is balanced by a correction of {2.0 * abs(self.share):.2g} times what "
                f"moves the arm, allowed is {MOST}"
            )
        apart = float(np.max(np.abs(move - 0.5 * self.h * sum(rates)) * weight, initial=0.0))
        if not apart <= APART:
            raise self._unshown(
                f"its way and the velocities at its ends disagree by {apart:.2g} arm lengths or "
                f"radians, allowed is {APART}"
            )
        status = TOO_FAR
        if np.all(np.abs(move) * weight <= REACH):
            data = self.dynamics.forcing()
            self.dynamics.residual(self.q + move, self._zero, self._zero, data)
            status = admissible(self.dynamics.model, data)
        if status != CONVERGED:
            raise Diverged(self.time, REASONS[status])

    def _unshown(self, how: str) -> Diverged:
        return Diverged(
            self.time, f"a step of {self.h:.3g} s does not show the motion: {how} {HELP}"
        )

    def equation(self, move: Floats) -> tuple[Floats, Floats]:
        """Return the left-hand side (n,) and its derivative (n, n), but for small terms.

        What is left out are the second derivatives of M, of order h² beside M itself, and the
        slope of c: hence the mixing in ``solve``.
        """
        h, zero, dynamics = self.h, self._zero, self.dynamics
        middle, v = self.q + 0.5 * move, move / self.h
        stiffness, still, mass = dynamics.tangents(middle, zero, zero, self.efforts, self._when)
        statics = dynamics.residual(middle, zero, zero, dynamics.forcing(self.efforts, self._when))
        # ∂(C v)/∂v = 2C
        coriolis = 0.5 * (dynamics.tangents(middle, v, zero)[1] - still)
        # ∂(M a)/∂q along a = Δq
        turning = (
            dynamics.tangents(middle, zero, move)[0] - dynamics.tangents(middle, zero, zero)[0]
        )
        mean = mass @ v
        slope = statics - coriolis.T @ v
        damping = self.damping(move)
        left = 2.0 / h * (mean - self.p) + slope + damping @ v - self.tau
        metric = self.stiffness + 4.0 / h**2 * mass
        share = self._correction(move, metric @ move, slope)
        left += share * (metric @ move)
        matrix = 2.0 / h**2 * (mass + 0.5 * turning) + 0.5 * stiffness + damping / h
        return left, matrix - turning.T / h**2 + share * metric

    @property
    def _when(self) -> float:
        return self.time + 0.5 * self.h

    def _correction(self, move: Floats, direction: Floats, slope: Floats) -> float:
        """Return c, by which ∇H(q̄, p̄) + (c W Δq; 0) is a discrete gradient; direction = W Δq.

        W weighs with the stiffness as well as with the mass: what a long step cannot resolve is
        mostly elastic, and there a small change of the force pays for it.
        """
        size = float(move @ direction)
        q, p, energy = self.end(move)
        jump = energy - self._port_work(q) - self.start
        # loads are forces, not part of H: what they add to the slope is taken out again
        inner = slope + self.system.load_force(self.q + 0.5 * move, self._when)
        along = float(inner @ move) + float(move @ (p - self.p)) / self.h
        missing = jump - along
        self.scale = abs(energy) + abs(self.start)
        self.share = 0.0 if size == 0.0 else missing / size
        return self.share

    def solve(self) -> Floats:
        """Return Δq (n,), by Newton's method with Anderson's mixing for what its matrix lacks."""
        weight = self.dynamics.model.weight
        move = self.h * self.system.velocity(self.q, self.p)
        moves: list[Floats] = []
        changes: list[Floats] = []
        found: list[tuple[float, Floats]] = []
        size, made = np.inf, 0
        while made < ITERATIONS:
            made += 1
            try:
                left, matrix = self.equation(move)
                change = -np.asarray(np.linalg.solve(matrix, left), dtype=np.float64)
            except np.linalg.LinAlgError:
                break
            size = float(np.max(np.abs(change) * weight, initial=0.0))
            if not np.isfinite(size):
                break
            if size <= TOLERANCE:
                # what is left of the equation makes energy: go on until that is round-off, too
                found.append((abs(float(left @ move)), move))
                best = min(found, key=lambda pair: pair[0])
                if best[0] <= ROUND_OFF * self.scale or len(found) == POLISH:
                    return best[1]
            if size > LONGEST:
                moves, changes, move = [], [], move + change * (LONGEST / size)
                continue
            moves.append(move)
            changes.append(change)
            move = _mixed(moves[-DEPTH:], changes[-DEPTH:], weight)
        raise NewtonFailed(self.time, made, size, TOLERANCE)


def _mixed(moves: list[Floats], changes: list[Floats], weight: Floats) -> Floats:
    """Return the next iterate: Anderson's combination of the last ones with the least change."""
    if len(moves) == 1:
        return moves[0] + changes[0]
    slopes = np.stack([changes[-1] - other for other in changes[:-1]], axis=1)
    steps = np.stack([moves[-1] - other for other in moves[:-1]], axis=1)
    share = np.linalg.lstsq(slopes * weight[:, None], changes[-1] * weight, rcond=1e-10)[0]
    out: Floats = moves[-1] + changes[-1] - (steps + slopes) @ share
    return out
