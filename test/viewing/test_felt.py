"""Contacts, reactions and surroundings are drawn where they are, and nowhere else."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.recording.cdr_markers import MarkerArrayBuffer
from soft_sim_ros.scene import load_scene, parse_scene
from soft_sim_ros.viewing import felt
from soft_sim_ros.viewing.scenery import Scenery
from soft_sim_ros.viewing.shapes import CUBE, CYLINDER, REMOVED, SHOWN, SLIPS, SPHERE, STICKS
from soft_sim_ros.viewing.surroundings import PARTS, surroundings

AROUND = """
name: around
materials: {m: {young_modulus: 1.0e+6, poisson_ratio: 0.5, density: 1000.0}}
base: {position: [0.0, 0.0, 1.0]}
bodies:
  - rod: arm
    sections:
      - {name: a, length: 0.4, material: m, cross_section: {shape: circle, radius: 0.01}}
environment:
  - {plane: wall, position: [0.5, 0.0, 0.0], normal: [-1.0, 0.0, 0.0]}
  - {sphere: ball, position: [0.0, 1.0, 0.0], radius: 0.1}
  - {capsule: pipe, from: [0.0, 2.0, 0.0], to: [0.0, 2.0, 1.0], radius: 0.05}
  - {cylinder: tube, from: [0.0, 0.0, 1.0], to: [0.4, 0.0, 1.0], radius: 0.03, inside: true}
  - {box: brick, position: [0.0, 3.0, 0.0], size: [0.1, 0.2, 0.3], rpy: [0.0, 0.0, 0.5]}
  - {ellipsoid: egg, position: [0.0, 4.0, 0.0], semi_axes: [0.1, 0.2, 0.3]}
numerics: {step: 0.001}
"""


def drawn(simulation):
    """Draw a simulation; return its canvases by group and number."""
    scenery = Scenery(simulation)
    shapes = [part.shape for part in scenery.parts]
    message = MarkerArrayBuffer(
        "world", [(s.group, s.number, s.kind, s.scale, s.colour, s.points) for s in shapes]
    )
    scenery.draw(message.slates)
    return {(s.group, s.number): c for s, c in zip(shapes, message.slates, strict=True)}


def corner(shape, pose, unit):
    """Return where a point (3,) of a solid of size 1 is."""
    turn = Rotation.from_quat(pose[3:]).as_matrix()
    return pose[:3] + turn @ (np.array(shape.scale) * unit)


def test_shapes_stand_where_the_scene_has_them():
    found = surroundings(parse_scene(AROUND, "around.yaml"), 0.4)
    by_number = {shape.number: (shape, pose) for shape, pose in found}
    assert list(by_number) == [0, PARTS, 2 * PARTS, 2 * PARTS + 1, 2 * PARTS + 2, 3 * PARTS,
                               4 * PARTS, 5 * PARTS]  # fmt: skip
    assert {shape.group for shape, _ in found} == {"environment"}
    shape, pose = by_number[0]  # its face is the plane, before the base, and all of it behind
    assert shape.kind == CUBE
    np.testing.assert_allclose(corner(shape, pose, [0, 0, 0.5]), [0.5, 0.0, 1.0], atol=1e-12)
    assert corner(shape, pose, [0, 0, -0.5])[0] > 0.5
    shape, pose = by_number[PARTS]
    assert (shape.kind, shape.scale) == (SPHERE, (0.2, 0.2, 0.2))
    for end, number in ((0.0, 2 * PARTS + 1), (1.0, 2 * PARTS + 2)):
        shape, pose = by_number[number]
        assert shape.kind == SPHERE
        np.testing.assert_allclose(pose[:3], [0.0, 2.0, end])
    shape, pose = by_number[3 * PARTS]
    assert shape.kind == CYLINDER
    assert shape.colour[3] < by_number[0][0].colour[3]  # seen through: the arm is inside
    np.testing.assert_allclose(corner(shape, pose, [0, 0, 0.5]), [0.4, 0, 1], atol=1e-12)
    assert shape.scale[:2] == (0.06, 0.06)
    shape, pose = by_number[4 * PARTS]
    expected = [0.05 * np.cos(0.5) - 0.1 * np.sin(0.5), 3 + 0.05 * np.sin(0.5) + 0.1 * np.cos(0.5)]
    np.testing.assert_allclose(corner(shape, pose, [0.5, 0.5, 0.5])[:2], expected)
    np.testing.assert_allclose(by_number[5 * PARTS][0].scale, [0.2, 0.4, 0.6])


def test_an_arrow_stands_at_every_contact_and_points_with_its_force(monkeypatch):
    simulation = Simulation(load_scene("table"))
    simulation.set_efforts([0.0, 20.0, 0.0])
    simulation.advance(320)
    contacts = simulation.contacts()
    assert 1 < len(contacts) < felt.MOST
    canvases = drawn(simulation)
    for number in range(felt.MOST):
        canvas = canvases["contacts", number]
        if number >= len(contacts):
            assert canvas.action[0] == REMOVED
            continue
        contact = contacts[number]
        assert canvas.action[0] == SHOWN
        np.testing.assert_allclose(canvas.points[0], contact.point)
        way = canvas.points[1] - canvas.points[0]
        assert way @ contact.force == pytest.approx(
            np.linalg.norm(way) * np.linalg.norm(contact.force)
        )
        np.testing.assert_allclose(canvas.colour, STICKS if contact.sticks else SLIPS)
    # of more contacts than arrows the largest are shown
    monkeypatch.setattr(felt, "MOST", 1)
    few = felt.strongest(contacts)
    sizes = sorted(np.linalg.norm(contact.force) for contact in contacts)
    assert sorted(np.linalg.norm(contact.force) for contact in few) == sizes[-1:]


def test_reactions_are_drawn_at_the_first_frame():
    simulation = Simulation(load_scene("closed_arch"))
    canvases, reaction = drawn(simulation), simulation.reactions()["foot"]
    for number, vector in ((0, reaction.force), (1, reaction.moment)):
        canvas = canvases["reactions", number]
        np.testing.assert_allclose(canvas.points[0], [0.41, 0.0, 0.0], atol=1e-9)
        way = canvas.points[1] - canvas.points[0]
        assert way @ vector == pytest.approx(np.linalg.norm(way) * np.linalg.norm(vector))
    simulation.release("foot")
    simulation.advance(1)
    assert drawn(simulation)["reactions", 0].action[0] == REMOVED


def test_an_arm_that_feels_nothing_has_no_arrows():
    groups = {group for group, _ in drawn(Simulation(load_scene("soft_arm")))}
    assert not groups & {"contacts", "reactions"}
