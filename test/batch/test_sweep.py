"""A sweep gives the runs it says, and the same ones every time."""

import numpy as np
import pytest

from soft_sim_ros.batch import read_sweep
from soft_sim_ros.errors import SceneError

E, L = "materials.rubber.young_modulus", "bodies.reed.sections.tip.length"


def test_a_grid_is_every_combination_the_last_key_fastest(sweep):
    runs = read_sweep(sweep(f"parameters:\n  {E}: [1e6, 2e6]\n  {L}: [0.1, 0.2, 0.3]\n"))
    assert [tuple(run.parameters.values()) for run in runs] == [
        (e, x) for e in ("1e6", "2e6") for x in ("0.1", "0.2", "0.3")
    ]
    assert len({run.name for run in runs}) == 6
    scene = runs[5].scene()
    assert scene.bodies[0].sections[0].material.young_modulus == 2e6
    assert scene.bodies[0].sections[1].length == 0.3


def test_a_list_goes_through_all_lists_together(sweep):
    text = f"combine: list\nparameters:\n  {E}: [1e6, 2e6]\n  {L}: [0.1, 0.2]\n"
    runs = read_sweep(sweep(text))
    assert [tuple(run.parameters.values()) for run in runs] == [("1e6", "0.1"), ("2e6", "0.2")]


def test_lists_of_different_lengths_do_not_go_together(sweep):
    with pytest.raises(SceneError, match=r"has 2.*has 1"):
        read_sweep(sweep(f"combine: list\nparameters:\n  {E}: [1e6, 2e6]\n  {L}: [0.1]\n"))


def test_ranges_are_spaced_evenly_in_themselves_or_in_their_logarithm(sweep):
    text = "{from: 1e4, to: 1e6, count: 3, scale: SCALE}\n"
    for scale, middle in (("linear", 505000.0), ("log", 1e5)):
        runs = read_sweep(sweep(f"parameters:\n  {E}: " + text.replace("SCALE", scale)))
        values = [float(run.parameters[E]) for run in runs]
        np.testing.assert_allclose(values, [1e4, middle, 1e6], rtol=1e-14)


def test_drawn_values_depend_on_the_seed_of_the_run_alone(sweep):
    text = f"repeats: REPEATS\nseed: 5\nparameters:\n  {L}: {{uniform: [0.1, 0.2]}}\n"
    few = read_sweep(sweep(text.replace("REPEATS", "20")))
    more = read_sweep(sweep(text.replace("REPEATS", "40")))
    assert [run.name for run in more[:20]] == [run.name for run in few]
    assert [run.seed for run in few] == list(range(5, 25))
    values = [float(run.parameters[L]) for run in more]
    assert 0.1 <= min(values) < 0.12 and 0.18 < max(values) <= 0.2
    assert len(set(values)) == 40


def test_the_digest_changes_with_everything_that_changes_the_outcome(sweep, scene):
    text = f"parameters:\n  {E}: 1e6\n"
    extras = ("", "publish_rate: 50\n", "poses: 9\n", "max_error: 1.0\n")
    names = {read_sweep(sweep(text + extra))[0].name for extra in extras}
    names.add(read_sweep(sweep(text), duration=0.2)[0].name)
    scene.write_text(scene.read_text() + "\n# a remark\n")
    names.add(read_sweep(sweep(text))[0].name)
    assert len(names) == 6
    assert read_sweep(sweep(text + "seed: 7\n"))[0].name in names


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (f"parameters:\n  {E}: []\n", f"parameters.{E}"),
        ("parameters:\n  'a b': [1]\n", "parameters.a b"),
        (f"parameters:\n  {E}: {{from: 1, to: 2}}\n", f"parameters.{E}.count"),
        (f"parameters:\n  {E}: {{log_uniform: [0, 1]}}\n", f"parameters.{E}.log_uniform[0]"),
        (f"parameters:\n  {E}: {{gaussian: [0, 1]}}\n", f"parameters.{E}"),
        ("combine: both\n", "combine"),
        ("repeat: 2\n", "repeat"),
        ("commands: a.csv\nparameters:\n  efforts.y: [1]\n", "parameters.efforts.y"),
    ],
)
def test_bad_sweeps_name_their_key(sweep, text, key):
    with pytest.raises(SceneError) as caught:
        read_sweep(sweep(text))
    assert caught.value.key_path == key
    assert caught.value.line
