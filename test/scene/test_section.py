"""The section law: where every stiffness, viscosity and inertia goes."""

import numpy as np
import pytest

from soft_sim_ros.scene import parse_scene, summary, total_mass

SCENE = """
materials:
  gel: {{young_modulus: 3e5, {second}, density: 1200, viscosity: 40{more}}}
bodies:
  - rod: arm
    sections:
      - name: only
        length: 0.5
        material: gel
        cross_section: {cross_section}
        reference: {{curvature: [0.1, [0, 2], -3], stretch: [1.0, 1.1], shear: [0, 0.01]}}
        {section_more}
"""
STRIP = "{shape: rectangle, width_y: 0.04, width_z: 0.01}"


def section(second="poisson_ratio: 0.25", more="", cross_section=STRIP, section_more=""):
    text = SCENE.format(
        second=second, more=more, cross_section=cross_section, section_more=section_more
    )
    return parse_scene(text).bodies[0].sections[0]


def test_stiffness_puts_each_modulus_with_its_cross_section_constant():
    strip = section()
    shape, x = strip.cross_section, np.array(0.3)
    E, G, A = 3e5, 3e5 / 2.5, 0.04 * 0.01
    ky, kz = shape.shear_factors(x, 0.25)
    expected = [
        G * shape.torsion_constant(x),
        E * 0.04 * 0.01**3 / 12,  # about y: the thin side bends easily
        E * 0.01 * 0.04**3 / 12,
        E * A,
        ky * G * A,
        kz * G * A,
    ]
    assert strip.stiffness(x) == pytest.approx(np.array(expected), rel=1e-14)


def test_damping_is_stiffness_times_one_retardation_time():
    strip = section()
    x = np.linspace(0, 1, 4)
    retardation = 40 / (3e5 / 2.5)
    assert strip.damping(x) == pytest.approx(retardation * strip.stiffness(x), rel=1e-14)
    assert strip.material.retardation_time == pytest.approx(retardation, rel=1e-15)


def test_incompressible_material_resists_stretching_with_three_times_its_viscosity():
    assert section("poisson_ratio: 0.5").material.axial_viscosity == pytest.approx(120, rel=1e-15)


def test_axial_viscosity_can_be_given_and_rules_bending_and_stretch_only():
    plain, given = section(), section(more=", axial_viscosity: 7")
    ratio = given.damping(np.array(0.0)) / plain.damping(np.array(0.0))
    assert ratio == pytest.approx(np.array([1, 0.07, 0.07, 0.07, 1, 1]), rel=1e-14)


def test_shear_modulus_and_poisson_ratio_say_the_same():
    x = np.array(0.0)
    by_ratio, by_modulus = section(), section("shear_modulus: 1.2e5")
    assert by_modulus.stiffness(x) == pytest.approx(by_ratio.stiffness(x), rel=1e-14)


def test_inertia_is_density_times_area_and_second_moments():
    area, about_y, about_z = 4e-4, 0.04 * 0.01**3 / 12, 0.01 * 0.04**3 / 12
    expected = 1200 * np.array([area, about_y + about_z, about_y, about_z])
    assert section().inertia(np.array(0.5)) == pytest.approx(expected, rel=1e-14)


def test_reference_strain_is_linear_between_start_and_end():
    expected = [[0.1, 0, -3, 1, 0, 0.01], [0.1, 1, -3, 1.05, 0, 0.01], [0.1, 2, -3, 1.1, 0, 0.01]]
    x = np.array([0.0, 0.5, 1.0])
    assert section().strain0(x) == pytest.approx(np.array(expected), abs=1e-15)


@pytest.mark.parametrize(
    ("written", "factors"),
    [("shear_correction: 0.8", (0.8, 0.8)), ("shear_correction: [1, 0.5]", (1, 0.5))],
)
def test_shear_correction_overrides_the_factors_of_the_shape(written, factors):
    stiffness = section(section_more=written).stiffness(np.array(0.0))
    assert stiffness[4:] == pytest.approx(1.2e5 * 4e-4 * np.array(factors), rel=1e-14)


def test_laws_take_arrays_of_any_shape():
    x = np.linspace(0, 1, 6).reshape(2, 3)
    strip = section(section_more="shear_correction: 1")
    shapes = [f(x).shape for f in (strip.stiffness, strip.damping, strip.inertia, strip.strain0)]
    assert shapes == [(2, 3, 6), (2, 3, 6), (2, 3, 4), (2, 3, 6)]


def test_mass_of_a_tapered_section_is_that_of_a_frustum():
    text = SCENE.format(
        second="poisson_ratio: 0.25",
        more="",
        cross_section="{shape: circle, radius: [0.03, 0.01]}",
        section_more="",
    )
    scene = parse_scene(text + "  - rigid_body: payload\n    mass: 2.5\n")
    (row,) = summary(scene)
    frustum = 1200 * np.pi * 0.5 / 3 * (0.03**2 + 0.03 * 0.01 + 0.01**2)
    assert row.mass == pytest.approx(frustum, rel=1e-14)
    assert total_mass(scene) == pytest.approx(frustum + 2.5, rel=1e-14)
    assert row.EI_y == pytest.approx((3e5 * np.pi / 4 * 0.03**4, 3e5 * np.pi / 4 * 0.01**4))
    assert row.slenderness == pytest.approx(0.5 / 0.005, rel=1e-14)  # gyration radius r/2
