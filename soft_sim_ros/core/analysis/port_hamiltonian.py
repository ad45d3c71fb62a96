"""The port-Hamiltonian form of an arm, Dynamics of Soft Robots (1.44).

    d/dt (q; p) = (J − R) ∇H + G u,   y = Gᵀ ∇H,   H(q, p) = ½ pᵀ M(q)⁻¹ p + V(q),

J = (0, 1; −1, 0), R = (0, 0; 0, R_q), G = (0; ∂Y/∂q), with u the efforts of the actuators and y the
rates of the positions Y of their ports. ``discrete_gradient.py`` integrates it.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from soft_sim_ros.core.arguments import vector
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.history import (
    refuse_branches,
    refuse_constraints,
    refuse_custom,
    refuse_driven,
    refuse_environment,
    refuse_fluid,
    refuse_tendons,
)
from soft_sim_ros.scene import Scene

FORM = "the port-Hamiltonian form"


class PortHamiltonian:
    """A scene as H, ∇H, J, R and G, functions of coordinates q (n,) and momenta p (n,).

    Parameters
    ----------
    scene : Scene or Dynamics
        Its loads do not belong to H: they are the generalised forces ``load_force`` from outside.

    Raises
    ------
    SceneError
        for a Maxwell branch: its dashpots have a state that (q, p) does not hold; for a tendon with
        friction or a commanded length: its tension is not its effort; for a surrounding fluid.
    """

    def __init__(self, scene: Scene | Dynamics) -> None:
        self.dynamics = scene if isinstance(scene, Dynamics) else Dynamics(scene)
        self.n = self.dynamics.n
        refuse_branches(self.dynamics.compiled.scene, FORM)
        refuse_driven(self.dynamics.compiled.scene, FORM)
        refuse_constraints(self.dynamics.compiled.scene, FORM)
        refuse_custom(self.dynamics.compiled.scene, FORM)
        refuse_fluid(self.dynamics.compiled.scene, FORM)
        refuse_environment(self.dynamics.compiled.scene, FORM)
        refuse_tendons(self.dynamics.compiled.scene, FORM)
        self._zero = np.zeros(self.n)

    def momentum(self, q: Floats, v: Floats) -> Floats:
        """Return p = M(q) q̇ (n,): Dynamics of Soft Robots (1.38)."""
        return self.dynamics.mass_matrix(q) @ self.dynamics.coordinates(v, "v")

    def velocity(self, q: Floats, p: Floats) -> Floats:
        """Return q̇ = ∂H/∂p = M(q)⁻¹ p (n,): Dynamics of Soft Robots (1.40)."""
        p = self.dynamics.coordinates(p, "p")
        out: Floats = cho_solve(cho_factor(self.dynamics.mass_matrix(q)), p)
        return out

    def potential(self, q: Floats) -> float:
        """Return V(q) in J: elastic energy and that of the weight, zero at the base."""
        return float(sum(self.dynamics.energies(q, self._zero)[1:]))

    def hamiltonian(self, q: Floats, p: Floats) -> float:
        """Return H(q, p) in J: Dynamics of Soft Robots (1.39)."""
        p = self.dynamics.coordinates(p, "p")
        return 0.5 * float(np.dot(p, self.velocity(q, p))) + self.potential(q)

    def gradient(self, q: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return ∂H/∂q and ∂H/∂p (n,).

        ∂H/∂q = ∂V/∂q − ∂T/∂q, the last at fixed q̇; ∂T/∂q = Cᵀ q̇ with Christoffel's C, since
        Ṁ = C + Cᵀ.
        """
        v = self.velocity(q, p)
        return self.potential_gradient(q) - self.dynamics.christoffel_matrix(q, v).T @ v, v

    def potential_gradient(self, q: Floats) -> Floats:
        """Return ∂V/∂q (n,)."""
        return self.dynamics.gravity_force(q) + self.dynamics.elastic_force(q)

    def structure(self) -> Floats:
        """Return J (2n, 2n), skew."""
        zero, one = np.zeros((self.n, self.n)), np.eye(self.n)
        return np.block([[zero, one], [-one, zero]])

    def dissipation(self, q: Floats | None = None) -> Floats:
        """Return R (2n, 2n) at q, symmetric and positive semidefinite."""
        zero = np.zeros((self.n, self.n))
        return np.block([[zero, zero], [zero, self.dynamics.damping_matrix(q)]])

    def input_matrix(self, q: Floats) -> Floats:
        """Return G (2n, A): generalised forces per unit effort; Gᵀ ∇H are the port velocities."""
        force = self.dynamics.effort_matrix(q)
        return np.concatenate([np.zeros_like(force), force])

    def load_force(self, q: Floats, time: float = 0.0) -> Floats:
        """Return the generalised forces (n,) of the scene's loads at ``time`` in s."""
        data = self.dynamics.forcing(time=time)
        with_loads = self.dynamics.residual(q, self._zero, self._zero, data)
        return self.potential_gradient(q) - with_loads

    def rates(
        self, q: Floats, p: Floats, efforts: Floats | None = None, tau: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Return q̇ and ṗ (n,) for efforts (A,) and generalised forces tau (n,).

        Dynamics of Soft Robots (1.44).
        """
        gradient = np.concatenate(self.gradient(q, p))
        rate = (self.structure() - self.dissipation(q)) @ gradient
        if efforts is not None:
            rate += self.input_matrix(q) @ vector("efforts", efforts, self.dynamics.actuators)
        if tau is not None:
            rate[self.n :] += vector("tau", tau, self.n)
        return rate[: self.n], rate[self.n :]
