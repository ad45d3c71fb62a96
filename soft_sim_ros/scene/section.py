"""Sections: stretches of a rod with one material and smoothly varying data.

The section law is linear: the wrench is stiffness·(ξ - ξ₀) + damping·ξ̇, per reference arc length
and with the reference cross-section (stretching a section does not thin it). A material with a law
replaces the elastic part of torsion, bending and stretch by the sum over its fibres.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from soft_sim_ros.scene.cross_section import CrossSection, dimensions
from soft_sim_ros.scene.fluid import RodFluid
from soft_sim_ros.scene.given import Given
from soft_sim_ros.scene.material import Material
from soft_sim_ros.scene.profile import Profile
from soft_sim_ros.scene.reference import Reference
from soft_sim_ros.scene.rod_model import COSSERAT, RodModel
from soft_sim_ros.scene.strains import STRAINS
from soft_sim_ros.scene.taper import Floats


@dataclass(frozen=True)
class Section:
    """Length in m, material, cross-section, reference shape, model of its rod, data given instead.

    All functions take normalised arc lengths x (…) in [0, 1]. ``shear_correction`` (k_y, k_z)
    overrides the factors of the cross-section. At ``cuts`` the data change too fast for one element
    (features.py).
    """

    name: str
    length: float
    material: Material
    cross_section: CrossSection
    reference: Reference = Reference()  # noqa: RUF009 - it is immutable
    shear_correction: tuple[float, float] | None = None
    model: RodModel = COSSERAT
    given: Given = field(default_factory=Given)
    cuts: tuple[float, ...] = ()
    fluid: RodFluid = field(default_factory=RodFluid)

    @property
    def profiles(self) -> list[Profile]:
        """Everything that varies along the section."""
        return [
            *dimensions(self.cross_section), *self.reference.profiles, *self.given.profiles,
        ]  # fmt: skip

    @property
    def knots(self) -> tuple[float, ...]:
        """Places x in (0, 1) where a derivative of the data jumps: quadrature stops there."""
        return tuple(sorted({x for profile in self.profiles for x in profile.knots}))

    @property
    def kinks(self) -> tuple[float, ...]:
        """Places x in (0, 1) where the slope of the data jumps: the rod is cut there, too."""
        return tuple(sorted({x for profile in self.profiles for x in profile.kinks}))

    def stiffness(self, x: Floats) -> Floats:
        """Return (…, 6): G·I_t, E·I_y, E·I_z in N·m², E·A, k_y·G·A, k_z·G·A in N, at rest."""
        law = self._law(x, self.material.young_modulus, self.material.shear_modulus)
        return self._limp(self.given.put(law, self.given.stiffness, x))

    def damping(self, x: Floats) -> Floats:
        """Return (…, 6): Kelvin–Voigt damping, laid out as the stiffness, N·m²·s and N·s."""
        material = self.material
        law = self._law(x, material.axial_viscosity, material.viscosity)
        if self.given.stiffness and material.stiffness_damping > 0.0:
            # Rayleigh's β goes with the stiffness that is there, not with that of the shape
            shape = self._law(x, material.young_modulus, material.shear_modulus)
            law += material.stiffness_damping * (self.stiffness(x) - shape)
        return self._limp(self.given.put(law, self.given.damping, x))

    def coupling(self, x: Floats) -> Floats:
        """Return (…, 6, 6): stiffness between different strains, symmetric, diagonal 0."""
        x = np.asarray(x, dtype=float)
        out = np.zeros((*x.shape, 6, 6))
        for (i, j), profile in self.given.coupling.items():
            out[..., i, j] = out[..., j, i] = profile(x)
        return out

    def laws(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """Return H, Γ and the stiffness of the Maxwell branch as matrices (…, 6, 6).

        H is without what the fibres of a law contribute.
        """
        stiffness, loss, coupling = self.stiffness(x), self.damping(x), self.coupling(x)
        branch = self.material.maxwell
        whole = stiffness[..., None] * np.eye(6) + coupling
        lost = self.material.stiffness_damping * coupling
        for given in self.given.damping:  # it stands for all the damping of that strain
            lost[..., given, :] = lost[..., :, given] = 0.0
        linear = whole.copy()
        if self.material.law is not None:
            linear[..., :4, :4] = 0.0
        damping = loss[..., None] * np.eye(6) + lost
        return linear, damping, (branch.ratio if branch else 0.0) * whole

    def inertia(self, x: Floats) -> Floats:
        """Return (…, 4) per arc length: ρA in kg/m, ρ(I_y + I_z), ρI_y, ρI_z in kg·m.

        Without what the model of the rod leaves out.
        """
        x = np.asarray(x, dtype=float)
        about_y, about_z = self.cross_section.second_moments(x)
        area = self.cross_section.area(x)
        rows = [area, about_y + about_z, about_y, about_z]
        inertia = self.material.density * np.stack(rows, axis=-1)
        self.given.put(inertia, self.given.inertia, x)
        tilt, turn = self.model.rotary
        return inertia * [True, turn, tilt, tilt]

    def mass_damping(self, x: Floats) -> Floats:
        """Return (…, 4) Rayleigh's α times the inertia: kg/(m·s) and kg·m/s."""
        return self.material.mass_damping * self.inertia(x)

    def fibres(self, x: Floats) -> Floats:
        """Return (…, F, 4): y, z in m, area in m², (γ/K_x)² in m² of the fibres of the section.

        γ is the shear of a fibre under the twist K_x. For circles and tubes it is exact; other
        sections warp, and γ² = K_x² (y² + z²) I_t/(I_y + I_z) gives them their torsion constant.
        """
        x = np.asarray(x, dtype=float)
        points = self.cross_section.fibres(x)
        share = self.cross_section.torsion_constant(x) / sum(self.cross_section.second_moments(x))
        twist = share[..., None] * (points[..., 0] ** 2 + points[..., 1] ** 2)
        return np.concatenate([points, twist[..., None]], axis=-1)

    def strain0(self, x: Floats) -> Floats:
        """Return the reference strain ξ₀ (…, 6)."""
        return self.reference.strain(np.asarray(x, dtype=float))

    def shear_factors(self, x: Floats) -> tuple[Floats, Floats]:
        """Return (k_y, k_z) in use."""
        if self.shear_correction is None:
            return self.cross_section.shear_factors(x, self.material.poisson_ratio)
        ky, kz = self.shear_correction
        return np.full(np.shape(x), ky), np.full(np.shape(x), kz)

    def _law(self, x: Floats, axial: float, shear: float) -> Floats:
        """Put a modulus (Pa) or a viscosity (Pa·s) through the cross-section."""
        x = np.asarray(x, dtype=float)
        area = self.cross_section.area(x)
        about_y, about_z = self.cross_section.second_moments(x)
        ky, kz = self.shear_factors(x)
        twist = shear * self.cross_section.torsion_constant(x)
        rows = [twist, axial * about_y, axial * about_z, axial * area]
        return np.stack([*rows, ky * shear * area, kz * shear * area], axis=-1)

    def _limp(self, law: Floats) -> Floats:
        """Take out of a law what the model of the rod has none of."""
        law[..., [STRAINS.index(strain) for strain in self.model.limp]] = 0.0
        return law
