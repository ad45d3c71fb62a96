"""The numbers an engineer looks at first: stiffness, mass, slenderness of every section."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from soft_sim_ros.scene.body import FlexibleLink, RigidBody, Rod
from soft_sim_ros.scene.fluid import Fluid, outline
from soft_sim_ros.scene.joint import Joint
from soft_sim_ros.scene.load_scene import Scene
from soft_sim_ros.scene.profile import CHECKED
from soft_sim_ros.scene.section import Section
from soft_sim_ros.scene.taper import Floats

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


def in_fluid(scene: Scene) -> str | None:
    """Say in words what surrounds the bodies, and what it does not touch; None: nothing does."""
    fluid, dry, volume = scene.fluid, list[str](), 0.0
    if fluid is None:
        return None
    for body in scene.bodies:
        parts = body.sections if isinstance(body, Rod) and not body.fluid.dry else ()
        dry += [f"{body.name}/{part.name}" for part in parts if part.fluid.dry]
        if isinstance(body, Rod) and parts:
            volume += sum(_displaced(fluid, body, part) for part in parts if not part.fluid.dry)
        elif isinstance(body, RigidBody) and body.fluid is not None:
            volume += body.fluid.volume
        elif not isinstance(body, Joint):
            dry.append(body.name)
    flow = "with a current" if fluid.current else "still"
    mass = (
        f"displaces {fluid.density * volume:.4g} kg of it, bodies have {total_mass(scene):.4g} kg"
    )
    return f"fluid {fluid.density:g} kg/m³, {flow}: {mass}" + (
        f"; it does not touch {', '.join(dry)}" if dry else ""
    )


def _displaced(fluid: Fluid, rod: Rod, section: Section) -> float:
    """Return the volume in m³ that a section of a rod displaces."""

    def area(section: Section, x: Floats) -> Floats:
        shape = outline(section.cross_section, x)
        return fluid.displaced(rod.fluid, section.fluid, shape)

    return section.length * _mean(section, area)


def _density(section: Section, x: Floats) -> Floats:
    return section.inertia(x)[..., 0]


def _mean(section: Section, data: Callable[[Section, Floats], Floats]) -> float:
    """Return the mean of data per length: Gauss's rule between the knots of the section."""
    marks = np.array([0.0, *section.knots, 1.0])
    point, weight = np.polynomial.legendre.leggauss(20)
    x = marks[:-1, None] + np.diff(marks)[:, None] * 0.5 * (1.0 + point)
    values = data(section, x.ravel()).reshape(x.shape)
    return float(np.diff(marks) @ (values @ (0.5 * weight)))


def _row(rod: Rod, section: Section) -> SectionSummary:
    ends = np.array([0.0, 1.0])
    torsion, bend_y, bend_z, stretch, shear_y, shear_z = section.stiffness(ends).T.tolist()
    about_y, about_z = section.cross_section.second_moments(CHECKED)
    gyration = np.sqrt(np.minimum(about_y, about_z) / section.cross_section.area(CHECKED))
    mass = section.length * _mean(section, _density)
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
