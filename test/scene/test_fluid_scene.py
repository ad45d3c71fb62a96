"""What a scene says of a fluid is read, inherited and refused with file, key, value and why."""

import copy

import numpy as np
import pytest
import yaml

from soft_sim_ros.commands.check import sections
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import parse_scene
from soft_sim_ros.scene.fluid import DEFAULTS, ellipsoid, outline

SCENE = """
fluid: {density: 1000.0, current: [0.1, 0.0, -0.2], drag_normal: 1.3}
materials: {soft: {young_modulus: 1.0e6, poisson_ratio: 0.5, density: 900.0}}
bodies:
  - rod: arm
    fluid: {drag_tangential: 0.02, dry_ends: [start]}
    sections:
      - {name: a, length: 0.2, material: soft, cross_section: {shape: circle, radius: 0.01}}
      - name: b
        length: 0.1
        material: soft
        cross_section: {shape: rectangle, width_y: 0.02, width_z: 0.01}
        fluid: {drag_normal: [1.9, 2.1], added_mass: 1.5, lift: 0.2}
  - rigid_body: ball
    mass: 0.1
    fluid: {radius: 0.03, drag: 0.5}
  - rigid_body: box
    mass: 0.1
    fluid: {volume: 1.0e-4, area: [0.01, 0.02, 0.03], drag: [1.0, 2.0, 3.0], added_mass: 0.1}
numerics: {step: 0.001, basis: {order: 1}}
"""


def scene(**changes):
    document = yaml.safe_load(SCENE)
    for path, value in changes.items():
        at, keys = document, path.split("__")
        for key in keys[:-1]:
            at = at[int(key) if key.isdigit() else key]
        if value is None:
            at.pop(keys[-1])
        else:
            at[int(keys[-1]) if keys[-1].isdigit() else keys[-1]] = value
    return parse_scene(yaml.safe_dump(copy.deepcopy(document), sort_keys=False), "sea.yaml")


def test_a_section_s_coefficients_count_before_its_rod_s_and_those_before_the_scene_s():
    arm = scene().bodies[0]
    first, second = (scene().fluid.coefficients(arm.fluid, s.fluid) for s in arm.sections)
    assert first == DEFAULTS | {"drag_normal": (1.3, 1.3), "drag_tangential": (0.02, 0.02)}
    assert second["drag_normal"] == (1.9, 2.1) and second["drag_tangential"] == (0.02, 0.02)
    assert second["added_mass"] == (1.5, 1.5) and second["lift"] == (0.2, 0.0, 0.0)
    assert arm.fluid.dry_ends == ("start",)
    assert [float(c.expression(np.array(0.0))) for c in scene().fluid.current] == [0.1, 0.0, -0.2]
    box = scene().bodies[2].fluid
    assert box.drag.tolist() == [1.0, 2.0, 3.0] and box.added_mass.tolist() == [0.1] * 3


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"fluid__density": 0.0}, r"fluid.density = 0.0: expected a number > 0"),
        ({"fluid__density": None}, r"fluid.density"),
        ({"fluid__densty": 1.0}, r"fluid.densty = 1.0.*did you mean density"),
        ({"fluid__drag_normal": -1.0}, r"fluid.drag_normal = -1.0: expected a number >= 0"),
        ({"fluid__drag_normal": [1.0, 2.0, 3.0]}, r"fluid.drag_normal.*a list of 2 entries"),
        ({"fluid__current": [1.0, 2.0]}, r"fluid.current.*a list of 3 entries"),
        ({"fluid__current": {"w": 1.0}}, r"fluid.current.w.*one of x, y, z"),
        ({"fluid__current": {}}, r"fluid.current.*courses of some of x, y, z"),
        ({"fluid__current": {"x": "sin(s)"}}, r"fluid.current.x = sin\(s\).*'s' is not among t"),
        ({"fluid__current": {"x": {"table": [[1, 0], [0, 1]]}}}, r"current.x.table.*times rising"),
        ({"fluid__current": {"x": {"within": 0.1}}}, r"fluid.current.x.*formula, table or file"),
        ({"fluid__drag_law": "both"}, r"fluid.drag_law = both.*split, whole"),
        ({"bodies__0__fluid__dry_ends": ["tip"]}, r"bodies\[0\].fluid.dry_ends\[0\] = tip.*start"),
        ({"bodies__0__fluid": 3}, r"bodies\[0\].fluid = 3: expected a mapping .*, or none"),
        ({"bodies__1__fluid__volume": 1.0}, r"only one of radius and volume"),
        ({"bodies__1__fluid": {"drag": 1.0}}, r"one of the keys radius, semi_axes, volume"),
        ({"bodies__1__fluid__area": [1, 1, 1]}, r"fluid.area.*radius says it"),
        ({"bodies__1__fluid": {"semi_axes": [1.0, 0.0, 1.0]}}, r"semi_axes\[1\] = 0.0.*> 0"),
        ({"bodies__2__fluid__area": None}, r"fluid.drag.*an area beside it"),
        ({"fluid": None}, r"bodies\[0\].fluid.*the scene has no fluid"),
    ],
)  # fmt: skip
def test_a_fluid_that_makes_no_sense_is_refused_by_name(changes, says):
    with pytest.raises(SceneError, match=rf"(?s)sea.yaml:\d+: .*{says}"):
        scene(**changes)


def test_a_flexible_link_is_refused_until_it_says_that_it_is_dry():
    link = yaml.safe_load(SCENE)["bodies"][0]
    link["flexible_link"] = link.pop("rod")
    link["sections"] = link["sections"][:1]
    link |= {"modes": 2}
    with pytest.raises(SceneError, match=r"\[0\].fluid.*none: a flexible link has no surface"):
        scene(bodies__0=link)
    link.pop("fluid")
    with pytest.raises(SceneError, match=r"flexible_link = arm: expected fluid: none for this"):
        scene(bodies__0=link)
    assert scene(bodies__0=link | {"fluid": "none"}).fluid is not None


def test_a_current_whose_rate_is_no_number_is_refused():
    from soft_sim_ros.core.settled import Dynamics

    with pytest.raises(SceneError, match=r"fluid.current.x = sqrt\(t\): expected a formula with a"):
        Dynamics(scene(fluid__current={"x": "sqrt(t)"}))


def test_check_says_that_there_is_water_and_what_it_does_not_touch():
    lines = list(sections(scene(bodies__1__fluid="none", bodies__0__sections__0__fluid="none")))
    line = next(line for line in lines if line.startswith("fluid"))
    displaced = 1000.0 * (0.1 * 0.02 * 0.01 + 1e-4)
    assert f"fluid 1000 kg/m³, with a current: displaces {displaced:.4g} kg of it" in line
    assert line.endswith("it does not touch arm/a, ball")


def test_an_ellipsoid_s_added_mass_has_the_known_limits():
    """Sphere ½ρV; a long spheroid: none along, ρV across; a disk: 8/3 ρr³ (Lamb)."""
    volume, area, added, turned = ellipsoid(np.full(3, 0.3))
    np.testing.assert_allclose(added, 0.5 * volume, rtol=1e-14)
    np.testing.assert_allclose(area, np.pi * 0.09, rtol=1e-14)
    assert not turned.any()
    volume, _, added, turned = ellipsoid(np.array([100.0, 1.0, 1.0]))
    np.testing.assert_allclose(added / volume, [0.0, 1.0, 1.0], atol=2e-3)
    np.testing.assert_allclose(turned[1:] / (volume * 100.0**2 / 5), 1.0, rtol=3e-3)
    _, _, added, turned = ellipsoid(np.array([1e-6, 1.0, 1.0]))
    assert added[0] == pytest.approx(8.0 / 3.0, rel=1e-5)
    assert turned[1] == pytest.approx(16.0 / 45.0, rel=1e-5)


def test_the_outline_of_a_section_is_what_the_flow_sees():
    first, second = scene().bodies[0].sections
    x = np.array([0.0, 1.0])
    circle, box = outline(first.cross_section, x), outline(second.cross_section, x)
    np.testing.assert_allclose(circle.across, 0.02)
    np.testing.assert_allclose(circle.perimeter, 0.02 * np.pi)
    np.testing.assert_allclose(box.across, [[0.01, 0.02]] * 2)  # a flow along y meets width_z
    np.testing.assert_allclose(box.perimeter, 0.06)
    shape = {"shape": "ellipse", "semi_axis_y": 0.02, "semi_axis_z": 0.01}
    ellipse = outline(scene(bodies__0__sections__0__cross_section=shape).bodies[0].sections[0]
                      .cross_section, x)  # fmt: skip
    np.testing.assert_allclose(ellipse.across, [[0.02, 0.04]] * 2)
    angle = np.linspace(0.0, 2 * np.pi, 200001)
    around = np.hypot(np.diff(0.02 * np.cos(angle)), np.diff(0.01 * np.sin(angle))).sum()
    np.testing.assert_allclose(ellipse.perimeter, around, rtol=1e-8)
