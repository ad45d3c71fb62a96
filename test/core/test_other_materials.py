"""A model of other materials is that of its scene to the bit, and costs less than a new one."""

import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scenes import ALL, rod_document, scene_of, zoo_document

from soft_sim_ros import Simulation, compile_scene, initial_state
from soft_sim_ros.core.compile.other_materials import differ_in_materials
from soft_sim_ros.scene import Rod, load_scene
from soft_sim_ros.scene.material import Maxwell


def changed(scene, change):
    """Return a scene with the material of every section of its rods changed."""

    def of(body):
        if not isinstance(body, Rod):
            return body
        sections = [
            replace(section, material=change(section.material)) for section in body.sections
        ]
        return replace(body, sections=tuple(sections))

    return replace(scene, bodies=tuple(of(body) for body in scene.bodies))


def arrays(parts, of=""):
    """Give the arrays in nested named tuples by their names."""
    for name, part in parts._asdict().items():
        if isinstance(part, np.ndarray):
            yield of + name, part
        elif hasattr(part, "_asdict"):
            yield from arrays(part, f"{of}{name}.")


def assert_same(one, two):
    """Assert that two models have the same bits, and are spoken of alike."""
    for part in ("model", "loads"):
        for (name, a), (_, b) in zip(
            arrays(getattr(one, part)), arrays(getattr(two, part)), strict=True
        ):
            assert a.shape == b.shape and a.tobytes() == b.tobytes(), name
    assert one.coordinate_names == two.coordinate_names
    assert one.chain.frames == two.chain.frames and one.length == two.length
    np.testing.assert_array_equal(one.gravity, two.gravity)


def tapered():
    """Return a rod of two elements whose sections vary, with a kink between them."""
    section = {"cross_section": {"shape": "circle", "radius": [0.03, 0.02]},
               "reference": {"curvature": [0.5, [0.0, 1.0], 0.0]}}  # fmt: skip
    return rod_document(strains=ALL, order=3, elements=2, section=section)


FACTOR = st.floats(0.05, 20.0)
SCENES = {
    "zoo": lambda: scene_of(zoo_document()),
    "tapered": lambda: scene_of(tapered()),
    "splines": lambda: scene_of(rod_document(kind="linear", elements=4)),
    "tendon_arm": lambda: load_scene("tendon_arm"),
    "rubber_arm": lambda: load_scene("rubber_arm"),
    "catenary": lambda: load_scene("catenary"),
}


@pytest.fixture(scope="module")
def models():
    return {name: compile_scene(make()) for name, make in SCENES.items()}


@pytest.mark.parametrize("name", SCENES)
@settings(max_examples=6, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    factors=st.tuples(FACTOR, FACTOR, FACTOR, FACTOR),
    alpha=st.sampled_from([0.0, 0.7]),
    maxwell=st.none() | st.builds(Maxwell, FACTOR, FACTOR),
    law=st.booleans(),
)
def test_a_model_of_other_materials_is_that_of_its_scene_to_the_bit(
    models, name, factors, alpha, maxwell, law
):
    def change(material):
        young, shear, density, viscosity = factors
        return replace(
            material,
            young_modulus=young * material.young_modulus,
            shear_modulus=max(shear, young) * material.shear_modulus,
            density=density * material.density,
            viscosity=viscosity * (material.viscosity + 1.0),
            mass_damping=alpha,
            maxwell=maxwell,
            law=material.law if law else None,
        )

    like = models[name]
    scene = changed(like.scene, change)
    other = compile_scene(scene, like=like)
    assert_same(other, compile_scene(scene))
    assert other.scene is scene
    assert other.model.entry_phi is like.model.entry_phi  # it was not made again
    assert_same(compile_scene(like.scene, like=other), like)  # and back


@pytest.mark.parametrize(
    "change",
    [
        {"gravity": [0.0, 0.0, -1.0]},
        {"loads": []},
        {"actuators": []},
        {"base": {"position": [0.0, 0.0, 1.0]}},
        {"numerics": {"basis": {"order": 3}}},
    ],
)
def test_whatever_else_differs_makes_a_model_of_its_own(models, change):
    scene = scene_of(zoo_document() | change)
    assert not differ_in_materials(scene, models["zoo"].scene)
    assert_same(compile_scene(scene, like=models["zoo"]), compile_scene(scene))


@pytest.mark.parametrize(
    ("body", "key", "value"),
    [(0, "stiffness", 0.5), (1, "mass", 0.4), (2, "strains", ["bend_y"]), (3, "axis", [0, 0, 1.0])],
)
def test_another_body_makes_a_model_of_its_own(models, body, key, value):
    document = zoo_document()
    document["bodies"][body] |= {key: value}
    document["actuators"] = document["actuators"][:1] if key == "strains" else document["actuators"]
    scene = scene_of(document)
    assert_same(compile_scene(scene, like=models["zoo"]), compile_scene(scene))


def test_another_section_makes_a_model_of_its_own(models):
    document = zoo_document()
    document["bodies"][2]["sections"][1]["cross_section"]["width_y"] = 0.05
    scene = scene_of(document)
    assert_same(compile_scene(scene, like=models["zoo"]), compile_scene(scene))
    again = scene_of(zoo_document())  # read anew, and the same
    assert differ_in_materials(again, models["zoo"].scene)


def cpu(work, times):
    """Return the least time in s of this process that some work takes."""
    spent = []
    for _ in range(times):
        begin = time.process_time()
        work()
        spent.append(time.process_time() - begin)
    return min(spent)


def test_a_state_and_a_material_more_cost_a_small_part_of_a_model(models):
    model = models["tendon_arm"]
    state = initial_state(model)
    scene = changed(model.scene, lambda x: replace(x, young_modulus=1.1 * x.young_modulus))
    Simulation(compile_scene(scene, like=model))
    whole = cpu(lambda: compile_scene(scene), 4)
    assert cpu(lambda: Simulation(model, state), 20) < whole / 25
    assert cpu(lambda: Simulation(model), 20) < whole / 25
    assert cpu(lambda: compile_scene(scene, like=model), 20) < whole / 8
