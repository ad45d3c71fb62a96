"""Automatic nodes follow the order: their error stays below that of the basis."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scenes import rod_document, scene_of

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.compile.element import default_nodes
from soft_sim_ros.core.settled import Dynamics

LENGTH, RADIUS = 0.6, 0.01
STIFFNESS = 1e6 * np.pi * RADIUS**4 / 4


@cache
def tip(order: int, nodes: int | None = None, curvature: float = 0.0) -> np.ndarray:
    """Return the tip (3,) of an arm bent by about 90° with some torsion, under its weight."""
    section = {"reference": {"curvature": [0.0, 0.0, curvature]}}
    scene = scene_of(
        rod_document(
            length=LENGTH, radius=RADIUS, order=order, gravity=(0.0, 0.0, -0.5), section=section
        )
    )
    rods = {name: replace(basis, nodes=nodes) for name, basis in scene.numerics.rods.items()}
    dynamics = Dynamics(replace(scene, numerics=replace(scene.numerics, rods=rods)))
    moment = STIFFNESS * (0.5 * np.pi if curvature == 0.0 else 0.3) / LENGTH
    wrench = np.array([moment / 3.0, moment, 0.0, 0.0, 0.5 * STIFFNESS / LENGTH**2, 0.0])
    q = equilibrium(dynamics, tip=wrench, stable=False)
    return dynamics.node_poses(q)[-1][:3, 3]


@pytest.mark.parametrize("curvature", [0.0, np.pi / LENGTH])
def test_the_error_falls_with_the_order_alone(curvature):
    exact = tip(10, 300, curvature)
    errors = [np.linalg.norm(tip(p, None, curvature) - exact) / LENGTH for p in (1, 3, 5, 7)]
    limits = (5e-2, 5e-4, 1e-6, 1e-8)
    assert all(error < limit for error, limit in zip(errors, limits, strict=True)), errors


@pytest.mark.parametrize("order", [4, 6])
def test_automatic_nodes_add_less_than_the_basis_leaves_out(order):
    exact, same = tip(10, 300), tip(order, 300)
    own = np.linalg.norm(same - exact)
    assert np.linalg.norm(tip(order) - same) < 2.0 * own


@pytest.mark.parametrize(("bump", "pieces"), [(0.004, 1), (0.0001, 1), (0.004, 3)])
def test_a_rod_is_cut_where_a_tendon_turns_sharply(bump, pieces):
    width = 0.1 if pieces == 1 else 0.002
    middle = [[0.3 - width, 0.01, 0.0], [0.3, 0.01 + bump, 0.0], [0.3 + width, 0.01, 0.0]]
    points = [[0.0, 0.01, 0.0], [0.1, 0.01, 0.0], *middle, [0.5, 0.01, 0.0], [0.6, 0.01, 0.0]]
    tendon = {"tendon": "t", "rod": "rod", "points": points}
    dynamics = Dynamics(scene_of(rod_document(length=LENGTH, order=1, actuators=[tendon])))
    ends = [element.span[1] for element in dynamics.compiled.chain.rods["rod"].elements]
    if pieces == 1:
        assert ends == [LENGTH]
    else:
        assert set(np.round([0.298, 0.3, 0.302], 9)) <= set(np.round(ends, 9))


def test_low_orders_have_no_more_nodes_than_before():
    assert [default_nodes({"bend_y": p}) for p in range(4)] == [5, 6, 7, 8]
    counts = [default_nodes({"bend_y": p}) for p in range(51)]
    assert counts == sorted(counts) and counts[-1] < 300
