"""What a person reads after a typical mistake, word by word.

Every case changes one place of a valid scene; the message must name file, line, key path, value and
what was expected.
"""

import pytest

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import parse_scene

SCENE = """\
name: demo
gravity: [0, 0, -9.81]
base:
  position: [0, 0, 1]
materials:
  silicone: {young_modulus: 7e5, poisson_ratio: 0.49, density: 1070, viscosity: 500}
bodies:
  - joint: shoulder
    kind: revolute
    axis: [0, 0, 1]
    offset: {rpy: [0, 0, 0]}
  - rod: arm
    strains: [torsion, bend_y, bend_z]
    sections:
      - name: proximal
        length: 0.2
        material: silicone
        cross_section: {shape: circle, radius: [0.03, 0.02]}
      - name: distal
        length: 0.3
        material: silicone
        cross_section: {shape: annulus, outer: 0.02, inner: 0.01}
        reference: {curvature: [0, 0, [0, 2]]}
  - rigid_body: payload
    mass: 0.1
    inertia: [1e-5, 1e-5, 1e-5]
actuators:
  - {moment: bend, rod: arm, section: proximal, strain: bend_y, limits: [-1, 1], safe: 0}
  - {joint_torque: motor, joint: shoulder}
  - {tendon: cable, rod: arm, end: 0.4, offset: [0.01, 0]}
  - {tendon: spiral, rod: arm, helix: {radius: 0.01, turns: 1}}
loads:
  - {point: push, body: arm, s: 0.5, force: [0, 1, 0], schedule: {start: 1, end: 2, ramp: 0.1}}
  - {distributed: wind, body: arm, start: 0.1, end: 0.3, force: [0, 1, 0]}
initial:
  positions: {shoulder: 0.5}
  strains: {arm/distal: {bend_z: 1}}
numerics:
  step: 0.001
  basis: {kind: legendre, order: {bend_y: 4}, elements: 2, nodes: auto}
  rods: {arm: {order: {bend_z: 4}}}
"""

MISTAKES = [
    (
        "poisson_ratio: 0.49",
        "poisson_ratio: 0.7",
        "6: materials.silicone.poisson_ratio = 0.7: expected a number in (-1, 0.5]",
    ),
    (
        "density",
        "densty",
        "6: materials.silicone.densty = 1070: expected a known key, one of "
        "young_modulus, poisson_ratio, shear_modulus, law, density, "
        "viscosity, axial_viscosity, rayleigh, maxwell (did you mean density?)",
    ),
    (
        "density: 1070, ",
        "",
        "6: materials.silicone.density is missing: expected a number > 0",
    ),
    (
        "density: 1070",
        "density: -1070",
        "6: materials.silicone.density = -1070: expected a number > 0",
    ),
    (
        "young_modulus: 7e5",
        "young_modulus: 7e5 Pa",
        "6: materials.silicone.young_modulus = 7e5 Pa: expected a number > 0",
    ),
    (
        "young_modulus: 7e5",
        "young_modulus: true",
        "6: materials.silicone.young_modulus = true: expected a number > 0",
    ),
    (
        "young_modulus: 7e5",
        "young_modulus: .nan",
        "6: materials.silicone.young_modulus = .nan: expected a number > 0",
    ),
    (
        "poisson_ratio: 0.49",
        "shear_modulus: 2e5",
        "6: materials.silicone.shear_modulus = 2e5: expected a number >= young_modulus/3 "
        "= 233333 (Poisson's ratio <= 0.5); a braided or wound tube is not isotropic: give its "
        "sections their stiffness instead, such as stiffness: {torsion: GJ in N·m²}",
    ),
    (
        "poisson_ratio: 0.49",
        "poisson_ratio: 0.49, shear_modulus: 2.4e5",
        "6: materials.silicone.shear_modulus = 2.4e5: expected only one of poisson_ratio "
        "and shear_modulus",
    ),
    (
        "poisson_ratio: 0.49, ",
        "",
        "6: materials.silicone = {young_modulus: 7e5, density: 1070, viscosity: 500}: "
        "expected one of the keys poisson_ratio, shear_modulus",
    ),
    (
        "viscosity: 500",
        "viscosity: 500, viscosity: 600",
        "6: materials.silicone.viscosity = 600: expected every key once (first in line 6)",
    ),
    (
        "gravity: [0, 0, -9.81]",
        "gravity: [0, -9.81]",
        "2: gravity = [0, -9.81]: expected a list of 3 entries, each a finite number",
    ),
    (
        "gravity: [0, 0, -9.81]",
        "gravity: -9.81",
        "2: gravity = -9.81: expected a list of 3 entries, each a finite number",
    ),
    (
        "gravity: [0, 0, -9.81]",
        "gravity: [0, 0, inf]",
        "2: gravity[2] = inf: expected a finite number",
    ),
    (
        "bodies:",
        "bodys:",
        "7: bodys = - joint: shoulder …: expected a known key, one of name, gravity, "
        "base, materials, bodies, actuators, constraints, loads, initial, numerics, fluid, "
        "environment, contact, sensors, pairs (did you mean bodies?)",
    ),
    (
        "  - rod: arm",
        "  - rood: arm",
        "12: bodies[1].rood = arm: expected a known key, one of rod, flexible_link, joint, "
        "rigid_body (did you mean rod?)",
    ),
    (
        "rod: arm\n    strains",
        "rod: shoulder\n    strains",
        "12: bodies[1].rod = shoulder: expected a name that is not used twice",
    ),
    (
        "  - rod: arm",
        "  - rod: my arm",
        "12: bodies[1].rod = my arm: expected a name of letters, digits and _ that "
        "starts with a letter",
    ),
    (
        "kind: revolute",
        "kind: revolut",
        "9: bodies[0].kind = revolut: expected one of fixed, revolute, prismatic, universal, "
        "spherical, free (did you mean revolute?)",
    ),
    (
        "kind: revolute\n    axis: [0, 0, 1]",
        "kind: fixed\n    axis: [0, 0, 1]",
        "10: bodies[0].axis = [0, 0, 1]: expected no such key: it has no effect on a fixed joint",
    ),
    (
        "axis: [0, 0, 1]",
        "axis: [0, 0, 0]",
        "10: bodies[0].axis = [0, 0, 0]: expected a direction, not a vector of length 0",
    ),
    (
        "offset: {rpy: [0, 0, 0]}",
        "offset: {quaternion: [0, 0, 0, 2]}",
        "11: bodies[0].offset.quaternion = [0, 0, 0, 2]: expected a unit quaternion [x, "
        "y, z, w], its norm is 2",
    ),
    (
        "strains: [torsion, bend_y, bend_z]",
        "strains: [torsion, bend]",
        "13: bodies[1].strains[1] = bend: expected one of torsion, bend_y, bend_z, "
        "stretch, shear_y, shear_z (did you mean bend_z?)",
    ),
    (
        "strains: [torsion, bend_y, bend_z]",
        "strains: [torsion, bend_y, bend_y]",
        "13: bodies[1].strains[2] = bend_y: expected every word only once",
    ),
    (
        "name: distal",
        "name: proximal",
        "19: bodies[1].sections[1].name = proximal: expected a name that is not used twice",
    ),
    (
        "length: 0.3",
        "length: 0",
        "20: bodies[1].sections[1].length = 0: expected a number > 0",
    ),
    (
        "material: silicone\n        cross_section: {shape: c",
        "material: silicon\n        cross_section: {shape: c",
        "17: bodies[1].sections[0].material = silicon: expected the name of a material, "
        "one of silicone (did you mean silicone?)",
    ),
    (
        "shape: circle",
        "shape: cirle",
        "18: bodies[1].sections[0].cross_section.shape = cirle: expected one of circle, "
        "annulus, rectangle, ellipse (did you mean circle?)",
    ),
    (
        "radius: [0.03, 0.02]",
        "radius: [0.03, 0]",
        "18: bodies[1].sections[0].cross_section.radius[1] = 0: expected a number > 0",
    ),
    (
        "radius: [0.03, 0.02]",
        "radius: [0.03, 0.02, 0.01]",
        "18: bodies[1].sections[0].cross_section.radius = [0.03, 0.02, 0.01]: expected a "
        "number > 0 or a pair [start, end]",
    ),
    (
        "radius: [0.03, 0.02]",
        "radius: 1e-90",
        "18: bodies[1].sections[0].cross_section.radius = 1e-90: "
        "expected a number > 0, at least 1e-60",
    ),
    (
        "inner: 0.01",
        "inner: 0.02",
        "22: bodies[1].sections[1].cross_section.inner = 0.02: expected inner radii "
        "smaller than the outer ones",
    ),
    (
        "curvature: [0, 0, [0, 2]]",
        "curvature: [0, 0]",
        "23: bodies[1].sections[1].reference.curvature = [0, 0]: expected a list of 3 "
        "entries, each a number or a pair [start, end]",
    ),
    (
        "mass: 0.1",
        "mass: 0",
        "25: bodies[2].mass = 0: expected a number > 0",
    ),
    (
        "inertia: [1e-5, 1e-5, 1e-5]",
        "inertia: [1e-5, 1e-5, 3e-5]",
        "26: bodies[2].inertia = [1e-5, 1e-5, 3e-5]: expected principal moments none of "
        "which exceeds the sum of the others",
    ),
    (
        "section: proximal",
        "section: proximall",
        "28: actuators[0].section = proximall: expected the name of a section of the "
        "rod, one of proximal, distal (did you mean proximal?)",
    ),
    (
        "rod: arm, section",
        "rod: amr, section",
        "28: actuators[0].rod = amr: expected the name of a rod, one of arm (did you mean arm?)",
    ),
    (
        "strain: bend_y",
        "strain: stretch",
        "28: actuators[0].strain = stretch: expected one of torsion, bend_y, bend_z",
    ),
    (
        "joint: shoulder}",
        "joint: sholder}",
        "29: actuators[1].joint = sholder: expected the name of a revolute or universal joint, "
        "one of shoulder (did you mean shoulder?)",
    ),
    (
        "limits: [-1, 1]",
        "limits: [1, -1]",
        "28: actuators[0].limits = [1, -1]: expected [low, high] with low <= high",
    ),
    (
        "safe: 0",
        "safe: 2",
        "28: actuators[0].safe = 2: expected a number within the limits [-1, 1]",
    ),
    (
        "end: 0.4, offset",
        "end: 0.6, offset",
        "30: actuators[2].end = 0.6: expected a number in [0, 0.5]",
    ),
    (
        "end: 0.4, offset",
        "start: 0.4, end: 0.3, offset",
        "30: actuators[2].start = 0.4: expected start < end, they are 0.4 and 0.3",
    ),
    (
        "offset: [0.01, 0]",
        "offset: [0.01, 0, 0]",
        "30: actuators[2].offset = [0.01, 0, 0]: expected a list of 2 entries, each a "
        "finite number",
    ),
    (
        "offset: [0.01, 0]",
        "offset: [0.01, 0], limits: [-5, 5]",
        "30: actuators[2].limits = [-5, 5]: expected limits >= 0, a tendon cannot push",
    ),
    (
        "turns: 1",
        "pitch: 0",
        "31: actuators[3].helix.pitch = 0: expected a number other than 0 (m of arc "
        "length per turn)",
    ),
    (
        "tendon: spiral",
        "tendon: cable",
        "31: actuators[3].tendon = cable: expected a name that is not used twice",
    ),
    (
        "body: arm, s: 0.5",
        "body: arm, s: 0.7",
        "33: loads[0].s = 0.7: expected a number in [0, 0.5]",
    ),
    (
        "body: arm, s: 0.5",
        "body: payload, s: 0.5",
        "33: loads[0].s = 0.5: expected no such key: payload is not a rod",
    ),
    (
        "body: arm, s: 0.5, force: [0, 1, 0]",
        "body: arm, s: 0.5",
        "33: loads[0] = {point: push, body: arm, s: 0.5, schedule: {start: 1, end: …: "
        "expected a force or a moment",
    ),
    (
        "start: 1, end: 2",
        "start: 3, end: 2",
        "33: loads[0].schedule.end = 2: expected a number > 3",
    ),
    (
        "ramp: 0.1",
        "ramp: 0.6",
        "33: loads[0].schedule.ramp = 0.6: expected at most half the time between start "
        "and end, 1 s",
    ),
    (
        "positions: {shoulder",
        "positions: {elbow",
        "36: initial.positions.elbow = 0.5: expected a known key, one of shoulder",
    ),
    (
        "positions: {shoulder: 0.5}",
        "guesses: {shoulder: 0.5}",
        "36: initial.guesses = {shoulder: 0.5}: expected no such key: state: reference begins at "
        "positions, nothing is searched",
    ),
    (
        "positions: {shoulder: 0.5}",
        "state: equilibrium\n  positions: {shoulder: 0.5}\n  guesses: {shoulder: 0.4}",
        "38: initial.guesses.shoulder = 0.4: expected no joint that positions hold",
    ),
    (
        "arm/distal: {bend_z: 1}",
        "arm/distal: {stretch: 1}",
        "37: initial.strains.arm/distal.stretch = 1: expected no such key: this strain "
        "is not among the rod's strains",
    ),
    (
        "step: 0.001",
        "step: 1/3",
        "39: numerics.step = 1/3: expected a number > 0",
    ),
    (
        "step: 0.001",
        "step: 0.0000000015",
        "39: numerics.step = 0.0000000015: expected a time in s that is a whole number "
        "of nanoseconds",
    ),
    (
        "kind: legendre",
        "kind: legender",
        "40: numerics.basis.kind = legender: expected one of legendre, chebyshev, "
        "monomial, constant, linear (did you mean legendre?)",
    ),
    (
        "order: {bend_y: 4}",
        "order: {stretch: 2}",
        "40: numerics.basis.order.stretch = 2: expected no such key: this strain is not "
        "active, its order has no effect",
    ),
    (
        "order: {bend_z: 4}",
        "order: {shear_y: 4}",
        "41: numerics.rods.arm.order.shear_y = 4: expected no such key: this strain is "
        "not active, its order has no effect",
    ),
    (
        "order: {bend_y: 4}",
        "order: {bend_y: 2.5}",
        "40: numerics.basis.order.bend_y = 2.5: expected a whole number in [0, 50]",
    ),
    (
        "kind: legendre",
        "kind: constant",
        "40: numerics.basis.order = {bend_y: 4}: expected no such key: a constant basis "
        "has a fixed order",
    ),
    (
        "elements: 2",
        "elements: 0",
        "40: numerics.basis.elements = 0: expected a number in [1, 10000]",
    ),
    (
        "nodes: auto",
        "nodes: many",
        "40: numerics.basis.nodes = many: expected a number in [2, 100]",
    ),
    (
        "  step: 0.001",
        "  step: 0.001\n  integrator: rk4",
        "40: numerics.integrator = rk4: expected one of sdirk2, sdirk3, sdirk4, "
        "implicit_midpoint, generalized_alpha, energy_midpoint, "
        "adaptive (did you mean sdirk4?)",
    ),
    (
        "rods: {arm:",
        "rods: {leg:",
        "41: numerics.rods.leg = {order: {bend_z: 4}}: expected a known key, one of arm",
    ),
    (
        "axis: [0, 0, 1]",
        "axis: [0, 0, 1",
        "11: scene = (expected ',' or ']', but got ':'): expected valid YAML",
    ),
    (
        "    mass: 0.1",
        "	mass: 0.1",
        "25: scene = (found character '\\t' that cannot start any token): expected valid YAML",
    ),
    (
        "name: demo",
        "name: !python demo",
        "1: scene = (found the tag !python): expected valid YAML",
    ),
    (
        "name: demo",
        "name: demo\n---\nname: two",
        "2: scene = (but found another document): expected valid YAML",
    ),
    (
        "initial:\n  positions: {shoulder: 0.5}\n  strains: {arm/distal: {bend_z: 1}}",
        "initial: 5",
        "35: initial = 5: expected a mapping (key: value)",
    ),
    (
        "  - rigid_body: payload",
        "  - payload",
        "25: scene = (mapping values are not allowed here): expected valid YAML",
    ),
    (
        "  - rigid_body: payload",
        "  - {}\n  - rigid_body: payload",
        "24: bodies[2] = {}: expected one of the keys rod, flexible_link, joint, rigid_body",
    ),
    (
        "name: demo",
        "name: 'de mo'",
        "1: name = 'de mo': expected a name of letters, digits and _ that starts with a letter",
    ),
    (
        "strains: [torsion, bend_y, bend_z]",
        "strains: []",
        "13: bodies[1].strains = []: expected at least one of torsion, bend_y, bend_z, "
        "stretch, shear_y, shear_z",
    ),
    (
        "offset: [0.01, 0]",
        "offset: [0.01, 0], helix: {radius: 0.01, turns: 1}",
        "30: actuators[2].helix = {radius: 0.01, turns: 1}: expected only one of offset and helix",
    ),
]


def test_scene_without_mistakes_is_read():
    scene = parse_scene(SCENE, "demo.yaml")
    assert [body.name for body in scene.bodies] == ["shoulder", "arm", "payload"]


@pytest.mark.parametrize(
    ("right", "wrong", "message"), MISTAKES, ids=[f"{m[1]!r}"[:50] for m in MISTAKES]
)
def test_message(right, wrong, message):
    assert right in SCENE
    with pytest.raises(SceneError) as caught:
        parse_scene(SCENE.replace(right, wrong, 1), "demo.yaml")
    assert str(caught.value) == f"demo.yaml:{message}"


def test_error_keeps_its_parts():
    with pytest.raises(SceneError) as caught:
        parse_scene(SCENE.replace("0.49", "0.7"), "demo.yaml")
    error = caught.value
    assert (error.file, error.line, error.value) == ("demo.yaml", 6, "0.7")
    assert error.key_path == "materials.silicone.poisson_ratio"
    assert error.expected == "a number in (-1, 0.5]"


@pytest.mark.parametrize("text", ["", "# only a comment", "~", "5", "[1, 2]", "bodies:", "a: b: c"])
def test_files_that_are_no_scene_are_refused(text):
    with pytest.raises(SceneError, match=r"^empty\.yaml"):
        parse_scene(text, "empty.yaml")


def test_tangled_yaml_is_refused_and_not_run_into():
    for text in ("[" * 5000, "a: &a [*a]", "bodies: &b [{rod: *b}]", 'a: "\\UFFFFFFFF"', "a: \x00"):
        with pytest.raises(SceneError):
            parse_scene(text)
