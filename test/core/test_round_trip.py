"""Whatever numerics a search may choose, they can be written down and read again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import ALL, plain

from soft_sim_ros.core.refine.refinement import Refinement, source_with
from soft_sim_ros.scene import Free, parse_scene

BASES = st.fixed_dictionaries(
    {},
    optional={
        "kind": st.sampled_from(["legendre", "chebyshev", "monomial", "linear", "constant"]),
        "order": st.integers(0, 9),
        "elements": st.integers(1, 5),
        "nodes": st.one_of(st.just("auto"), st.integers(16, 100)),
    },
)


@st.composite
def scenes(draw):
    """Give the text of a scene of one to three rods, straight, coiled or with features."""
    rods = []
    for i in range(draw(st.integers(1, 3))):
        length = draw(st.floats(0.05, 2.0))
        turns = draw(st.sampled_from([0.0, 0.5, 3.0, 20.0, 70.0]))
        bend = 2.0 * np.pi * turns / length
        section = {
            "name": "s",
            "length": length,
            "material": "m",
            "cross_section": {"shape": "circle", "radius": 0.002},
            "reference": {"curvature": [0.1 * bend, bend, 0.0]},
        }
        strains = draw(st.lists(st.sampled_from(ALL), min_size=1, unique=True))
        rods.append({"rod": f"r{i}", "strains": strains, "sections": [section]})
    basis = draw(BASES)
    if basis.get("kind") in ("linear", "constant"):
        basis.pop("order", None)
    numerics = {"tolerance": draw(st.sampled_from([1e-1, 1e-3, 1e-5, 1e-8])), "basis": basis}
    if draw(st.booleans()):
        numerics["rods"] = {"r0": {"nodes": draw(st.integers(16, 100))}}
    material = {"young_modulus": 1e6, "poisson_ratio": 0.4, "density": 1000.0}
    return yaml.safe_dump(
        plain({"name": "x", "materials": {"m": material}, "bodies": rods, "numerics": numerics})
    )


@settings(max_examples=40, deadline=None)
@given(scenes(), st.lists(st.sampled_from(["all", "nodes", "space", "time"]), max_size=7))
def test_every_choice_can_be_read_again(text, course):
    scene = parse_scene(text, "x.yaml")
    rules = Refinement(scene, scene.numerics.tolerance)
    numerics = rules.first()
    for step in course:
        every = {(n, s): 30.0 for n, b in numerics.rods.items() for s in b.order}
        numerics = {
            "all": rules.all_finer,
            "nodes": lambda now: rules.more_nodes(now, 40.0),
            "space": lambda now, every=every: rules.more_space(now, every),
            "time": lambda now: rules.more_time(now, 5.0),
        }[step](numerics)
    fixed = replace(numerics, free=Free())
    again = parse_scene(source_with(scene, fixed), "x.yaml")
    assert not again.numerics.free
    assert replace(again.numerics, basis=fixed.basis) == fixed
    finer = rules.finest(numerics).rods  # no text has to hold it, but a rod does
    assert all(b.elements >= fixed.rods[name].elements for name, b in finer.items())


def test_what_turns_often_gets_more_elements_not_more_nodes_than_a_scene_may_say():
    section = {
        "name": "s",
        "length": 0.5,
        "material": "m",
        "cross_section": {"shape": "circle", "radius": 0.002},
        "reference": {"curvature": [0.0, 2.0 * np.pi * 8 / 0.5, 0.0]},
    }
    material = {"young_modulus": 1e6, "poisson_ratio": 0.4, "density": 1000.0}
    document = {
        "name": "coil",
        "materials": {"m": material},
        "bodies": [{"rod": "r", "sections": [section]}],
        "numerics": {"tolerance": 1e-2},
    }
    scene = parse_scene(yaml.safe_dump(plain(document)), "coil.yaml")
    chosen = Refinement(scene, 1e-2).first().rods["r"]
    assert chosen.elements > 1 and chosen.nodes <= 100
    assert chosen.elements * (chosen.nodes - 1) >= 3.0 * 2.0 * np.pi * 8
