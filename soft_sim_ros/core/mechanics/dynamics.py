"""The Lagrangian model M q̈ + C q̇ + g + k + R q̇ = τ as functions of the state.

Dynamics of Soft Robots (1.31). Every quantity is exact for the discrete model, that is for its
kinetic and potential energy as functions of q and q̇.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.contact import PRESENT
from soft_sim_ros.core.recursion.columns import node_jacobians
from soft_sim_ros.core.recursion.elimination import dense, diagonal_of, new_system
from soft_sim_ros.core.recursion.momentum import momentum
from soft_sim_ros.core.recursion.output import energies
from soft_sim_ros.core.recursion.rnea import place
from soft_sim_ros.core.terms.fibres import fibre_forces, fibre_tangent, section_strains
from soft_sim_ros.scene import Joint

from .fluid import added_coriolis, other_force, viscous_matrix
from .history import refuse_constraints
from .ports import Ports
from .wrench import InternalWrench, internal_wrench


class Dynamics(Ports):
    """The parts of the equations of motion of a scene, its energies, ports, frames and reactions.

    Parameters
    ----------
    scene : Scene or Compiled
    """

    def reactions(self, q: Floats, v: Floats, a: Floats, time: float = 0.0) -> dict[str, Floats]:
        """Return the wrench (6,) of every joint on the part after it.

        Boyer & Primault 2005 (3.21), (3.34).

        Moment and force in the frame after the joint, at its origin, from the balance of that
        part. Along the directions that the joint leaves free it is what motor, spring and damper
        give, if (q, v, a) is a motion; all others are reactions of the constraint.
        """
        data = self.forcing(time=time)
        if len(self.constraints):
            self.accelerations(q, v, data, time)
        self.residual(q, v, a, data)
        frames = self.compiled.chain.frames
        joints = [body.name for body in self.compiled.scene.bodies if isinstance(body, Joint)]
        return {name: self._data.wrench[frames[name]].copy() for name in joints}

    def momentum(self, q: Floats, v: Floats) -> Floats:
        """Return the momentum map (6,) of the bodies in world axes; that of a fluid is not in it.

        Angular momentum about the world's origin in kg·m²/s, momentum in kg·m/s (Boyer & Primault
        2005, section 2).
        """
        found = np.zeros(10)
        state = self.coordinates(q), self.coordinates(v, "v")
        momentum(self.model, self._data, *state, self._zero, 0, len(self.model.inertia), found)
        turn, origin = self.compiled.base[:3, :3], self.compiled.base[:3, 3]
        push = turn @ found[3:6]
        return np.concatenate([turn @ found[:3] + np.cross(origin, push), push])

    def mass_matrix(self, q: Floats) -> Floats:
        """Return M(q) (n, n) of Dynamics of Soft Robots (1.32), with added mass."""
        data = self.forcing()
        self.residual(q, self._zero, self._zero, data)
        matrix = self.last_tangent((0.0, 0.0, 1.0))
        return 0.5 * (matrix + matrix.T)

    def elastic_force(self, q: Floats) -> Floats:
        """Return k(q) = ∂V_elastic/∂q (n,): Dynamics of Soft Robots (1.35), projected with Φᵀ."""
        q = self.coordinates(q)
        out = self._law(self.model.stiffness) @ q
        fibre_forces(self.model.fibres, self._data.section, q, out)
        return out

    def stiffness_matrix(self, q: Floats | None = None) -> Floats:
        """Return ∂k/∂q (n, n) at q, by default the reference shape.

        It is ∫ Φᵀ H Φ ds and joint stiffness where all materials are linear.
        """
        state = self._zero if q is None else self.coordinates(q)
        out = np.zeros((self.n, self.n))
        section_strains(self.model.fibres, state, self._data.section)
        system = new_system(self.model)
        fibre_tangent(self.model, self._data.section, 1.0, system)
        dense(self.model, system, out)
        return out + self._law(self.model.stiffness)

    @property
    def forces_follow(self) -> bool:
        """Whether a follower load acted in the last residual."""
        return bool(self._data.active[1])

    @cached_property
    def law_at_rest(self) -> Floats:
        """The diagonal (n,) of the elastic stiffness in the reference shape."""
        section = self._data.section.copy()  # scratch of the last residual, put back below
        section_strains(self.model.fibres, self._zero, self._data.section)
        system = new_system(self.model)
        fibre_tangent(self.model, self._data.section, 1.0, system)
        self._data.section[:] = section
        diagonal = system.diagonal[diagonal_of(self.model, system)]
        rows = np.repeat(np.arange(self.n), np.diff(self.model.law_ptr))
        own = rows == self.model.law_col
        diagonal[rows[own]] += self.model.stiffness[own]
        return np.asarray(diagonal)

    def damping_matrix(self, q: Floats | None = None) -> Floats:
        """Return R (n, n) at q, by default the reference shape.

        Dynamics of Soft Robots (1.36), projected with Φᵀ.

        It is ∫ Φᵀ Γ Φ ds, joint damping, and mass damping and viscous drag Σ Jᵀ D J, which alone
        depend on q.
        """
        out = self._law(self.model.damping)
        q = self._zero if q is None else self.coordinates(q)
        if len(self.model.mass_damping):
            jacobian = self.jacobians(q, self._zero)[0]
            for own, damping in zip(jacobian, self.model.mass_damping, strict=True):
                out += own.T @ (damping[[1, 2, 3, 0, 0, 0], None] * own)
        if self.model.fluid.viscous.any():
            out += viscous_matrix(self.model.fluid, self.jacobians(q, self._zero)[0])
        return out

    def fluid_force(self, q: Floats, v: Floats, time: float = 0.0) -> Floats:
        """Return the force (n,) of the surrounding fluid that is not in M, C, g and R.

        Quadratic drag, lift, what a current does at ``time`` in s, and the pressure that is missing
        on dry ends. Added mass is in M and C, buoyancy in g, drag in proportion to velocity in R.
        """
        state = self.coordinates(q), self.coordinates(v, "v")
        return other_force(self.model, self.forcing(time=time), *state)

    def branch_matrix(self) -> Floats:
        """Return K_m = ∫ Φᵀ H_m Φ ds (n, n) of the Maxwell branches; here they are relaxed."""
        return (
            self._law(self.model.branch) if len(self.model.branch) else np.zeros((self.n, self.n))
        )

    def gravity_force(self, q: Floats) -> Floats:
        """Return g(q) = ∂V_gravity/∂q (n,): Dynamics of Soft Robots (1.34), with buoyancy."""
        data = self.forcing()
        data.active[:] = 0
        data.now[1] = 0.0  # no custom loads, no current
        data.touch.mode[PRESENT:] = 0.0
        data.effort[self.model.length_control[:, 0] != 0.0] = -np.inf  # slack
        out = self.residual(q, self._zero, self._zero, data) - self.elastic_force(q)
        data.touch.mode[PRESENT:] = 1.0
        return out

    def energies(
        self, q: Floats, v: Floats, efforts: Floats | None = None
    ) -> tuple[float, float, float]:
        """Return kinetic, elastic and gravity energy in J; gravity energy is zero at the base.

        The elastic energy is that of rods and joints, and of tendons whose lengths are commanded.
        """
        state = self.coordinates(q), self.coordinates(v, "v")
        return energies(self.model, self.forcing(efforts), *state, self._zero)

    def node_poses(self, q: Floats) -> Floats:
        """Return the poses (nodes, 4, 4) of all nodes in the world."""
        data = self.forcing()
        self.residual(q, self._zero, self._zero, data)
        place(self.model, data)
        out = np.zeros((len(data.position), 4, 4))
        out[:, :3, :3] = data.rotation.reshape(-1, 3, 3)
        out[:, :3, 3] = data.position
        out[:, 3, 3] = 1.0
        return self.compiled.base @ out

    def node_twists(self, q: Floats, v: Floats) -> Floats:
        """Return the body twists (nodes, 6) of all nodes."""
        self.residual(q, v, self._zero, self.forcing())
        return self._data.eta.copy()

    def jacobians(self, q: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Return the body Jacobians J of all nodes and their rates J̇ along v (nodes, 6, n)."""
        self.residual(q, v, self._zero, self.forcing())
        nodes = len(self._data.position)
        jacobian, rate = np.zeros((nodes, 6, self.n)), np.zeros((nodes, 6, self.n))
        node_jacobians(self.model, self._data, jacobian, rate)
        for k in range(nodes):
            pose = np.eye(4)
            pose[:3, :3] = self._data.rotation[k].reshape(3, 3)
            pose[:3, 3] = self._data.position[k]
            to_body = se3.Ad(se3.inverse(pose))
            jacobian[k], spatial = to_body @ jacobian[k], to_body @ rate[k]
            rate[k] = spatial - se3.ad(self._data.eta[k]) @ jacobian[k]
        return jacobian, rate

    def tip_jacobian(self, q: Floats) -> Floats:
        """Return the body Jacobian (6, n) of the last node: Dynamics of Soft Robots (1.25)."""
        return self.jacobians(q, self._zero)[0][-1]

    def tip_jacobians(self, q: Floats) -> Floats:
        """Return the body Jacobians (T, 6, n) of all tips, ``Compiled.tips``."""
        return self.jacobians(q, self._zero)[0][list(self.compiled.tips)]

    def coriolis_matrix(self, q: Floats, v: Floats) -> Floats:
        """Return C(q, q̇) (n, n), with the null term M ad_η that makes Ṁ − 2C skew.

        Dynamics of Soft Robots (1.33).
        """
        v = self.coordinates(v, "v")
        jacobian, rate = self.jacobians(q, v)
        out = np.zeros((self.n, self.n))
        for k, (mass, *moments) in enumerate(self.model.inertia):
            inertia = np.diag([*moments, mass, mass, mass])
            ad = se3.ad(jacobian[k] @ v)
            gyroscopic = inertia @ ad - ad.T @ inertia
            out += jacobian[k].T @ (inertia @ rate[k] + gyroscopic @ jacobian[k])
        if len(self.model.fluid.node):
            out += added_coriolis(self.model.fluid, jacobian, rate, v)
        return out

    def mass_matrix_derivative(self, q: Floats) -> Floats:
        """Return ∂M_ij/∂q_k as [i, j, k] (n, n, n), exact.

        The residual is linear in q̈ with matrix M, so M's derivative along q̈ is the difference of
        two tangents.
        """
        data = self.forcing(share=0.0)
        out = np.zeros((self.n, self.n, self.n))
        # accelerations whose forces are of the size of the elastic ones, to limit round-off
        law = np.abs(np.diag(self.stiffness_matrix()))
        mass = np.diag(self.mass_matrix(q))
        size = np.where(law > 0.0, law, mass) / mass
        for j, a in enumerate(np.diag(size)):
            for sign in (0.5, -0.5):
                self.residual(q, self._zero, sign * a, data)
                out[:, j] += 2.0 * sign * self.last_tangent((1.0, 0.0, 0.0))
            out[:, j] /= size[j]
        return 0.5 * (out + out.transpose(1, 0, 2))

    def christoffel_symbols(self, q: Floats) -> Floats:
        """Return c_ijk = ½(∂M_ij/∂q_k + ∂M_ik/∂q_j − ∂M_jk/∂q_i) (n, n, n) of the first kind."""
        slope = self.mass_matrix_derivative(q)
        return 0.5 * (slope + slope.transpose(0, 2, 1) - slope.transpose(2, 0, 1))

    def christoffel_matrix(self, q: Floats, v: Floats) -> Floats:
        """Return C_ij = Σ_k c_ijk q̇_k (n, n).

        The other Coriolis matrix that makes Ṁ − 2C skew, the one behind Dynamics of Soft Robots,
        (1.43). It agrees with ``coriolis_matrix`` on q̇, not on other vectors, and costs 2n
        tangents.
        """
        return self.christoffel_symbols(q) @ self.coordinates(v, "v")

    def internal_wrench(
        self,
        q: Floats,
        v: Floats | None = None,
        a: Floats | None = None,
        *,
        time: float = 0.0,
        tip: Floats | None = None,
        tip_follows: bool = False,
    ) -> InternalWrench:
        """Return the internal wrench on both sides of every node.

        Θ of Curvilinear Systems 2006 (2.1), Λ of Dynamics of Soft Robots (1.19).

        Parameters
        ----------
        q, v, a : (n,) a motion; at rest by default
        time : s at which scheduled loads are taken
        tip : (6,) moment and force at the tip along world axes, or (``tip_follows``) its own

        Notes
        -----
        It balances masses and loads beyond the section, so it does not depend on the section law.
        For fixed strains it contains the reaction (the Lagrange multipliers of Curvilinear Systems
        2006), at joints it is the whole wrench of the joint with its effort, and along a rod it is
        the sum of section *and* tendons. It is exact at the ends of elements and converges with the
        nodes inside. If (q, v, a) does not solve the equations of motion (a ≠ ``forward_dynamics``,
        or no equilibrium), the wrench includes the residual forces that the motion would need.
        """
        refuse_constraints(self.compiled.scene, "the internal wrench")
        v, a = (self._zero if x is None else x for x in (v, a))
        data = self.forcing(None, time, 1.0, tip, tip_follows)
        self.residual(q, v, a, data)
        return internal_wrench(self.compiled, data, time)

    def _law(self, values: Floats) -> Floats:
        """Return a sparse law as a matrix (n, n)."""
        out = np.zeros((self.n, self.n))
        rows = np.repeat(np.arange(self.n), np.diff(self.model.law_ptr))
        out[rows, self.model.law_col] = values
        return out
