"""Cross-sections: areas, second moments, Saint-Venant torsion constants, shear factors.

Every quantity is a function of the normalised arc length x (…) in [0, 1] and has the shape of x.
I_y = ∫z² dA resists bending about y. The shear factors are Cowper's (J. Appl. Mech. 33, 1966),
which depend on Poisson's ratio ν. The torsion constant is the polar moment only for circles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from soft_sim_ros.scene.interval import POSITIVE
from soft_sim_ros.scene.profile import CHECKED, Profile, profile_of
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats

Pair = tuple[Floats, Floats]


class CrossSection(Protocol):
    """What a cross-section has to answer."""

    def area(self, x: Floats) -> Floats:
        """Return the area A in m²."""

    def second_moments(self, x: Floats) -> Pair:
        """Return (I_y, I_z) in m⁴."""

    def torsion_constant(self, x: Floats) -> Floats:
        """Return I_t in m⁴: the torque is G·I_t per twist rate."""

    def shear_factors(self, x: Floats, poisson_ratio: float) -> Pair:
        """Return (k_y, k_z): the shear force along y is k_y·G·A per shear strain."""

    def fibres(self, x: Floats) -> Floats:
        """Return points and weights (…, F, 3) of a rule over the section: y, z in m, area in m²."""


def ring(inner: Floats, outer: Floats) -> Floats:
    """Return the rule (…, 64, 3) between two radii, exact for polynomials in y, z of degree 15.

    Gauss's rule in r², which is exact for the even powers that are left after equal angles.
    """
    point, weight = np.polynomial.legendre.leggauss(4)
    low, high = inner[..., None, None] ** 2, outer[..., None, None] ** 2
    angle = np.pi / 8 * (np.arange(16) + 0.5)
    radius = np.sqrt(low + (high - low) * (1 + point[:, None]) / 2)
    area = np.pi / 16 * (high - low) * weight[:, None] / 2
    rule = np.stack(
        np.broadcast_arrays(radius * np.cos(angle), radius * np.sin(angle), area), axis=-1
    )
    return rule.reshape(*inner.shape, 64, 3)


@dataclass(frozen=True)
class Circle:
    """A full circle; radius in m."""

    radius: Profile

    def area(self, x: Floats) -> Floats:
        return np.pi * self.radius(x) ** 2

    def second_moments(self, x: Floats) -> Pair:
        moment = np.pi / 4 * self.radius(x) ** 4
        return moment, moment

    def torsion_constant(self, x: Floats) -> Floats:
        return np.pi / 2 * self.radius(x) ** 4

    def shear_factors(self, x: Floats, poisson_ratio: float) -> Pair:
        factor = np.full(np.shape(x), 6 * (1 + poisson_ratio) / (7 + 6 * poisson_ratio))
        return factor, factor

    def fibres(self, x: Floats) -> Floats:
        return ring(np.zeros(np.shape(x)), self.radius(x))


@dataclass(frozen=True)
class Annulus:
    """A tube; outer and inner radius in m."""

    outer: Profile
    inner: Profile

    def area(self, x: Floats) -> Floats:
        return np.pi * (self.outer(x) ** 2 - self.inner(x) ** 2)

    def second_moments(self, x: Floats) -> Pair:
        moment = np.pi / 4 * (self.outer(x) ** 4 - self.inner(x) ** 4)
        return moment, moment

    def torsion_constant(self, x: Floats) -> Floats:
        return np.pi / 2 * (self.outer(x) ** 4 - self.inner(x) ** 4)

    def shear_factors(self, x: Floats, poisson_ratio: float) -> Pair:
        nu, square = poisson_ratio, (self.inner(x) / self.outer(x)) ** 2
        solid = (1 + square) ** 2
        factor = 6 * (1 + nu) * solid / ((7 + 6 * nu) * solid + (20 + 12 * nu) * square)
        return factor, factor

    def fibres(self, x: Floats) -> Floats:
        return ring(self.inner(x), self.outer(x))


@dataclass(frozen=True)
class Rectangle:
    """A rectangle; full widths along the section's y and z axes in m."""

    width_y: Profile
    width_z: Profile

    def area(self, x: Floats) -> Floats:
        return self.width_y(x) * self.width_z(x)

    def second_moments(self, x: Floats) -> Pair:
        y, z = self.width_y(x), self.width_z(x)
        return y * z**3 / 12, y**3 * z / 12

    def torsion_constant(self, x: Floats) -> Floats:
        """Return Saint-Venant's series, summed to round-off.

        With long side a and short side b, I_t = a b³/3 · (1 - (192/π⁵)(b/a) Σ tanh(nπa/2b)/n⁵),
        n odd. The sum is Σ 1/n⁵ less Σ (1 - tanh)/n⁵, which falls as exp(-nπa/b).
        """
        y, z = self.width_y(x), self.width_z(x)
        long, short = np.maximum(y, z), np.minimum(y, z)
        rest = np.zeros_like(long)
        for n in range(1, 14, 2):
            rest += 2.0 / (1.0 + np.exp(np.minimum(n * np.pi * long / short, 700.0))) / n**5
        series = _SUM_OF_ODD_INVERSE_FIFTHS - rest
        constant: Floats = long * short**3 / 3 * (1 - 192 / np.pi**5 * short / long * series)
        return constant

    def shear_factors(self, x: Floats, poisson_ratio: float) -> Pair:
        factor = np.full(np.shape(x), 10 * (1 + poisson_ratio) / (12 + 11 * poisson_ratio))
        return factor, factor

    def fibres(self, x: Floats) -> Floats:
        """Return Gauss's rule (…, 64, 3), exact for polynomials of degree 15 in y and in z."""
        point, weight = np.polynomial.legendre.leggauss(8)
        y = self.width_y(x)[..., None] / 2 * np.repeat(point, 8)
        z = self.width_z(x)[..., None] / 2 * np.tile(point, 8)
        area = self.area(x)[..., None] / 4 * np.outer(weight, weight).ravel()
        return np.stack([y, z, area], axis=-1)


_SUM_OF_ODD_INVERSE_FIFTHS = 31 / 32 * 1.0369277551433699263  # (1 - 2⁻⁵)·ζ(5)


@dataclass(frozen=True)
class Ellipse:
    """An ellipse; semi-axes along the section's y and z axes in m."""

    semi_axis_y: Profile
    semi_axis_z: Profile

    def area(self, x: Floats) -> Floats:
        return np.pi * self.semi_axis_y(x) * self.semi_axis_z(x)

    def second_moments(self, x: Floats) -> Pair:
        a, b = self.semi_axis_y(x), self.semi_axis_z(x)
        return np.pi / 4 * a * b**3, np.pi / 4 * a**3 * b

    def torsion_constant(self, x: Floats) -> Floats:
        a, b = self.semi_axis_y(x), self.semi_axis_z(x)
        return np.pi * a**3 * b**3 / (a**2 + b**2)

    def shear_factors(self, x: Floats, poisson_ratio: float) -> Pair:
        a, b = self.semi_axis_y(x), self.semi_axis_z(x)
        return _ellipse_factor(a, b, poisson_ratio), _ellipse_factor(b, a, poisson_ratio)

    def fibres(self, x: Floats) -> Floats:
        a, b = self.semi_axis_y(x), self.semi_axis_z(x)
        scale = np.stack([a, b, a * b], axis=-1)
        return ring(np.zeros(np.shape(x)), np.ones(np.shape(x))) * scale[..., None, :]


def _ellipse_factor(along: Floats, across: Floats, nu: float) -> Floats:
    """Return the factor for a shear force along one semi-axis; it depends on their ratio only."""
    square = (across / along) ** 2
    numerator = 12 * (1 + nu) * (3 + square)
    return numerator / ((40 + 37 * nu) + (16 + 10 * nu) * square + nu * square**2)


DIMENSIONS = {
    "circle": ("radius",),
    "annulus": ("outer", "inner"),
    "rectangle": ("width_y", "width_z"),
    "ellipse": ("semi_axis_y", "semi_axis_z"),
}


def read_cross_section(reader: Reader, length: float) -> CrossSection:
    """Read ``cross_section`` of a section of a length in m: ``shape`` and its dimensions."""
    reader.one_of(("shape",))
    shape = reader.choice("shape", DIMENSIONS)
    reader.only("shape", *DIMENSIONS[shape])
    first, *others = (profile_of(reader, key, length, POSITIVE) for key in DIMENSIONS[shape])
    if shape == "circle":
        return Circle(first)
    if shape == "annulus":
        tube = Annulus(first, *others)
        if np.any(tube.inner(CHECKED) >= tube.outer(CHECKED)):
            reader.refuse("inner radii smaller than the outer ones", "inner")
        return tube
    return Rectangle(first, *others) if shape == "rectangle" else Ellipse(first, *others)


def dimensions(cross_section: CrossSection) -> list[Profile]:
    """Return the dimensions of a cross-section."""
    return list(vars(cross_section).values())
