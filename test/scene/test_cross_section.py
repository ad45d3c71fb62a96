"""Cross-sections against quadrature, and against closed forms from elsewhere."""

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import parse_scene
from soft_sim_ros.scene.cross_section import Annulus, Circle, Ellipse, Rectangle
from soft_sim_ros.scene.taper import Taper

BASE = np.array(0.0)


def constant(value: float) -> Taper:
    return Taper(value, value)


RECTANGLE = Rectangle(constant(0.04), constant(0.01))
ELLIPSE = Ellipse(constant(0.03), constant(0.01))
CIRCLE = Circle(constant(0.02))
ANNULUS = Annulus(constant(0.02), constant(0.015))


def area_integral(section, integrand) -> float:
    """Integrate a function of (y, z) over a section by nested adaptive quadrature."""
    if isinstance(section, Rectangle):
        y, z = section.width_y.start / 2, section.width_z.start / 2
        return dblquad(lambda v, u: integrand(u, v), -y, y, -z, z, epsabs=1e-18)[0]
    if isinstance(section, Ellipse):
        a, b, inner = section.semi_axis_y.start, section.semi_axis_z.start, 0.0
    elif isinstance(section, Annulus):
        a = b = section.outer.start
        inner = section.inner.start / a
    else:
        a = b = section.radius.start
        inner = 0.0

    def polar(r: float, phi: float) -> float:
        return integrand(a * r * np.cos(phi), b * r * np.sin(phi)) * a * b * r

    return dblquad(polar, 0, 2 * np.pi, inner, 1, epsabs=1e-18)[0]


@pytest.mark.parametrize("section", [RECTANGLE, ELLIPSE, CIRCLE, ANNULUS], ids=repr)
def test_area_and_second_moments_are_the_integrals(section):
    about_y, about_z = section.second_moments(BASE)
    assert section.area(BASE) == pytest.approx(area_integral(section, lambda y, z: 1.0), rel=1e-10)
    assert about_y == pytest.approx(area_integral(section, lambda y, z: z * z), rel=1e-10)
    assert about_z == pytest.approx(area_integral(section, lambda y, z: y * y), rel=1e-10)


@pytest.mark.parametrize("section", [CIRCLE, ANNULUS], ids=repr)
def test_round_sections_twist_with_their_polar_moment(section):
    polar = area_integral(section, lambda y, z: y * y + z * z)
    assert section.torsion_constant(BASE) == pytest.approx(polar, rel=1e-10)


def test_ellipse_twists_with_the_volume_under_its_stress_function():
    # Prandtl's function of the ellipse vanishes on the boundary and has Laplacian -2.
    a, b = 0.03, 0.01
    scale = a**2 * b**2 / (a**2 + b**2)
    volume = area_integral(ELLIPSE, lambda y, z: scale * (1 - (y / a) ** 2 - (z / b) ** 2))
    assert ELLIPSE.torsion_constant(BASE) == pytest.approx(2 * volume, rel=1e-10)


@pytest.mark.parametrize("ratio", [1.0, 1.3, 2.0, 7.0])
def test_rectangle_twists_as_the_double_fourier_series_of_its_stress_function(ratio):
    long, short = 0.01 * ratio, 0.01
    m, n = np.meshgrid(np.arange(1, 3001, 2), np.arange(1, 3001, 2))
    terms = 1 / (m**2 * n**2 * ((m / long) ** 2 + (n / short) ** 2))
    expected = 256 / np.pi**6 * long * short * terms.sum()
    section = Rectangle(constant(long), constant(short))
    assert section.torsion_constant(BASE) == pytest.approx(expected, rel=1e-8)


def test_torsion_of_a_square_agrees_with_the_tabulated_factor():
    # 0.1406 a⁴ in every handbook; more digits from the series itself, summed the plain way.
    odd = np.arange(1, 60, 2)
    series = np.sum(np.tanh(odd * np.pi / 2) / odd**5.0)
    tail = quad(lambda n: 0.5 / n**5, 60, np.inf)[0]
    factor = 1 / 3 * (1 - 192 / np.pi**5 * (series + tail))
    square = Rectangle(constant(1.0), constant(1.0)).torsion_constant(BASE)
    assert square == pytest.approx(0.1406, abs=5e-5)
    assert square == pytest.approx(factor, rel=1e-9)


def test_torsion_of_a_rectangle_does_not_depend_on_which_side_is_called_y():
    turned = Rectangle(RECTANGLE.width_z, RECTANGLE.width_y)
    assert turned.torsion_constant(BASE) == RECTANGLE.torsion_constant(BASE)


def test_torsion_of_a_thin_strip_tends_to_a_b_cubed_over_three():
    strip = Rectangle(constant(1.0), constant(1e-5)).torsion_constant(BASE)
    assert strip == pytest.approx(1e-15 / 3, rel=1e-5)


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.5])
def test_shear_factors_agree_where_shapes_meet(nu):
    circle = float(CIRCLE.shear_factors(BASE, nu)[0])
    round_ellipse = Ellipse(constant(0.02), constant(0.02)).shear_factors(BASE, nu)
    thick_tube = Annulus(constant(0.02), constant(1e-9)).shear_factors(BASE, nu)
    thin_tube = Annulus(constant(0.02), constant(0.02 * (1 - 1e-9))).shear_factors(BASE, nu)
    assert round_ellipse == pytest.approx(np.full(2, circle), rel=1e-12)
    assert thick_tube == pytest.approx(np.full(2, circle), rel=1e-12)
    assert thin_tube[0] == pytest.approx(2 * (1 + nu) / (4 + 3 * nu), rel=1e-8)


def energetic_factor(width, height: float) -> float:
    """Return V²/(A ∫τ² dA) with Jourawski's shear stress of a section of some width(u)."""
    area = quad(width, -height, height)[0]
    inertia = quad(lambda u: u * u * width(u), -height, height)[0]

    def stress_squared_times_width(u: float) -> float:
        moment = quad(lambda v: v * width(v), u, height)[0]
        return moment**2 / (inertia**2 * width(u))

    return 1 / (area * quad(stress_squared_times_width, -height, height)[0])


def test_shear_factors_without_lateral_contraction_are_those_of_the_parabolic_stress():
    rectangle = energetic_factor(lambda u: 1.0, 0.5)
    assert RECTANGLE.shear_factors(BASE, 0.0) == pytest.approx(np.full(2, rectangle), rel=1e-8)
    # A tall ellipse under a force along its long (y) axis.
    ellipse = energetic_factor(lambda u: np.sqrt(max(1 - u * u, 1e-300)), 1.0)
    tall = Ellipse(constant(1.0), constant(1e-6)).shear_factors(BASE, 0.0)
    assert tall[0] == pytest.approx(ellipse, rel=1e-5)
    assert tall[0] > tall[1]


def test_tapered_dimensions_go_straight_from_start_to_end():
    x = np.array([0.0, 0.25, 1.0])
    cone = Circle(Taper(0.03, 0.01))
    assert cone.area(x) == pytest.approx(np.pi * np.array([0.03, 0.025, 0.01]) ** 2, rel=1e-14)
    assert cone.radius(x)[[0, 2]].tolist() == [0.03, 0.01]


@pytest.mark.parametrize("section", [RECTANGLE, ELLIPSE, CIRCLE, ANNULUS], ids=repr)
def test_answers_have_the_shape_of_the_question(section):
    x = np.linspace(0, 1, 6).reshape(2, 3)
    answers = [section.area(x), section.torsion_constant(x)]
    answers += [*section.second_moments(x), *section.shear_factors(x, 0.3)]
    assert {answer.shape for answer in answers} == {(2, 3)}


def test_flat_auxetic_ellipse_asks_for_a_shear_correction():
    text = """
materials: {foam: {young_modulus: 1e5, poisson_ratio: -0.5, density: 100}}
bodies:
  - rod: arm
    sections:
      - name: a
        length: 1
        material: foam
        cross_section: {shape: ellipse, semi_axis_y: 0.001, semi_axis_z: 0.02}
"""
    with pytest.raises(SceneError, match=r"shear_y stiffness > 0 .*it is -.*give shear_correction"):
        parse_scene(text)
    section = parse_scene(text + "        shear_correction: 0.9\n").bodies[0].sections[0]
    assert section.shear_factors(BASE) == (0.9, 0.9)
    parse_scene(text.replace("rod: arm", "rod: arm\n    strains: [bend_y]"))  # no shear, no factor
