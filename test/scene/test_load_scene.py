"""Finding scenes, the YAML traps, and what defaults mean."""

import math
import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import load_scene, packaged_scenes, parse_scene
from soft_sim_ros.scene.numerics import DEFAULT_ORDER

MINIMAL = """
materials: {m: {young_modulus: 1e6, poisson_ratio: 0.3, density: 1e3}}
bodies:
  - rod: arm
    sections:
      - {name: a, length: 0.2, material: m, cross_section: {shape: circle, radius: 0.02}}
"""
HINGED = MINIMAL.replace(
    "bodies:\n", "bodies:\n  - {joint: hinge, kind: revolute, axis: [0, 0, 2]}\n"
)


@pytest.mark.parametrize(
    "name",
    ["soft_arm", "tendon_arm", "winch_arm", "pneumatic_arm", "flexible_manipulator", "cantilever"],
)
def test_packaged_scenes_load_by_name_by_file_name_and_by_path(name):
    path = packaged_scenes()[name]
    for way in (name, f"{name}.yaml", path, str(path)):
        scene = load_scene(way)
        assert (scene.name, scene.file, scene.source) == (name, str(path), path.read_text())


def test_default_scene_is_a_three_section_arm_with_six_torques():
    scene = load_scene("soft_arm")
    (arm,) = scene.bodies
    assert len(arm.sections) == 3 and arm.length == pytest.approx(0.6)
    assert len(scene.actuators) == 6 and {a.unit for a in scene.actuators} == {"N·m"}
    assert scene.initial.state == "equilibrium"


def test_minimal_scene_gets_the_documented_defaults():
    scene = parse_scene(MINIMAL, "dir/my-arm.yaml")
    assert scene.name == "my_arm"
    assert scene.gravity.tolist() == [0, 0, -9.81]
    assert scene.base.position.tolist() == [0, 0, 0]
    assert scene.base.quaternion.tolist() == [0, 0, 0, 1]
    assert scene.actuators == scene.loads == ()
    assert scene.initial.state == "reference"
    numerics = scene.numerics
    assert (numerics.step, numerics.integrator, numerics.max_iterations) == (0.002, "sdirk2", 20)
    basis = numerics.rods["arm"]
    assert (basis.kind, basis.order, basis.elements, basis.nodes) == (
        "legendre", DEFAULT_ORDER, 1, None,
    )  # fmt: skip
    assert scene.bodies[0].strains == tuple(DEFAULT_ORDER)


def test_scene_cannot_be_changed():
    scene = parse_scene(MINIMAL)
    with pytest.raises(AttributeError):
        scene.bodies[0].sections[0].length = 2.0
    with pytest.raises(ValueError, match="read-only"):
        scene.gravity[2] = 0.0


@pytest.mark.parametrize("written", ["1e6", "1.0e6", "1E+6", "1000000", "1_000_000", "+1e6"])
def test_every_way_to_write_a_million_is_a_million(written):
    scene = parse_scene(MINIMAL.replace("1e6", written))
    assert scene.bodies[0].sections[0].material.young_modulus == 1e6


@pytest.mark.parametrize(
    "written", ["on", "true", "0x10", "1:30", "'5'", ".nan", "~", "[5]", "5 Pa"]
)
def test_words_that_yaml_turns_into_numbers_are_none_here(written):
    with pytest.raises(SceneError, match=r"young_modulus = .*expected a number > 0"):
        parse_scene(MINIMAL.replace("1e6", written))


def test_anchors_and_merge_keys_share_what_sections_have_in_common():
    text = (
        MINIMAL.replace("- {name: a,", "- &one {name: a,")
        + "      - {<<: *one, name: b, length: 0.7}\n"
    )
    first, second = parse_scene(text).bodies[0].sections
    assert (second.name, second.length, second.material) == ("b", 0.7, first.material)


def test_rpy_is_roll_then_pitch_then_yaw_about_fixed_axes():
    rpy = [0.3, -0.7, 2.1]
    scene = parse_scene(MINIMAL + f"base: {{rpy: {rpy}}}\n")
    expected = Rotation.from_euler("xyz", rpy).as_quat()
    assert scene.base.quaternion == pytest.approx(expected, abs=1e-15)


def test_quaternions_and_axes_are_normalised():
    scene = parse_scene(HINGED + "base: {quaternion: [0, 0, 0.7071, 0.7071]}\n")
    assert np.linalg.norm(scene.base.quaternion) == pytest.approx(1, abs=1e-15)
    assert scene.bodies[0].axis.tolist() == [0, 0, 1]


def test_strains_come_in_the_order_of_the_theory():
    text = MINIMAL.replace("rod: arm", "rod: arm\n    strains: [stretch, bend_z, torsion]")
    assert parse_scene(text).bodies[0].strains == ("torsion", "bend_z", "stretch")


def test_orders_are_taken_per_rod_then_for_all_rods_then_by_default():
    text = (
        MINIMAL
        + """
  - rod: stiff
    strains: [bend_y, bend_z]
    sections:
      - {name: a, length: 1, material: m, cross_section: {shape: circle, radius: 0.02}}
numerics:
  basis: {kind: chebyshev, order: {bend_y: 7, stretch: 0}, elements: 2}
  rods:
    stiff: {order: {bend_z: 4}, nodes: 9}
"""
    )
    numerics = parse_scene(text).numerics
    arm, stiff = numerics.rods["arm"], numerics.rods["stiff"]
    assert arm.order == {**DEFAULT_ORDER, "bend_y": 7, "stretch": 0}
    assert stiff.order == {"bend_y": 7, "bend_z": 4}
    assert (arm.kind, arm.elements, arm.nodes) == ("chebyshev", 2, None)
    assert (stiff.kind, stiff.elements, stiff.nodes) == ("chebyshev", 2, 9)


def test_piecewise_bases_have_one_order():
    text = MINIMAL + "numerics: {basis: {kind: constant, elements: 4}, rods: {arm: {kind: linear}}}"
    numerics = parse_scene(text).numerics
    assert set(numerics.basis.order.values()) == {0}
    assert set(numerics.rods["arm"].order.values()) == {1}


def test_initial_values_go_to_joints_and_sections():
    text = (
        HINGED
        + """
initial:
  positions: {hinge: 0.5}
  velocities: {hinge: -1}
  strains: {arm/a: {bend_y: 2, stretch: 0.1}}
"""
    )
    initial = parse_scene(text).initial
    assert (initial.positions, initial.velocities) == ({"hinge": 0.5}, {"hinge": -1.0})
    assert initial.strains["arm/a"].tolist() == [0, 2, 0, 0.1, 0, 0]


def test_infinity_is_a_limit_and_nothing_else():
    text = HINGED + "actuators: [{joint_torque: m, joint: hinge, limits: [-.inf, 3]}]\n"
    assert parse_scene(text).actuators[0].limits == (-math.inf, 3.0)
    with pytest.raises(SceneError, match="length"):
        parse_scene(MINIMAL.replace("length: 0.2", "length: .inf"))


def test_missing_file_names_the_packaged_scenes_and_the_nearest():
    with pytest.raises(
        SceneError, match=r"soft_armm: .*one of the scenes .*did you mean soft_arm\?"
    ):
        load_scene("soft_armm")


def test_a_folder_or_a_binary_file_is_a_scene_error(tmp_path):
    with pytest.raises(SceneError, match="expected an existing file"):
        load_scene(tmp_path)
    binary = tmp_path / "scene.yaml"
    binary.write_bytes(b"name: \xff\xfe")
    with pytest.raises(SceneError, match=r"UTF-8 text \(byte 6 is not\)"):
        load_scene(binary)


def test_importing_the_package_loads_nothing_heavy():
    code = "import sys, soft_sim_ros; print({'numpy', 'yaml', 'rclpy'} & set(sys.modules))"
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == "set()"


def test_package_offers_load_scene_and_refuses_unknown_names():
    import soft_sim_ros

    assert soft_sim_ros.load_scene is load_scene
    assert {"load_scene", "read_run", "Simulation"} <= set(dir(soft_sim_ros))
    with pytest.raises(AttributeError, match="no attribute 'load_scenes'"):
        soft_sim_ros.load_scenes  # noqa: B018
