"""The equations of the continuum as residuals, which vanish along a true motion.

They are Dynamics of Soft Robots (1.9) and (1.20).

The functions at the top are the equations at a point, for arrays of points (…, 6); nothing of the
discrete model is in them. ``fields`` evaluates a discrete solution for them, element by element:
the frames, twists and accelerations of the nodes, the strain field ξ₀ + Φ q, and the wrench that
the section law gives for it. Slopes are those of the polynomials through the nodes. The residuals
are then the error of the discretisation, in both its parts: Dynamics of Soft Robots (1.9) is
violated where segments are too long, (1.20) where the basis is too poor, since a Galerkin solution
balances wrenches only on average.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.compile.element import Element
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.quadrature import derivative, lobatto
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import ChamberActuator, DistributedLoad, MomentActuator, Scene
from soft_sim_ros.scene.strains import STRAINS
from soft_sim_ros.scene.tendon import Routed

from .dynamics import Dynamics
from .fluid import densities
from .history import (
    materials,
    refuse_branches,
    refuse_constraints,
    refuse_custom,
    refuse_environment,
    refuse_tendons,
)

FORM = "the field equations"


def bracket(x: Floats, y: Floats) -> Floats:
    """Return ad_x y = [x, y] of twists (…, 6)."""
    angular = np.cross(x[..., :3], y[..., :3])
    linear = np.cross(x[..., :3], y[..., 3:]) + np.cross(x[..., 3:], y[..., :3])
    return np.concatenate([angular, linear], axis=-1)


def cobracket(x: Floats, wrench: Floats) -> Floats:
    """Return ad_xᵀ Λ of twists and wrenches (…, 6): Boyer & Primault 2005 (3.6)."""
    moment = np.cross(wrench[..., :3], x[..., :3]) + np.cross(wrench[..., 3:], x[..., 3:])
    return np.concatenate([moment, np.cross(wrench[..., 3:], x[..., :3])], axis=-1)


def pose_residual(pose: Floats, pose_slope: Floats, strain: Floats) -> Floats:
    """Return (g⁻¹ g′)ᵛ − ξ (…, 6): the first row of Dynamics of Soft Robots (1.9)."""
    turn = np.swapaxes(pose[..., :3, :3], -1, -2)
    curl = turn @ pose_slope[..., :3, :3]
    shift = np.einsum("...ij,...j->...i", turn, pose_slope[..., :3, 3])
    curvature = [curl[..., i, j] - curl[..., j, i] for i, j in ((2, 1), (0, 2), (1, 0))]
    out: Floats = np.concatenate([0.5 * np.stack(curvature, axis=-1), shift], axis=-1) - strain
    return out


def twist_residual(
    strain: Floats, strain_rate: Floats, twist: Floats, twist_slope: Floats
) -> Floats:
    """Return η′ + ad_ξ η − ξ̇ (…, 6): the second row of Dynamics of Soft Robots (1.9)."""
    return twist_slope + bracket(strain, twist) - strain_rate


def acceleration_residual(
    strain: Floats,
    strain_rate: Floats,
    strain_acceleration: Floats,
    twist: Floats,
    acceleration: Floats,
    acceleration_slope: Floats,
) -> Floats:
    """Return η̇′ + ad_ξ̇ η + ad_ξ η̇ − ξ̈ (…, 6): the third row of Dynamics of Soft Robots (1.9)."""
    turned = bracket(strain_rate, twist) + bracket(strain, acceleration)
    return acceleration_slope + turned - strain_acceleration


def balance_residual(
    strain: Floats,
    wrench: Floats,
    wrench_slope: Floats,
    inertia: Floats,
    twist: Floats,
    acceleration: Floats,
    load: Floats,
) -> Floats:
    """Return 𝓜 η̇ − ad_ηᵀ 𝓜 η − Λ′ + ad_ξᵀ Λ − F (…, 6).

    Dynamics of Soft Robots (1.20), Curvilinear Systems 2006 (2.1), Boyer & Primault 2005 (3.15).

    ``inertia`` (…, 6) is the diagonal of 𝓜 in kg·m and kg/m, ``load`` (…, 6) the wrench F per
    length, weight included, in section axes.
    """
    inertial = inertia * acceleration - cobracket(twist, inertia * twist)
    return inertial - wrench_slope + cobracket(strain, wrench) - load


class Field(NamedTuple):
    """The fields of a discrete solution at the N nodes of one element, in section axes.

    Wrench components of strains that are held fixed are reactions: what balances the masses and
    loads beyond.
    """

    s: Floats  # (N,) arc length in the rod, m
    slope: Floats  # (N, N) from values at the nodes to d/ds
    weights: Floats  # (N,) of the quadrature over the nodes, m
    pose: Floats  # (N, 4, 4) in the world
    strain: Floats  # (N, 6) ξ
    strain_rate: Floats  # (N, 6) ξ̇
    strain_acceleration: Floats  # (N, 6) ξ̈
    twist: Floats  # (N, 6) η
    acceleration: Floats  # (N, 6) η̇
    wrench: Floats  # (N, 6) Λ: section law and actuators
    load: Floats  # (N, 6) F per length: weight, distributed loads, mass damping, fluid
    inertia: Floats  # (N, 6) diagonal of 𝓜


class Residuals(NamedTuple):
    """Residuals of Dynamics of Soft Robots (1.20) at the nodes of an element, (N, 6) each."""

    pose: Floats
    twist: Floats
    acceleration: Floats
    balance: Floats


def residuals(field: Field) -> Residuals:
    """Return the residuals of all four equations of the continuum along an element."""
    d, x, rate, eta = field.slope, field.strain, field.strain_rate, field.twist
    pose_slope = np.tensordot(d, field.pose, axes=1)
    acc = field.acceleration
    return Residuals(
        pose_residual(field.pose, pose_slope, x),
        twist_residual(x, rate, eta, d @ eta),
        acceleration_residual(x, rate, field.strain_acceleration, eta, acc, d @ acc),
        balance_residual(x, field.wrench, d @ field.wrench, field.inertia, eta, acc, field.load),
    )


def norms(parts: list[Field]) -> Residuals:
    """Return the root mean squares over all nodes of ``parts``, by kind and component (6,)."""
    length = sum(float(part.weights.sum()) for part in parts)
    each = [[part.weights @ row**2 for row in residuals(part)] for part in parts]
    return Residuals(
        *(np.sqrt(np.sum(column, axis=0) / length) for column in zip(*each, strict=True))
    )


def fields(
    dynamics: Dynamics,
    q: Floats,
    v: Floats | None = None,
    a: Floats | None = None,
    *,
    efforts: Floats | None = None,
    time: float = 0.0,
) -> list[Field]:
    """Return the fields of a motion, one ``Field`` for each element of every rod, base to tip.

    Parameters
    ----------
    q, v, a : (n,) coordinates, rates and accelerations; at rest by default
    efforts : (A,) actuator efforts in scene order
    time : s at which scheduled loads are taken

    Raises
    ------
    SceneError
        for hyperelastic materials, Maxwell branches and tendons with friction or commanded lengths:
        their Λ is not a function of ξ, ξ̇ and efforts here.
    """
    _check(dynamics.compiled.scene)
    zero = np.zeros(dynamics.n)
    v, a = zero if v is None else v, zero if a is None else a
    effort = np.zeros(dynamics.actuators) if efforts is None else np.asarray(efforts)
    jacobian, rate = dynamics.jacobians(q, v)
    poses, twists = dynamics.node_poses(q), jacobian @ v
    accelerations = jacobian @ a + rate @ v
    reaction = dynamics.internal_wrench(q, v, a, time=time)
    wet = densities(dynamics.compiled, dynamics._data) if dynamics.compiled.scene.fluid else {}
    out = []
    for rod_map in dynamics.compiled.chain.rods.values():
        active = [STRAINS.index(name) for name in rod_map.rod.strains]
        for element in rod_map.elements:
            x, weights = lobatto(element.nodes)
            begin, end = element.span
            s = begin + (end - begin) * x
            at = slice(element.first_segment, element.first_segment + len(x))
            strain, strain_rate, strain_acceleration = _strains(element, s, (q, v, a))
            wrench = np.concatenate(
                [reaction.after[at][:-1], reaction.before[at][-1:]]
            )  # limits at the ends, taken from inside the element
            law = _law(element, s, strain, strain_rate)
            law += _actuation(dynamics, rod_map.rod.name, element, s, strain, effort)
            wrench[:, active] = law[:, active]
            mass, *moments = element.section.inertia(element.normalised(s)).T
            inertia = np.stack([*moments, mass, mass, mass], axis=1)
            out.append(
                Field(
                    s,
                    derivative(x) / (end - begin),
                    weights * (end - begin),
                    poses[at],
                    strain,
                    strain_rate,
                    strain_acceleration,
                    twists[at],
                    accelerations[at],
                    wrench,
                    _loads(dynamics, rod_map.rod.name, element, mass, poses[at], time)
                    - element.section.material.mass_damping * inertia * twists[at]
                    - wet.get(element.first_segment, 0.0),
                    inertia,
                )
            )
    return out


def _strains(element: Element, s: Floats, coordinates: tuple[Floats, ...]) -> Floats:
    """Return ξ, ξ̇, ξ̈ (3, N, 6) at arc lengths s of the rod."""
    out = np.zeros((3, len(s), 6))
    out[0] = element.section.strain0(element.normalised(s))
    for columns in element.columns:
        component, first, count = columns
        phi = element.values(columns, s)
        for order, values in enumerate(coordinates):
            out[order, :, component] += phi @ values[first : first + count]
    return out


def _law(element: Element, s: Floats, strain: Floats, strain_rate: Floats) -> Floats:
    """Return H (ξ − ξ₀) + Γ ξ̇ (N, 6)."""
    section, x = element.section, element.normalised(s)
    stiffness, damping, _ = section.laws(x)
    out: Floats = np.einsum("kij,kj->ki", stiffness, strain - section.strain0(x))
    return out + np.einsum("kij,kj->ki", damping, strain_rate)


def _actuation(
    dynamics: Dynamics, rod: str, element: Element, s: Floats, strain: Floats, effort: Floats
) -> Floats:
    """Return the share of moments, tendons and chambers in the internal wrench (N, 6)."""
    out = np.zeros((len(s), 6))
    middle = 0.5 * sum(element.span)
    for size, actuator in zip(effort, dynamics.compiled.scene.actuators, strict=True):
        if isinstance(actuator, MomentActuator):
            if (actuator.rod, actuator.section) == (rod, element.section.name):
                out[:, STRAINS.index(actuator.strain)] -= size
        elif isinstance(actuator, Routed):
            if isinstance(actuator, ChamberActuator):
                size = -size * actuator.area  # pressure acts as a negative tension
            if stretch := actuator.along(rod, middle):
                d = stretch.offset(s)
                along = strain[:, 3:] + np.cross(strain[:, :3], d) + stretch.slope(s)
                pull = size * along / np.linalg.norm(along, axis=1, keepdims=True)
                out += np.concatenate([np.cross(d, pull), pull], axis=1)
    return out


def _loads(
    dynamics: Dynamics, rod: str, element: Element, mass: Floats, pose: Floats, time: float
) -> Floats:
    """Return weight and distributed loads per length (N, 6) in section axes."""
    scene, middle = dynamics.compiled.scene, 0.5 * sum(element.span)
    out = np.zeros((len(mass), 6))
    world = np.zeros((len(mass), 2, 3))
    world[:, 1] = mass[:, None] * scene.gravity
    for load in scene.loads:
        if not (isinstance(load, DistributedLoad) and load.body == rod):
            continue
        if load.start < middle < load.end:
            share = load.schedule.factor(time)
            if load.frame == "world":
                world += share * np.array([load.moment, load.force])
            else:
                out += share * np.concatenate([load.moment, load.force])
    turned = np.einsum("kji,klj->kli", pose[:, :3, :3], world)
    return out + turned.reshape(-1, 6)


def _check(scene: Scene) -> None:
    """Refuse scenes whose Λ is not a function of ξ, ξ̇ and efforts only."""
    refuse_branches(scene, FORM)
    refuse_tendons(scene, FORM)
    refuse_custom(scene, FORM)
    refuse_environment(scene, FORM)
    refuse_constraints(scene, FORM)
    for material in materials(scene):
        if material.law is not None:
            value = type(material.law).__name__
            raise SceneError(
                scene.file, f"materials.{material.name}.law", value, f"no such key in {FORM}"
            )
