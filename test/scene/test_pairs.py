"""What is refused of bodies that touch one another, and which pairs there are."""

import pytest
from meeting import free, rod, scene, solid
from scenes import scene_of

from soft_sim_ros.core.compile.scene import compile_scene
from soft_sim_ros.errors import SceneError


def document(pairs, **rest):
    bodies = [
        free("a"), rod("a"), {"rigid_body": "tip", "mass": 0.1},
        free("b"), rod("b"),
        free("ball"), solid("ball"),
    ]  # fmt: skip
    at = {"a": [0] * 6, "b": [0, 0, 0, 0, 0.5, 0], "ball": [0, 0, 0, 0, 1.0, 0]}
    law = {"stiffness": 1e5}
    numerics = {"basis": {"order": 1, "nodes": 4}}
    return scene(bodies, pairs, at, contact=law, numerics=numerics) | rest


@pytest.mark.parametrize(
    ("pairs", "key", "expected"),
    [
        ("some", "pairs", "all, or a list"),
        ([], "pairs", "at least one"),
        ([{}], "pairs[0]", "bodies, self"),
        ([{"bodies": ["a"]}], "pairs[0].bodies", "two names"),
        ([{"bodies": ["a", "c"]}], "pairs[0].bodies[1]", "body"),
        ([{"bodies": ["a", "fly_a"]}], "pairs[0].bodies[1]", "that can touch"),
        ([{"bodies": ["a", "tip"]}], "pairs[0].bodies[1]", "with a shape"),
        ([{"self": ["ball"]}], "pairs[0].self", "cannot touch itself"),
        ([{"self": ["a"], "bodies": ["a", "b"]}], "pairs[0].bodies", "only one of"),
        ([{"self": ["a"], "contact": {"friction": -1}}], "pairs[0].contact.friction", ">= 0"),
    ],
)
def test_pairs_that_make_no_sense_are_refused(pairs, key, expected):
    with pytest.raises(SceneError) as caught:
        scene_of(document(pairs))
    assert expected in caught.value.expected
    assert caught.value.key_path in (key, key.rsplit(".", 1)[0], "pairs[0].self")


def test_all_are_all_but_what_is_attached():
    found = {pair.bodies for pair in scene_of(document("all")).pairs}
    assert found == {("a", "a"), ("b", "b"), ("a", "b"), ("a", "ball"), ("b", "ball")}


def test_only_round_rods_touch_bodies():
    flat = document([{"bodies": ["a", "b"]}])
    section = flat["bodies"][1]["sections"][0]
    section["cross_section"] = {"shape": "rectangle", "width_y": 0.02, "width_z": 0.02}
    with pytest.raises(SceneError, match="circle or an annulus") as caught:
        compile_scene(scene_of(flat))
    assert caught.value.key_path == "bodies[1].sections[0].cross_section"


def test_a_thread_with_more_stations_than_can_be_is_refused():
    thin = document([{"bodies": ["a", "b"]}])
    thin["bodies"][1] = rod("a", 1e-7)
    with pytest.raises(SceneError, match="stations"):
        compile_scene(scene_of(thin))


def test_rigid_bodies_without_any_stiffness_are_refused():
    hard = document([{"bodies": ["a", "ball"]}])
    del hard["contact"]
    compile_scene(scene_of(hard))  # the rod is soft
    two = scene(
        [free("x"), solid("x"), free("y"), solid("y")], [{"bodies": ["x", "y"]}],
        {"x": [0] * 6, "y": [0, 0, 0, 1, 0, 0]},
    )  # fmt: skip
    with pytest.raises(SceneError, match="a stiffness in Pa") as caught:
        compile_scene(scene_of(two))
    assert caught.value.value == "x and y"


def test_bodies_that_begin_in_one_another_are_refused():
    from soft_sim_ros.core.settled import Simulation

    inside = document([{"bodies": ["a", "ball"]}])
    inside["initial"]["positions"]["fly_ball"] = [0, 0, 0, 0.1, 0.06, 0]
    with pytest.raises(SceneError, match="begin in one another") as caught:
        Simulation(scene_of(inside))
    assert "0.01 m" in caught.value.expected and caught.value.key_path == "pairs[0].bodies"
