"""Materials: isotropic, linear elastic, with Kelvin–Voigt viscosity."""

from __future__ import annotations

from dataclasses import dataclass

from soft_sim_ros.scene.interval import NONNEGATIVE, POSITIVE, Interval
from soft_sim_ros.scene.reader import Reader

POISSON = Interval.parse("(-1, 0.5]")
ROUNDING = 1e-6  # a shear modulus E/3 written with seven digits is still incompressible


@dataclass(frozen=True)
class Material:
    """Moduli in Pa, density in kg/m³, viscosities in Pa·s (stress per strain rate).

    ``viscosity`` acts on shear strain rates (torsion, shear), ``axial_viscosity`` on normal ones
    (bending, stretch).
    """

    name: str
    young_modulus: float
    shear_modulus: float
    density: float
    viscosity: float
    axial_viscosity: float

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio E/(2G) - 1."""
        return self.young_modulus / (2.0 * self.shear_modulus) - 1.0

    @property
    def retardation_time(self) -> float:
        """Viscosity over shear modulus, in s."""
        return self.viscosity / self.shear_modulus


def read_material(reader: Reader, name: str) -> Material:
    """Read one entry of ``materials``."""
    reader.only(
        "young_modulus", "poisson_ratio", "shear_modulus", "density", "viscosity", "axial_viscosity"
    )
    young = reader.number("young_modulus", POSITIVE)
    if reader.one_of(("poisson_ratio", "shear_modulus")) == "poisson_ratio":
        shear = young / (2.0 * (1.0 + reader.number("poisson_ratio", POISSON)))
    else:
        shear = reader.number("shear_modulus", POSITIVE)
        if shear < young / 3.0 * (1.0 - ROUNDING):
            expected = f"a number >= young_modulus/3 = {young / 3:g} (Poisson's ratio <= 0.5)"
            reader.refuse(expected, "shear_modulus")
    density = reader.number("density", POSITIVE)
    viscosity = reader.number("viscosity", NONNEGATIVE, default=0.0)
    # By default one retardation time rules all strains, as for a material whose whole
    # stress relaxes alike; incompressible, this is Trouton's 3·viscosity.
    axial = reader.number("axial_viscosity", NONNEGATIVE, default=viscosity * (young / shear))
    return Material(name, young, shear, density, viscosity, axial)
