"""Without numerics the tip is right to 1e-3 of the length, or somebody is told.

Truth is another kind of basis on three elements with many nodes, or a closed form.
"""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
import yaml
from scenes import SOFT, plain

from benchmarks.curled import EI, LENGTH, at_rest, moving
from benchmarks.defaults import WAYS, entries_of, scene_of
from soft_sim_ros.core.accuracy.unwritten import settle_unwritten
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.refine.prolong import finer, prolong, reference_turn
from soft_sim_ros.core.refine.space_error import Forcing, motion_error, static_error
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import NotResolved
from soft_sim_ros.scene import load_scene, parse_scene

SCENES = {case.name: case for case in [*at_rest(), *moving()]}
BENT = {"moment": "bend", "rod": "rod", "section": "s", "strain": "bend_z"}


def arm(**more):
    """Return a short scene without numerics."""
    section = {"name": "s", "length": 0.3, "material": "soft"}
    section["cross_section"] = {"shape": "circle", "radius": 0.02}
    document = {
        "materials": {"soft": SOFT | {"viscosity": 1e4}},
        "bodies": [{"rod": "rod", "strains": ["bend_z"], "sections": [section]}],
        "actuators": [BENT],
    } | more
    return parse_scene(yaml.safe_dump(plain(document)), "arm.yaml")


@pytest.mark.parametrize("name", ["follower force 10", "coil of 2 turns, pulled", "bent by 540°"])
def test_a_state_of_rest_is_right_or_somebody_is_told(name):
    found = list(entries_of(SCENES[name]))
    assert {entry["numerics"] for entry in found} == set(WAYS)
    assert not any(entry["silent"] for entry in found)


def test_the_estimate_of_a_moment_in_a_motion_is_near_the_error_that_builds_up():
    found = list(entries_of(SCENES["falling arc 180°"]))
    assert not any(entry["silent"] for entry in found)
    companion = [entry for entry in found if entry["how"] == "companion"]
    for entry in companion:
        assert 0.6 < entry["estimate_rel"] / entry["error_rel"] < 2.5


def test_the_choice_is_the_same_every_time_and_stands_in_the_source():
    scenes = [arm(), arm()]
    one, other = (settle_unwritten(scene).scene for scene in scenes)
    assert one.source == other.source and one.numerics == other.numerics
    assert not one.numerics.free and one.numerics.integrator == "adaptive"
    again = parse_scene(one.source, "again.yaml")
    assert again.numerics.rods == one.numerics.rods
    assert again.numerics.options == one.numerics.options and not again.numerics.free
    simulation = Simulation(scenes[0])
    assert simulation.scene is one, "Dynamics, Simulation and recordings see one choice"


def test_numerics_that_are_empty_are_none_and_any_key_fixes_the_rest():
    for empty in ({}, None):
        assert arm(numerics=empty).numerics.free
        assert parse_scene(settle_unwritten(arm(numerics=empty)).scene.source, "a.yaml")
    partly = arm(numerics={"step": 0.001})
    assert not partly.numerics.free
    assert partly.numerics.rods["rod"].order == {"bend_z": 3}
    assert partly.numerics.integrator == "sdirk2"


def test_actuators_at_their_limits_decide_how_fine_the_space_is():
    mild = settle_unwritten(arm(actuators=[BENT | {"limits": [-0.05, 0.05]}])).scene
    # curled by three turns; gravity bends it within them
    limit = 3.0 * 2.0 * np.pi / 0.3 * 1e6 * np.pi * 0.02**4 / 4.0
    wild = settle_unwritten(arm(actuators=[BENT | {"limits": [-limit, limit]}])).scene
    sizes = [len(Dynamics(scene).compiled.coordinate_names) for scene in (mild, wild)]
    assert sizes[0] < sizes[1]


def test_a_load_that_nobody_announced_is_told_of_where_the_basis_does_not_show_it():
    case = SCENES["follower force 20"]
    coarse = Dynamics(scene_of(case, {"step": 0.002}))
    with pytest.warns(NotResolved) as said:
        q = equilibrium(coarse, tip=5.0 * np.array(case.tip), tip_follows=True, stable=False)
    warning = said[0].message
    assert warning.error > warning.limit and f"{warning.limit:g}" in str(warning)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        equilibrium(coarse, q, tip=5.0 * np.array(case.tip), tip_follows=True, check=False,
                    stable=False)  # fmt: skip
    written = Dynamics(scene_of(case, {"basis": {"order": 3}}))
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # who writes a basis asks for the check
        equilibrium(written, tip=5.0 * np.array(case.tip), tip_follows=True, stable=False)


def test_the_error_of_a_state_of_rest_is_the_way_to_the_finer_model():
    case = SCENES["moment, 1 turns"]
    model = Dynamics(scene_of(case, {"basis": {"order": 2}}))
    tip = np.array(case.tip)
    forcing = Forcing(None, 0.0, 1.0, tip, True)
    q = equilibrium(model, tip=tip, tip_follows=True, stable=False)
    fine = finer(model, reference_turn(model.compiled, q))
    start = prolong(model.compiled, fine.compiled, q)
    p = equilibrium(fine, start, tip=tip, tip_follows=True, stable=False, check=False)
    ways = model.node_poses(q)[-1][:3, 3] - fine.node_poses(p)[-1][:3, 3]
    wanted = 1.25 * np.linalg.norm(ways) / LENGTH
    assert static_error(model, q, forcing) == pytest.approx(wanted, rel=1e-5)
    # at rest the forces of the moment say nearly the same, by one step
    moment = motion_error(model, q, np.zeros(model.n), forcing, 1e3)
    assert moment == pytest.approx(wanted, rel=0.3)


def test_uniform_bending_is_exact_in_any_basis_and_no_error_is_seen():
    # closed form: a moment at the tip bends a weightless rod to a circle
    case = replace(SCENES["moment, 1 turns"])
    model = Dynamics(scene_of(replace(case, document=case.document | {"gravity": [0, 0, 0]}),
                              {"basis": {"order": 1}}))  # fmt: skip
    tip = np.array([0.0, 0.0, 0.5 * np.pi * EI / LENGTH, 0.0, 0.0, 0.0])
    q = equilibrium(model, tip=tip, tip_follows=True)
    radius = LENGTH / (0.5 * np.pi)
    assert model.node_poses(q)[-1][:3, 3] == pytest.approx([radius, radius, 0.0], abs=1e-9)
    assert static_error(model, q, Forcing(None, 0.0, 1.0, tip, True)) < 1e-9


def test_a_look_changes_no_bit_of_the_motion():
    from soft_sim_ros.core.accuracy.space_watch import LookedInputs
    from soft_sim_ros.core.simulation.inputs import Inputs

    ends = []
    for kind, more in ((Inputs, {}), (LookedInputs, {"beat": 0.02})):
        simulation = Simulation(load_scene("soft_arm"))
        inputs = kind(simulation, 0.0, 0.0, **more)
        inputs.command(np.array([1.0, -1.0, 0.5, 0.3, -0.2, 0.1]))
        for _ in range(10):
            inputs.advance(10)
        ends.append(np.concatenate([simulation.q, simulation.v]).tobytes())
    assert ends[0] == ends[1] and inputs.space_rel > 0.0


@pytest.mark.parametrize("later", [True, False])
def test_looks_for_another_thread_begin_before_the_run(later, monkeypatch):
    """Kernels of the look are compiled before the node is ready, not while it runs."""
    from soft_sim_ros.core.accuracy import space_watch

    looked = []
    look = space_watch.motion_error
    monkeypatch.setattr(
        space_watch, "motion_error", lambda *seen: looked.append(seen) or look(*seen)
    )
    simulation = Simulation(load_scene("soft_arm"))
    inputs = space_watch.LookedInputs(simulation, 0.0, 0.0, beat=0.02, later=later)
    assert len(looked) == (1 if later else 0)
    assert np.isfinite(inputs.space_rel) == later
    inputs.advance(10)
    assert len(looked) == 1  # later: another thread has to catch up
    inputs.catch_up()
    assert len(looked) == (2 if later else 1)
