"""The numbers an engineer looks at first: stiffness, mass, slenderness of every section."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soft_sim_ros.scene.body import FlexibleLink, RigidBody, Rod
from soft_sim_ros.scene.load_scene import Scene
from soft_sim_ros.scene.profile import CHECKED
from soft_sim_ros.scene.section import Section

Ends = tuple[float, float]


class SectionSummary(NamedTuple):
    """One section; pairs are the values at its start and at its end.

    length in m, mass in kg; bending stiffnesses EI and torsional stiffness GJ in N·m²; axial
    stiffness EA and shear stiffnesses GA (with the shear factors in) in N; slenderness: length of
    the whole rod over the smallest radius of gyration of the section; retardation_time:
    viscosity over shear modulus in s.
    """

    rod: str
    section: str
    material: str
    length: float
    mass: float
    EI_y: Ends
    EI_z: Ends
    GJ: Ends
    EA: Ends
    GA_y: Ends
    GA_z: Ends
    slenderness: float
    retardation_time: float


def summary(scene: Scene) -> list[SectionSummary]:
    """Return one row for every section, base to tip."""
    rods = elastic(scene)
    return [_row(rod, section) for rod in rods for section in rod.sections]


def elastic(scene: Scene) -> list[Rod]:
    """Return all rods, those of floating-frame links included, base to tip."""
    rods = [body.rod if isinstance(body, FlexibleLink) else body for body in scene.bodies]
    return [rod for rod in rods if isinstance(rod, Rod)]


def total_mass(scene: Scene) -> float:
    """Return the mass of all rods and rigid bodies in kg."""
    rigid = sum(body.mass for body in scene.bodies if isinstance(body, RigidBody))
    return rigid + sum(row.mass for row in summary(scene))


def _integral(section: Section) -> float:
    """Return the mean mass per length in kg/m: Gauss's rule between the knots of the data."""
    marks = np.array([0.0, *section.knots, 1.0])
    point, weight = np.polynomial.legendre.leggauss(20)
    x = marks[:-1, None] + np.diff(marks)[:, None] * 0.5 * (1.0 + point)
    return float(np.diff(marks) @ (section.inertia(x)[..., 0] @ (0.5 * weight)))


def _row(rod: Rod, section: Section) -> SectionSummary:
    ends = np.array([0.0, 1.0])
    torsion, bend_y, bend_z, stretch, shear_y, shear_z = section.stiffness(ends).T.tolist()
    about_y, about_z = section.cross_section.second_moments(CHECKED)
    gyration = np.sqrt(np.minimum(about_y, about_z) / section.cross_section.area(CHECKED))
    mass = section.length * _integral(section)
    return SectionSummary(
        rod=rod.name,
        section=section.name,
        material=section.material.name,
        length=section.length,
        mass=mass,
        EI_y=tuple(bend_y),
        EI_z=tuple(bend_z),
        GJ=tuple(torsion),
        EA=tuple(stretch),
        GA_y=tuple(shear_y),
        GA_z=tuple(shear_z),
        slenderness=rod.length / float(gyration.min()),
        retardation_time=section.material.retardation_time,
    )
