"""The same residual once more, in the fixed frame: Boyer & Primault 2005 (2.29), (2.30).

``recursion/rnea.py`` works in section frames (B's material formulation, (2.26)): twists are carried
from frame to frame and wrenches carried back. Here every twist, momentum and wrench is taken about
the origin of the base frame along its axes (the spatial formulation). Nothing has to be carried
then: twists add up from the base, wrenches add up from the tips, and the balance of a node is that
of Newton and Euler,

    V_{k+1} = V_p + U_k,  U_k = Ad_{g_p} T(−Ω_k) Ω̇_k,
    F_k = d/dt (I_k V_k) − loads,  S_p = F_p + Σ S_{k+1},

segment k going from node p to node k + 1, with I = Ad⁻ᵀ 𝓜 Ad⁻¹, which moves: that motion is B's
defect of symmetry Z_g(𝓛). The two formulations share the model (strains at the Gauss points, lumped
inertia, the section law) and the exponential map, not the recursion. This one is written to be read
and compared, not to be fast.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.algebra.dual import load_twist, store_twist
from soft_sim_ros.core.algebra.rotation import stumpff, tangent_apply
from soft_sim_ros.core.backend.jit import unit
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import origins
from soft_sim_ros.core.recursion.rnea import inverse_dynamics as material_inverse_dynamics

from .dynamics import Dynamics
from .history import refuse_constraints, refuse_custom, refuse_environment
from .spatial_fluid import fluid_wrenches


class SpatialMotion(NamedTuple):
    """Motion and forces of all nodes in the base frame, about its origin.

    Moments first, as everywhere.
    """

    pose: Floats  # (nodes, 4, 4)
    twist: Floats  # (nodes, 6) V = (ġ g⁻¹)ᵛ
    rate: Floats  # (nodes, 6) V̇
    force: Floats  # (nodes, 6) d/dt (I V) − weight − loads of each node
    wrench: Floats  # (nodes, 6) sum of ``force`` of a node and of all beyond it


@unit
def _segment_velocity(x, out):
    """Fill out (2, 6) with T(Ω) Ω̇ and its rate for x (3, 6) = Ω, Ω̇, Ω̈."""
    o = load_twist(x[0])
    c = stumpff(o[0][0] ** 2 + o[0][1] ** 2 + o[0][2] ** 2)
    velocity, rate = tangent_apply(o, load_twist(x[1]), load_twist(x[2]), c)
    store_twist(out[0], velocity)
    store_twist(out[1], rate)


def segment_twists(
    dynamics: Dynamics, k: int, coordinates: tuple[Floats, Floats, Floats]
) -> tuple[Floats, Floats]:
    """Return ξ, ξ̇, ξ̈ at the Gauss points (3, 2, 6) and Ω, Ω̇, Ω̈ (3, 6) of segment k."""
    model = dynamics.model
    xi = np.zeros((3, 2, 6))
    xi[0] = model.xi0[k]
    for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
        for order, values in enumerate(coordinates):
            xi[order, :, model.entry_comp[e]] += model.entry_phi[e] * values[model.entry_col[e]]
    (x1, x2), (u1, u2), (z1, z2) = xi

    def bracket(x: Floats, y: Floats) -> Floats:
        return se3.ad(x) @ y

    omega = model.half[k] * xi.sum(axis=1)
    omega[0] += model.kappa[k] * bracket(x1, x2)
    omega[1] += model.kappa[k] * (bracket(u1, x2) + bracket(x1, u2))
    omega[2] += model.kappa[k] * (bracket(z1, x2) + 2.0 * bracket(u1, u2) + bracket(x1, z2))
    return xi, omega


def motion(
    dynamics: Dynamics,
    q: Floats,
    v: Floats,
    a: Floats,
    efforts: Floats | None = None,
    time: float = 0.0,
) -> SpatialMotion:
    """Return the motion (q, q̇, q̈) of all nodes in the base frame, and the forces it needs."""
    model = dynamics.model
    nodes = len(model.inertia)
    pose, twist, rate = np.zeros((nodes, 4, 4)), np.zeros((nodes, 6)), np.zeros((nodes, 6))
    pose[0] = np.eye(4)
    local = np.zeros((2, 6))
    begins = origins(model)
    for k, p in enumerate(begins):
        omega = segment_twists(dynamics, k, (q, v, a))[1]
        _segment_velocity(-omega, local)  # T(−Ω) Ω̇ and its rate, of the other sign
        carry = se3.Ad(pose[p])
        step = carry @ -local[0]
        twist[k + 1] = twist[p] + step
        rate[k + 1] = rate[p] + carry @ -local[1] + se3.ad(twist[p]) @ step
        pose[k + 1] = pose[p] @ se3.exp(omega[0])
    force = np.stack(
        [_momentum_rate(*row) for row in zip(model.inertia, pose, twist, rate, strict=True)]
    )
    force -= external_wrenches(dynamics, pose, efforts, time)
    if len(model.fluid.node):
        force -= fluid_wrenches(model, dynamics.forcing(efforts, time), pose, twist, rate)
    wrench = force.copy()
    for k in range(nodes - 2, -1, -1):
        wrench[begins[k]] += wrench[k + 1]
    return SpatialMotion(pose, twist, rate, force, wrench)


def _momentum_rate(inertia: Floats, pose: Floats, twist: Floats, rate: Floats) -> Floats:
    """Return d/dt (I V) (6,) of one node, by Newton and Euler about a fixed point."""
    rotation, p = pose[:3, :3], pose[:3, 3]
    spin = twist[:3]
    velocity = twist[3:] + np.cross(spin, p)
    acceleration = rate[3:] + np.cross(rate[:3], p) + np.cross(spin, velocity)
    central = rotation @ np.diag(inertia[1:]) @ rotation.T
    push = inertia[0] * acceleration
    turn = central @ rate[:3] + np.cross(spin, central @ spin)
    return np.concatenate([turn + np.cross(p, push), push])


def external_wrenches(
    dynamics: Dynamics, pose: Floats, efforts: Floats | None = None, time: float = 0.0
) -> Floats:
    """Return weight and loads of all nodes (nodes, 6) about the origin of the base frame."""
    refuse_custom(dynamics.compiled.scene, "the spatial formulation")
    refuse_environment(dynamics.compiled.scene, "the spatial formulation")
    refuse_constraints(dynamics.compiled.scene, "the spatial formulation")
    data = dynamics.forcing(efforts, time)
    out = np.zeros((len(pose), 6))
    for k, frame in enumerate(pose):
        rotation, p = frame[:3, :3], frame[:3, 3]
        force = dynamics.model.inertia[k, 0] * data.gravity
        moment = np.zeros(3)
        if data.active[0]:
            force, moment = force + data.dead[k, 3:], moment + data.dead[k, :3]
        if data.active[1]:
            force = force + rotation @ data.follower[k, 3:]
            moment = moment + rotation @ data.follower[k, :3]
        out[k] = np.concatenate([moment + np.cross(p, force), force])
    return out


def inverse_dynamics(
    dynamics: Dynamics,
    q: Floats,
    v: Floats,
    a: Floats,
    efforts: Floats | None = None,
    time: float = 0.0,
) -> Floats:
    """Return the residual (n,) of ``Dynamics.inverse_dynamics`` by the spatial formulation.

    Parameters
    ----------
    dynamics : Dynamics
    q, v, a : (n,) coordinates, rates and accelerations
    efforts : (A,) actuator efforts in scene order
    time : s at which scheduled loads are taken
    """
    model = dynamics.model
    wrench = motion(dynamics, q, v, a, efforts, time)
    out = _internal_forces(dynamics, q, v, efforts)
    begins = origins(model)
    for k in range(len(model.half)):
        if model.entry_ptr[k + 1] == model.entry_ptr[k]:
            continue
        xi, omega = segment_twists(dynamics, k, (q, v, a))
        dual = (se3.Ad(wrench.pose[begins[k]]) @ se3.left_tangent(omega[0])).T @ wrench.wrench[
            k + 1
        ]
        x1, x2 = xi[0]
        by_point = (
            model.half[k] * dual - model.kappa[k] * se3.coad(x2) @ dual,
            model.half[k] * dual + model.kappa[k] * se3.coad(x1) @ dual,
        )
        for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
            comp = model.entry_comp[e]
            for phi, values in zip(model.entry_phi[e], by_point, strict=True):
                out[model.entry_col[e]] += phi * values[comp]
    return out


def _internal_forces(dynamics: Dynamics, q: Floats, v: Floats, efforts: Floats | None) -> Floats:
    """Return section law, joint law and actuators (n,).

    Stress and strain transform together when the frame changes, so their product is the same in
    both formulations.
    """
    data = dynamics.forcing(efforts, share=1.0)
    data.gravity[:] = 0.0
    data.active[:] = 0
    model = dynamics.model
    dry = model.fluid._replace(node=np.zeros(0, dtype=np.int64))
    massless = model._replace(inertia=np.zeros_like(model.inertia), fluid=dry)
    out = np.zeros(dynamics.n)
    material_inverse_dynamics(massless, data, q, v, np.zeros(dynamics.n), out)
    return out
