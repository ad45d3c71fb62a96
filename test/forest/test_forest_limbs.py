"""Backbones and tips have the names and the order of the compiled model, known from the scene."""

from __future__ import annotations

import pytest
from branched import NAMES

from soft_sim_ros.core.accuracy.contract import settle
from soft_sim_ros.core.compile.scene import compile_scene
from soft_sim_ros.recording.topics import OUTPUTS, output_keys
from soft_sim_ros.scene import Scene, load_scene, packaged_scenes, parse_scene
from soft_sim_ros.scene.limbs import limbs_of

HEAD = """
name: odd
materials: {soft: {young_modulus: 1.0e6, shear_modulus: 3.4e5, density: 1000.0}}
numerics: {basis: {order: {bend_y: 1}}, step: 1.0e-3}
bodies:
"""
ROD = (
    "  - {rod: NAME, PARENT sections: [{name: s, length: 0.2, material: soft, "
    "cross_section: {shape: circle, radius: 0.01}}]}\n"
)


def rod(name: str, parent: str = "") -> str:
    return ROD.replace("NAME", name).replace("PARENT", f"parent: {parent}," if parent else "")


ODD = {
    "a bend between two rods": rod("one") + rod("two", "{body: one, offset: {rpy: [0, 0, 1]}}"),
    "a joint without size where others are attached": rod("one")
    + "  - {joint: end, kind: fixed}\n"
    + rod("two", "{body: one, offset: {position: [0, 0.1, 0]}}"),
    "a mark without size at a tip": rod("one") + "  - {joint: end, kind: fixed}\n",
    "everything besides the base": rod("one", "{body: base, offset: {position: [0, 0.1, 0]}}"),
    "a body at the start of a rod": rod("one") + rod("two", "{body: one, s: 0.0}"),
    "a tool beside": rod("one")
    + "  - {rigid_body: tool, mass: 0.1, parent: {body: one, offset: {position: [0, 0.1, 0]}}}\n",
}


def check(scene: Scene) -> None:
    compiled, limbs = compile_scene(settle(scene)), limbs_of(scene)
    assert limbs.backbones == tuple(compiled.backbones)
    assert [compiled.node_of(name) for name in limbs.tips] == list(compiled.tips)
    assert compiled.node_of(limbs.tips[-1]) == compiled.node_of(), "wrenches act on the last one"


@pytest.mark.parametrize("name", NAMES)
def test_a_forest_has_the_limbs_of_its_model(scenes, name):
    check(scenes[name])


@pytest.mark.parametrize("text", ODD.values(), ids=ODD.keys())
def test_odd_forests_have_the_limbs_of_their_models(text):
    check(parse_scene(HEAD + text, "odd.yaml"))


def test_limbs_are_in_the_order_of_the_recursion(scenes):
    limbs = limbs_of(scenes["ring"])
    assert limbs.rows == (("stem", "leaf"), ("twig",))
    assert limbs.tips == ("leaf", "twig", "ring")


@pytest.mark.parametrize("name", sorted(packaged_scenes()))
def test_a_chain_has_the_topics_it_always_had(name):
    scene = load_scene(name)
    if not (scene.attachments or scene.environment or scene.constraints):
        assert output_keys(limbs_of(scene)) == list(OUTPUTS)
