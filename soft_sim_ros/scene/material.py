"""Materials: isotropic, linear or hyperelastic, with Kelvin–Voigt and Rayleigh damping."""

from __future__ import annotations

from dataclasses import dataclass

from soft_sim_ros.scene.interval import NONNEGATIVE, POSITIVE, Interval
from soft_sim_ros.scene.law import Law, read_law
from soft_sim_ros.scene.reader import Reader

POISSON = Interval.parse("(-1, 0.5]")
ROUNDING = 1e-6  # a shear modulus E/3 written with seven digits is still incompressible


@dataclass(frozen=True)
class Maxwell:
    """A spring of ``ratio`` times the stiffness at rest, in series with a dashpot.

    Its stress relaxes with ``time`` in s.
    """

    ratio: float
    time: float


@dataclass(frozen=True)
class Material:
    """Moduli in Pa, density in kg/m³, viscosities in Pa·s (stress per strain rate).

    ``viscosity`` acts on shear strain rates (torsion, shear), ``axial_viscosity`` on normal ones
    (bending, stretch); Rayleigh's damping proportional to stiffness is in both. ``mass_damping``
    is Rayleigh's α in 1/s, ``stiffness_damping`` his β in s. A ``law`` rules bending,
    stretch and torsion; the moduli then are those of small strains.
    """

    name: str
    young_modulus: float
    shear_modulus: float
    density: float
    viscosity: float
    axial_viscosity: float
    mass_damping: float = 0.0
    stiffness_damping: float = 0.0
    law: Law | None = None
    maxwell: Maxwell | None = None

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
        "young_modulus", "poisson_ratio", "shear_modulus", "law", "density", "viscosity",
        "axial_viscosity", "rayleigh", "maxwell",
    )  # fmt: skip
    law = read_law(reader.mapping("law")) if reader.has("law") else None
    young, shear = _read_moduli(reader, law)
    density = reader.number("density", POSITIVE)
    viscosity = reader.number("viscosity", NONNEGATIVE, default=0.0)
    # By default one retardation time rules all strains, as for a material whose whole
    # stress relaxes alike; incompressible, this is Trouton's 3·viscosity.
    axial = reader.number("axial_viscosity", NONNEGATIVE, default=viscosity * (young / shear))
    rayleigh = reader.mapping("rayleigh").only("mass", "stiffness")
    mass = rayleigh.number("mass", NONNEGATIVE, default=0.0)
    stiffness = rayleigh.number("stiffness", NONNEGATIVE, default=0.0)
    return Material(
        name=name,
        young_modulus=young,
        shear_modulus=shear,
        density=density,
        viscosity=viscosity + stiffness * shear,
        axial_viscosity=axial + stiffness * young,
        mass_damping=mass,
        stiffness_damping=stiffness,
        law=law,
        maxwell=_read_maxwell(reader),
    )


def _read_maxwell(reader: Reader) -> Maxwell | None:
    if not reader.has("maxwell"):
        return None
    branch = reader.mapping("maxwell").only("ratio", "time")
    return Maxwell(branch.number("ratio", POSITIVE), branch.number("time", POSITIVE))


def _read_moduli(reader: Reader, law: Law | None) -> tuple[float, float]:
    """Return Young's modulus and the shear modulus."""
    if law is not None:
        for key in ("young_modulus", "poisson_ratio", "shear_modulus"):
            reader.no_effect(key, "the law gives the moduli, incompressible")
        return law.young_modulus, law.shear_modulus
    young = float(reader.number("young_modulus", POSITIVE))
    if reader.one_of(("poisson_ratio", "shear_modulus")) == "poisson_ratio":
        return young, young / (2.0 * (1.0 + reader.number("poisson_ratio", POISSON)))
    shear = float(reader.number("shear_modulus", POSITIVE))
    if shear < young / 3.0 * (1.0 - ROUNDING):
        expected = (
            f"a number >= young_modulus/3 = {young / 3:g} (Poisson's ratio <= 0.5); a braided or "
            "wound tube is not isotropic: give its sections their stiffness instead, such as "
            "stiffness: {torsion: GJ in N·m²}"
        )
        reader.refuse(expected, "shear_modulus")
    return young, shear
