"""docs/scene.md says what the reader does."""

import re
from pathlib import Path

import pytest

from soft_sim_ros.scene import BASES, INTEGRATORS, STRAINS, packaged_scenes, parse_scene
from soft_sim_ros.scene.reader import Reader

TEXT = (Path(__file__).parents[2] / "docs" / "scene.md").read_text(encoding="utf-8")
EXAMPLE = re.search(r"```yaml\n(.*?)```", TEXT, re.DOTALL).group(1)
EVERY_KIND = """
materials: {m: {young_modulus: 1e6, poisson_ratio: 0.3, density: 1000}}
bodies:
  - {joint: hinge, kind: revolute, axis: [0, 0, 1], offset: {position: [0, 0, 0]}}
  - rod: arm
    sections:
      - &one {name: a, length: 1, material: m, cross_section: {shape: circle, radius: 0.02}}
      - {<<: *one, name: b, cross_section: {shape: annulus, outer: 0.02, inner: 0.01}}
      - {<<: *one, name: c, cross_section: {shape: rectangle, width_y: 0.02, width_z: 0.01}}
      - {<<: *one, name: d, cross_section: {shape: ellipse, semi_axis_y: 1, semi_axis_z: 1}}
  - {rigid_body: payload, mass: 1}
actuators:
  - {moment: m, rod: arm, section: a, strain: bend_y}
  - {joint_torque: j, joint: hinge}
  - {tendon: t, rod: arm, helix: {radius: 0.01, turns: 1}}
  - {tendon: u, rod: arm, offset: {from: [0.01, 0], to: [0, 0]}, friction: 0.1}
  - {tendon: v, rod: arm, points: [[0.0, 0, 0], [0.1, 0, 0]], control: length, axial_stiffness: 1}
  - {chamber: c, rod: arm, offset: [0, 0], area: 1e-4}
loads:
  - {point: p, body: arm, force: [0, 0, 1], schedule: {end: 1}}
  - {distributed: d, body: arm, force: [0, 0, 1]}
initial: {strains: {arm/a: {bend_y: 1}}}
numerics: {basis: {order: {bend_y: 1}}, rods: {arm: {kind: linear}}}
"""


def test_the_example_is_a_valid_scene():
    scene = parse_scene(EXAMPLE, "example.yaml")
    assert [body.name for body in scene.bodies] == ["turntable", "tube", "gripper"]
    assert [actuator.name for actuator in scene.actuators] == ["turn", "pull"]


def test_every_key_that_is_read_is_documented(monkeypatch):
    known = set()
    only = Reader.only

    def listen(reader, *keys):
        # Keys that are names of the scene's own things are no part of the format.
        if reader.path not in ("initial.positions", "initial.velocities", "initial.strains",
                               "numerics.rods"):  # fmt: skip
            known.update(keys)
        return only(reader, *keys)

    monkeypatch.setattr(Reader, "only", listen)
    parse_scene(EVERY_KIND)
    assert {"radius", "inner", "pitch", "ramp", "nodes", "axial_viscosity", "quaternion"} <= known
    words = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`\n]+)`", TEXT))))
    assert known - words == set()


@pytest.mark.parametrize("words", [STRAINS, INTEGRATORS, BASES])
def test_every_choice_is_documented(words):
    assert [word for word in words if f"`{word}`" not in TEXT] == []


def test_every_packaged_scene_says_what_it_is():
    for name, path in packaged_scenes().items():
        text = path.read_text(encoding="utf-8")
        assert text.startswith("# "), name
        assert parse_scene(text, str(path)).name == name


def test_links_inside_the_document_lead_somewhere():
    headings = {
        re.sub(r"[^\w -]", "", title).strip().lower().replace(" ", "-")
        for title in re.findall(r"^#+ (.*)$", TEXT, re.MULTILINE)
    }
    links = set(re.findall(r"\]\(#([^)]+)\)", TEXT))
    assert links and links - headings == set()
