"""What a coarse model shows, a finer one shows alike: strains, rates, poses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import rod_document, scene_of

from soft_sim_ros.core.compile.shape import strain
from soft_sim_ros.core.refine.prolong import finer, prolong, prolongation
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import load_scene

KINDS = [
    ("legendre", 1), ("legendre", 3), ("chebyshev", 2), ("monomial", 1), ("constant", 4),
    ("linear", 3),
]  # fmt: skip


def rod(kind: str = "legendre", elements: int = 1, **numerics):
    """Return a curved rod of two sections, cut by a load within the first."""
    document = rod_document(kind=kind, elements=elements, order=3, strains=["torsion", "bend_z"])
    section = document["bodies"][0]["sections"][0]
    section |= {"length": 0.3, "reference": {"curvature": [0.5, 0.0, 4.0]}}
    document["bodies"][0]["sections"].append(section | {"name": "t", "length": 0.2})
    document["loads"] = [{"point": "pull", "body": "rod", "s": 0.11, "force": [0.0, 0.0, 1.0]}]
    document["numerics"]["basis"] |= numerics
    return scene_of(document)


@pytest.mark.parametrize(("kind", "elements"), KINDS)
def test_the_finer_model_shows_the_same_strains(kind, elements):
    arm = Dynamics(rod(kind, elements))
    fine = finer(arm)
    q = np.random.default_rng(3).normal(size=(2, arm.n))
    mapped = prolong(arm.compiled, fine.compiled, q)
    s = np.random.default_rng(4).uniform(0.0, 0.5, 40)
    assert fine.n > arm.n
    for before, after in zip(q, mapped, strict=True):
        wanted = strain(arm.compiled, "rod", before, s)
        assert strain(fine.compiled, "rod", after, s) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize(("kind", "elements"), KINDS)
def test_with_the_same_nodes_it_has_the_same_poses_and_twists(kind, elements):
    # with other nodes it has those of other nodes: the strains are the same, quadrature is not
    arm = Dynamics(rod(kind, elements, nodes=13))
    numerics = finer(arm).compiled.scene.numerics
    nodes = 7 if kind in ("constant", "linear") else 13
    rods = {name: replace(basis, nodes=nodes) for name, basis in numerics.rods.items()}
    fine = Dynamics(replace(arm.compiled.scene, numerics=replace(numerics, rods=rods)))
    q, v = 0.5 * np.random.default_rng(5).normal(size=(2, arm.n))
    up, rate = prolong(arm.compiled, fine.compiled, np.array([q, v]))
    tip, wanted = fine.node_poses(up)[-1], arm.node_poses(q)[-1]
    assert tip == pytest.approx(wanted, abs=1e-12 if nodes == 13 else 2e-6)
    twist, wanted = fine.node_twists(up, rate)[-1], arm.node_twists(q, v)[-1]
    assert twist == pytest.approx(wanted, abs=1e-12 if nodes == 13 else 2e-5)


def test_joints_links_and_hinges_are_copied():
    for name in ("mixed_chain", "floating_frame", "gantry", "flying_body"):
        arm = Dynamics(load_scene(name))
        fine = finer(arm)
        q = 0.1 * np.random.default_rng(6).normal(size=arm.n)
        mapped = prolong(arm.compiled, fine.compiled, q)
        for one in (*arm.compiled.chain.joints, *arm.compiled.chain.links):
            old, new = arm.compiled.chain.columns(one), fine.compiled.chain.columns(one)
            assert (mapped[new] == q[old]).all()
        assert fine.node_poses(mapped)[-1] == pytest.approx(arm.node_poses(q)[-1], abs=1e-5)


def test_to_another_kind_of_basis_goes_the_nearest_strain_field():
    arm, other = Dynamics(rod("legendre", 1)), Dynamics(rod("constant", 6))
    q = np.random.default_rng(7).normal(size=arm.n)
    mapped = prolong(arm.compiled, other.compiled, q)
    # of a piecewise constant strain: the mean over every element, here by the midpoint rule
    element = other.compiled.chain.rods["rod"].elements[3]
    s = np.linspace(*element.span, 20001)
    wanted = strain(arm.compiled, "rod", q, 0.5 * (s[1:] + s[:-1])).mean(axis=0)
    middle = np.array([0.5 * sum(element.span)])
    assert strain(other.compiled, "rod", mapped, middle)[0] == pytest.approx(wanted, rel=1e-7)


def test_the_finer_model_and_the_map_are_made_once():
    arm = Dynamics(rod())
    assert finer(arm) is finer(arm)
    first = prolongation(arm.compiled, finer(arm).compiled)
    assert prolongation(arm.compiled, finer(arm).compiled) is first
    numerics, more = arm.compiled.scene.numerics, finer(arm).compiled.scene.numerics
    assert more.step == numerics.step and more.integrator == numerics.integrator
    assert more.rods["rod"].order == {k: n + 2 for k, n in numerics.rods["rod"].order.items()}
