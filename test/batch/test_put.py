"""A value put in at a key path changes that value and nothing else."""

import re

import numpy as np
import pytest

from soft_sim_ros import load_scene
from soft_sim_ros.core.accuracy.contract import settle
from soft_sim_ros.core.compile.scene import compile_scene
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import parse_scene
from soft_sim_ros.scene.load_scene import packaged_scenes
from soft_sim_ros.scene.put import edited, key_path


def sections(scene, **values):
    text = edited(scene.read_text(), "reed.yaml", values)
    return parse_scene(text, "reed.yaml").bodies[0].sections


@pytest.mark.parametrize(
    "path", ["bodies[0].sections[1].length", "bodies.reed.sections.tip.length"]
)
def test_entries_of_lists_have_numbers_and_names(scene, path):
    root, tip = sections(scene, **{path: "0.3"})
    assert (root.length, tip.length) == (0.1, 0.3)


def test_a_value_shared_by_merging_changes_where_it_is_asked_to_only(scene):
    root, tip = sections(scene, **{"materials.other.young_modulus": "2e6"})
    assert (root.material.young_modulus, tip.material.young_modulus) == (1e6, 2e6)
    assert tip.material.density == 900.0


def test_changing_the_source_of_a_merge_changes_all_that_merge_it(scene):
    root, tip = sections(scene, **{"materials.rubber.young_modulus": "2e6"})
    assert (root.material.young_modulus, tip.material.young_modulus) == (2e6, 2e6)


def test_an_alias_is_changed_alone_and_an_anchor_with_its_aliases(scene):
    text = scene.read_text().replace("cross_section: {shape", "cross_section: &c {shape", 1)
    head, _, tail = text.rpartition("{shape: circle, radius: 0.01}")
    scene.write_text(head + "*c" + tail)
    path = "bodies.reed.sections.{}.cross_section.radius"
    for name, radii in (("root", (0.02, 0.02)), ("tip", (0.01, 0.02))):
        changed = sections(scene, **{path.format(name): "0.02"})
        areas = [section.cross_section.area(np.zeros(1))[0] for section in changed]
        np.testing.assert_allclose(np.sqrt(np.array(areas) / np.pi), radii, rtol=1e-12)


def test_missing_keys_are_added(scene):
    text = edited(scene.read_text(), "", {"base.position": "[0, 0, 1]", "numerics.step": "1e-3"})
    changed = parse_scene(text)
    np.testing.assert_array_equal(changed.base.position, [0.0, 0.0, 1.0])
    assert changed.numerics.step == 1e-3


@pytest.mark.parametrize("name", packaged_scenes())
def test_writing_a_scene_anew_does_not_change_what_it_means(name):
    scene = load_scene(name)
    again = parse_scene(edited(scene.source, scene.file, {"name": scene.name}), scene.file)
    assert repr(again.actuators) == repr(scene.actuators)
    assert repr(again.numerics) == repr(scene.numerics)
    compiled, anew = (compile_scene(settle(each)) for each in (scene, again))
    assert same(compiled.model, anew.model) and same(compiled.loads, anew.loads)


def same(one, other):
    """Tell whether nested tuples of arrays agree to the last bit."""
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return np.array_equal(one, other)


@pytest.mark.parametrize(
    "path", ["bodies.reed.sections.middle.length", "bodies[3]", "gravity.x", "numerics.step.x"]
)
def test_a_path_to_nowhere_is_refused_by_name(scene, path):
    with pytest.raises(SceneError) as caught:
        edited(scene.read_text(), "reed.yaml", {path: "1"})
    assert caught.value.key_path == path


@pytest.mark.parametrize("text", ["", ".a", "a.", "a[x]", "[0].a", "a b", "a..b"])
def test_what_is_no_key_path(text):
    with pytest.raises(ValueError, match=re.escape(text)):
        key_path(text)
