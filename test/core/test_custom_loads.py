"""Loads by laws of the user's are right in the residual, its tangent, statics and the ledger."""

import re
from pathlib import Path

import numpy as np
import own_laws
import pytest
import yaml
from differences import central_difference
from forests import forest_document, place, rod, tree_document
from scenes import random_state, rod_document, scene_of

from soft_sim_ros import register_load
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics import field
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import BadArgument, SceneError

SPRING = {"stiffness": 30.0, "x": 0.2, "y": 0.1, "z": 0.05}
MAGNET = {"dipole": 0.4, "bx": 0.1, "by": -0.3, "bz": 0.5}
WIND = {"drag": 0.8, "u": 1.0, "v": -2.0, "w": 0.5}


def custom(name, law, parameters, body, **where):
    return {"custom": name, "law": law, "parameters": parameters, "body": body} | where


def loaded_tree():
    document = tree_document(base={"position": [0.1, 0.2, -0.3], "rpy": [0.4, -0.7, 1.1]})
    document["loads"] = [
        custom("tie", "spring", SPRING, "left", s=0.1),
        custom("field", "magnet", MAGNET, "thumb", start=0.03, end=0.12),
        custom("gale", "wind", WIND, "second", start=0.0, end=0.25),
        custom("gust", "wind", WIND, "ring"),
    ]
    return document


@pytest.mark.parametrize("which", [0, 1, 2])
def test_the_tangent_with_custom_loads_is_its_difference_quotient(which):
    dynamics = Dynamics(scene_of(loaded_tree()))
    state = list(random_state(dynamics, 3))
    exact = dynamics.tangents(*state)[which]

    def residual(x):
        moved = [*state]
        moved[which] = x
        return dynamics.inverse_dynamics(*moved)

    size = np.full(dynamics.n, 1e-4) / np.maximum(dynamics.model.weight, 1e-3)
    quotient = central_difference(residual, state[which], size)
    scale = np.sqrt(np.outer(*2 * [np.abs(np.diag(exact)) + 1e-12]))
    assert np.max(np.abs(exact - quotient) / (scale + np.abs(exact))) < 3e-6
    document = loaded_tree()
    for load in document["loads"]:
        load["parameters"] = dict.fromkeys(load["parameters"], 0.0)
    without = Dynamics(scene_of(document)).tangents(*state)[which]
    assert which == 2 or np.abs(exact - without).max() > 1e-3


def test_a_spring_holds_a_tip_with_the_force_of_its_stretch():
    """The equilibrium is that under the dead force which the spring has there."""
    document = rod_document(gravity=(0, 0, -9.81), order=4)
    tied = document | {"loads": [custom("tie", "spring", SPRING, "rod")]}
    dynamics = Dynamics(scene_of(tied))
    q = equilibrium(dynamics, check=False)
    tip = dynamics.node_poses(q)[-1, :3, 3]
    force = SPRING["stiffness"] * (np.array([SPRING["x"], SPRING["y"], SPRING["z"]]) - tip)
    dead = Dynamics(scene_of(document))
    zero = np.zeros(dead.n)
    left = dead.residual(q, zero, zero, dead.forcing(tip=np.concatenate([np.zeros(3), force])))
    size = dead.residual(q, zero, zero, dead.forcing())
    assert np.linalg.norm(left) < 1e-9 * np.linalg.norm(size)
    assert np.linalg.norm(force) > 3.0


def test_a_magnet_with_a_dipole_per_length_is_a_moment_per_length():
    """Of a rod that hardly bends: δM = m × B along it."""
    stiff = {"young_modulus": 1e9, "shear_modulus": 4e8}
    document = rod_document(material=stiff, order=3)
    field_ = custom("field", "magnet", MAGNET, "rod", start=0.0, end=0.6)
    dynamics = Dynamics(scene_of(document | {"loads": [field_]}))
    q = equilibrium(dynamics, check=False)
    couple = np.cross([MAGNET["dipole"], 0, 0], [MAGNET["bx"], MAGNET["by"], MAGNET["bz"]])
    spread = [{"distributed": "m", "body": "rod", "moment": couple.tolist()}]
    other = Dynamics(scene_of(document | {"loads": spread}))
    expected = equilibrium(other, check=False)
    np.testing.assert_allclose(q, expected, atol=1e-3 * np.abs(expected).max())
    assert np.abs(expected).max() > 0.0


def test_the_power_of_custom_loads_closes_the_ledger():
    document = forest_document(
        [rod("rod", 0.3), rod("side", 0.2, place("rod", 0.15, rpy=[0, 0, 1]))],
        loads=[
            custom("tie", "spring", SPRING, "rod"),
            custom("gale", "wind", WIND, "side", start=0.0, end=0.2),
        ],
    )
    document["numerics"] |= {"integrator": "sdirk4", "step": 5e-4}
    simulation = Simulation(scene_of(document))
    simulation.advance(300)
    work, lost, residual = simulation.ledger()[4:]
    assert abs(work) > 0.01
    assert abs(residual) < 1e-5 * (abs(work) + lost)


def test_a_spring_to_a_point_keeps_the_energy_that_it_stores():
    """Kinetic, elastic, gravity and ½ k d² together, without damping."""
    document = rod_document(gravity=(0, 0, -9.81), order=2, loads=[
        custom("tie", "spring", SPRING, "rod")], numerics={
        "integrator": "energy_midpoint", "step": 5e-4})  # fmt: skip
    simulation = Simulation(scene_of(document))
    point = np.array([SPRING["x"], SPRING["y"], SPRING["z"]])
    tips = simulation.tips()

    def energy():
        gap = tips.poses()[0, :3] - point
        return simulation.ledger()[:3].sum() + 0.5 * SPRING["stiffness"] * gap @ gap

    before, start = energy(), tips.poses()[0, :3].copy()
    simulation.advance(400)
    assert np.linalg.norm(tips.poses()[0, :3] - start) > 0.05
    assert energy() == pytest.approx(before, rel=1e-5)


def test_derivatives_that_are_not_those_of_the_law_are_refused_when_it_is_registered():
    with pytest.raises(BadArgument, match=r"by_pose\[[345], [345]\] is .* differences give -"):
        register_load("bad", ("k", "x", "y", "z"), own_laws.spring, own_laws.wrong_slopes)
    with pytest.raises(BadArgument, match="differences give nan"):
        register_load("bad", ("k", "x", "y", "z"), own_laws.undefined, own_laws.spring_slopes)
    with pytest.raises(BadArgument, match="numba compiles"):
        register_load("bad", (), lambda p: None)
    with pytest.raises(BadArgument, match="a name of letters"):
        register_load("not a name", (), own_laws.spring)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"law": "sprung"}, "spring"),
        ({"parameters": {"stiffness": 1.0}}, "parameters.x"),
        ({"parameters": SPRING | {"w": 1.0}}, "parameters.w"),
        ({"start": 0.1, "s": 0.2}, "per length"),
        ({"body": "rood"}, "rod"),
    ],
)
def test_custom_loads_that_make_no_sense_are_refused_by_name(change, says):
    load = custom("tie", "spring", SPRING, "rod") | change
    with pytest.raises(SceneError, match="loads") as error:
        scene_of(rod_document(loads=[load]))
    assert says in str(error.value)


def test_forms_that_do_not_know_custom_loads_say_so():
    scene = scene_of(rod_document(loads=[custom("tie", "spring", SPRING, "rod")]))
    dynamics = Dynamics(scene)
    with pytest.raises(SceneError, match="field equations"):
        field.fields(dynamics, np.zeros(dynamics.n))


def test_the_page_about_extending_bends_an_arm():
    text = (Path(__file__).parents[2] / "docs" / "extending.md").read_text(encoding="utf-8")
    section_ = text.partition("## A load of your own")[2]
    code, loads = (
        re.search(rf"```{kind}\n(.*?)```", section_, re.S)[1] for kind in ("python", "yaml")
    )
    exec(code, {})
    document = yaml.safe_load(loads) | {
        "base": {"position": [0.5, 0.1, 0.8], "rpy": [0.0, 1.5707963, 0.0]},
        "materials": {"soft": {"young_modulus": 5e5, "poisson_ratio": 0.5, "density": 1000.0}},
        "bodies": [rod("arm", 0.3)],
    }
    dynamics = Dynamics(scene_of(document))
    q = equilibrium(dynamics, check=False)
    document["loads"] = []
    other = Dynamics(scene_of(document))
    straight = other.node_poses(equilibrium(other, check=False))[-1, :3, 3]
    moved = dynamics.node_poses(q)[-1, :3, 3] - straight
    assert np.linalg.norm(moved) > 0.01
    assert moved[0] > 0.005  # the anchor is beside the hanging tip
