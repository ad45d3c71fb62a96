"""Environments that make no sense are refused with file, key and numbers."""

import pytest
from scenes import scene_of
from touching import body_document, rod_on_table

from soft_sim_ros.core.compile.scene import compile_scene
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import SceneError

FIRM = {"stiffness": 1e5}
TUBE = {"capsule": "tube", "from": [-1, 0, 0], "to": [1, 0, 0], "inside": True}


def refused(document, make=scene_of):
    with pytest.raises(SceneError) as found:
        make(scene_of(document) if make is not scene_of else document)
    return found.value


@pytest.mark.parametrize(
    ("friction", "key", "value", "expected"),
    [
        (-0.1, "contact.friction", "-0.1", ">= 0"),
        ({"kinetic": 0.5, "static": 0.3}, "contact.friction.static", "0.3", "kinetic = 0.5"),
        ({"static": 0.3}, "contact.friction.kinetic", "None", "number"),
        ({"kinetic": 0.0, "across": 0.3}, "contact.friction.kinetic", "0.0", "no friction at all"),
        ({"kinetic": 0.5, "acros": 0.3}, "contact.friction.acros", "0.3", "across"),
    ],
)
def test_coefficients_of_friction_that_cannot_be(friction, key, value, expected):
    error = refused(body_document(contact={"friction": friction}))
    assert error.key_path == key and str(error.value) == value and expected in error.expected


@pytest.mark.parametrize(
    ("shape", "key", "expected"),
    [
        ({"plane": "p", "normal": [0, 0, 0]}, "environment[0].normal", "not zero"),
        ({"sphere": "s", "radius": 0.0}, "environment[0].radius", "> 0"),
        ({"capsule": "c", "from": [0, 0, 1], "to": [0, 0, 1], "radius": 1}, "environment[0].to",
         "another point"),
        ({"cube": "c"}, "environment[0]", "plane, sphere"),
        ({"box": "b", "size": [1, 1, 1], "inside": True}, "environment[0].inside", "no inside"),
        ({"plane": "p", "bodies": ["nobody"]}, "environment[0].bodies[0]", "body"),
        ({"plane": "p", "contact": {"stifness": 1}}, "environment[0].contact.stifness",
         "stiffness"),
        ({"plane": "p", "contact": {"material": "steel"}}, "environment[0].contact.material",
         "material"),
    ],
)  # fmt: skip
def test_shapes_that_make_no_sense(shape, key, expected):
    error = refused(body_document(environment=[shape], contact=FIRM))
    assert error.key_path == key and expected in error.expected


def test_a_body_needs_a_stiffness_to_touch_with():
    error = refused(body_document(), compile_scene)
    assert error.key_path == "bodies[1].contact" and "stiffness" in error.expected


def test_a_rod_thicker_than_its_tube():
    document = rod_on_table(environment=[TUBE | {"radius": 0.01}])
    error = refused(document, compile_scene)
    assert error.key_path == "environment[0].capsule" and error.value == "tube"
    assert "rod has 0.01 m" in error.expected and "tube has 0.01 m" in error.expected
    compile_scene(scene_of(rod_on_table(environment=[TUBE | {"radius": 0.012}])))


def test_what_begins_in_a_shape_is_told_how_deep_unless_that_is_allowed():
    document = body_document(contact=FIRM, at=[0, 0, 0, 0, 0, 0.03])
    error = refused(document, Simulation)
    assert error.key_path == "environment[0].plane" and "0.02 m" in error.expected
    document["environment"] = [{"plane": "floor", "overlap": True}]
    Simulation(scene_of(document))


@pytest.mark.parametrize(
    "integrator", ["implicit_midpoint", "generalized_alpha", "energy_midpoint"]
)
def test_methods_that_do_not_end_with_a_stage_are_refused(integrator):
    document = body_document(contact=FIRM, numerics={"integrator": integrator})
    error = refused(document, compile_scene)
    assert error.key_path == "numerics.integrator" and "sdirk2" in error.expected


def test_contact_without_anything_to_touch_is_refused():
    document = body_document(contact=FIRM)
    del document["environment"]
    assert refused(document, compile_scene).key_path == "contact"
    document = body_document(contact=FIRM, body={"contact": False})
    assert refused(document, compile_scene).key_path == "environment"
    document = rod_on_table()
    document["bodies"][0] = {"flexible_link": "rod", "modes": 2} | {
        key: value for key, value in document["bodies"][0].items() if key != "rod"
    }
    error = refused(document, compile_scene)
    assert error.key_path == "bodies[0].contact" and "flexible_link" in error.expected


def test_an_arm_stands_on_the_table_that_it_is_mounted_on():
    document = rod_on_table(environment=[{"plane": "table"}])
    document["base"] = {"rpy": [0, -1.5707963267948966, 0]}
    assert Simulation(scene_of(document)).contacts() == ()
    document["base"] = {}
    assert "0.01 m" in refused(document, Simulation).expected
