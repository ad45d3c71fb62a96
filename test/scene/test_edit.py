"""Numbers of a scene are found and replaced by key path; nothing else changes."""

import pytest

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene.edit import number_at, with_numbers

TEXT = """\
materials:
  rubber: &rubber {young_modulus: 1e6, density: 1000}   # a guess
  foam:
    <<: *rubber
    density: 200
bodies:
  - rod: arm
    sections:
      - {name: tip, cross_section: {radius: [0.02, 0.01]}, material: rubber}
"""


def test_a_number_is_found_by_names_and_by_indices():
    assert number_at(TEXT, "t", "materials.rubber.young_modulus") == 1e6
    assert number_at(TEXT, "t", "materials.foam.density") == 200
    assert number_at(TEXT, "t", "materials.foam.young_modulus") == 1e6  # merged in
    assert number_at(TEXT, "t", "bodies[0].sections[0].cross_section.radius[1]") == 0.01
    assert number_at(TEXT, "t", "bodies.arm.sections.tip.cross_section.radius[0]") == 0.02


def test_only_the_number_changes_and_it_is_exact():
    value = 1234567.890123457
    radius = "bodies[0].sections.tip.cross_section.radius[1]"
    changed = with_numbers(TEXT, "t", {"materials.rubber.young_modulus": value, radius: 0.011})
    assert number_at(changed, "t", "materials.rubber.young_modulus") == value
    assert changed == TEXT.replace("1e6", repr(value)).replace("0.01]", "0.011]")


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ("materials.ruber.density", "'ruber' is not among rubber, foam"),
        ("bodies[1].rod", "1 is not among arm"),
        ("materials.rubber.viscosity", "'viscosity' is not among young_modulus, density"),
        ("bodies[0].sections[0].material", "= rubber: expected a number"),
        ("materials.rubber", "expected a number"),
        ("", "expected a number"),
    ],
)
def test_a_path_to_no_number_is_refused(path, told):
    with pytest.raises(SceneError) as refusal:
        number_at(TEXT, "t", path)
    assert told in str(refusal.value)


def test_two_ways_to_one_number_are_refused():
    paths = ("materials.rubber.young_modulus", "materials.foam.young_modulus")
    with pytest.raises(SceneError, match="every number once"):
        with_numbers(TEXT, "t", dict.fromkeys(paths, 1.0))
