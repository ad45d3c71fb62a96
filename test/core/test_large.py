"""Arms of many coordinates: the same answers at a cost linear in them, and no less judged."""

import warnings

import numpy as np
import pytest
from cosserat_bvp import solve_rod
from forests import tree_document
from scenes import random_state, rod_document, scene_of, zoo_document

from soft_sim_ros.core.analysis.large import growing_of, slow_motions, symmetric_blocks, unit_blocks
from soft_sim_ros.core.analysis.small_motion import is_symmetric, leaving, small_motions, unit_scale
from soft_sim_ros.core.analysis.stability import verdict
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics.blocks import FROM, Blocks
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.errors import StaticsFailed

E, LENGTH, RADIUS = 1e6, 0.6, 0.01
STIFF = E * np.pi * RADIUS**4 / 4


def winch_document():
    """Return a rod whose winch ties all of its elements together."""
    document = rod_document(order=1, elements=3)
    winch = {"tendon": "winch", "rod": "rod", "offset": [0.0, 0.02], "control": "length",
             "axial_stiffness": 1e3}  # fmt: skip
    return document | {"actuators": [winch]}


def state_of(document, seed=3):
    dynamics = Dynamics(scene_of(document))
    q, v, a = random_state(dynamics, seed)
    dynamics.residual(q, v, a, dynamics.forcing())
    return dynamics


@pytest.mark.parametrize("document", [zoo_document(), tree_document(), winch_document()])
def test_blocks_are_the_dense_matrix_whatever_does_not_move(document):
    dynamics, alpha = state_of(document), (1.0, 0.3, 0.2)
    matrix = dynamics.last_tangent(alpha)
    mask = np.ones(dynamics.n, dtype=bool)
    mask[1::5] = False
    own, x = np.ix_(mask, mask), np.cos(np.arange(dynamics.n)) / dynamics.model.weight
    blocks = Blocks(dynamics, mask)
    blocks.fill(alpha)
    np.testing.assert_array_equal(blocks.diagonal, np.diag(matrix))
    found, expected = blocks.times(x), matrix[own] @ x[mask]
    np.testing.assert_allclose(found[mask], expected, atol=1e-13 * np.abs(expected).max())
    assert not found[~mask].any()
    assert blocks.factor()
    solved = blocks.solve(found)
    np.testing.assert_allclose((solved * dynamics.model.weight)[mask],
                               (x * dynamics.model.weight)[mask], rtol=1e-7, atol=1e-8)  # fmt: skip
    assert not solved[~mask].any()


@pytest.mark.parametrize("seed", range(4))
def test_the_law_of_inertia_counts_what_eigenvalues_count(seed):
    """Of a forest without forces that follow, pushed until many directions leave."""
    document = tree_document()
    document["loads"] = [
        {"point": "push", "body": "finger", "force": [-3.0 * 10.0**seed, 1.0, 2.0]}
    ]
    document.pop("actuators", None)
    dynamics = state_of(document, seed)
    zero = np.zeros(dynamics.n)
    dynamics.residual(random_state(dynamics, seed)[0], zero, zero, dynamics.forcing())
    stiffness = dynamics.last_tangent((1.0, 0.0, 0.0))
    weight = dynamics.model.weight
    scale = unit_scale(stiffness, dynamics.law_at_rest, weight)
    scaled = stiffness / np.outer(scale, scale)
    assert is_symmetric(scaled)
    blocks = Blocks(dynamics, np.ones(dynamics.n, dtype=bool))
    blocks.fill((1.0, 0.0, 0.0))
    found = unit_blocks(dynamics, blocks)
    np.testing.assert_allclose(found, scale, rtol=1e-12)
    assert symmetric_blocks(blocks, found)
    assert blocks.factor()
    assert blocks.negative(found) == leaving(scaled)
    assert (leaving(scaled) > 0) == (seed > 0)


def long_rod(coordinates, *, strains=None, damping=0.0, **options):
    """Return a slender rod of at least so many coordinates."""
    elements = -(-coordinates // (4 * (6 if strains is None else len(strains))))
    material = {"rayleigh": {"mass": damping}} if damping else {}
    return Dynamics(
        scene_of(
            rod_document(
                length=LENGTH, radius=RADIUS, order=3, elements=elements, material=material,
                strains=strains, **options,
            )
        )
    )  # fmt: skip


@pytest.fixture(scope="module")
def column():
    return long_rod(1600, strains=["bend_y", "bend_z"])


@pytest.mark.parametrize("crossed", [0, 1, 2, 5])
def test_every_load_of_euler_costs_a_long_column_two_directions(column, crossed):
    """Between P = (k − ½)² π² EI/L² and the next, k in each plane; at any number of coordinates."""
    assert column.n >= 1600
    load = np.zeros(6)
    load[3] = -((crossed * np.pi) ** 2 + 0.1) * STIFF / LENGTH**2
    zero = np.zeros(column.n)
    column.residual(zero, zero, zero, column.forcing(tip=load))
    assert verdict(column).unstable == 2 * crossed


def test_a_long_column_beyond_eulers_load_is_not_called_straight(column):
    load = np.zeros(6)
    load[3] = -1.2 * 0.25 * np.pi**2 * STIFF / LENGTH**2
    with pytest.raises(StaticsFailed, match="it loses stability there") as failure:
        equilibrium(column, tip=load, thorough=False)
    assert 1.2 * failure.value.load_factor == pytest.approx(1.0, rel=1e-4)


def test_a_long_rod_hangs_as_the_cosserat_equations_say():
    gravity = np.array([0.0, 2.0, -9.81])
    dynamics = long_rod(FROM + 50, gravity=gravity, section={"shear_correction": 1.0})
    area = np.pi * RADIUS**2
    inertia = area * RADIUS**2 / 4
    law = [E / 3 * 2 * inertia, E * inertia, E * inertia, E * area, E / 3 * area, E / 3 * area]
    tip, turn = solve_rod(
        LENGTH, law, lambda s: np.array([0, 0, 0, 1.0, 0, 0]), density_force=1000 * area * gravity
    )
    pose = dynamics.node_poses(equilibrium(dynamics))[-1]
    np.testing.assert_allclose(pose[:3, 3], tip, atol=1e-7 * LENGTH)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=1e-6)


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_the_slowest_motions_of_a_long_rod_under_a_load_that_follows_are_the_dense_ones(damping):
    """At 1.3 times Beck's load, P = 20.05 EI/L², where two of them have met."""
    dynamics = long_rod(120, damping=damping)
    load, zero = np.zeros(6), np.zeros(dynamics.n)
    load[3] = -26.0 * STIFF / LENGTH**2
    dynamics.residual(zero, zero, zero, dynamics.forcing(tip=load, tip_follows=True))
    mask = np.ones(dynamics.n, dtype=bool)
    stiffness, damped, mass = (dynamics.last_tangent(tuple(row)) for row in np.eye(3))
    scale = unit_scale(stiffness, dynamics.law_at_rest, dynamics.model.weight)
    dense = small_motions(stiffness, damped, mass, scale)
    found = slow_motions(dynamics, mask, scale)
    off = [np.abs(dense.values - s).min() / np.abs(s) for s in found]
    assert max(off) < 1e-9
    assert np.abs(found).max() == pytest.approx(np.sort(np.abs(dense.values))[len(found) - 1])
    assert len(growing_of(found)) == np.count_nonzero(dense.growing) == 4


def test_a_long_column_flutters_at_becks_load():
    dynamics = long_rod(FROM + 50, damping=1e-2, strains=["bend_z", "stretch", "shear_y"])
    tip = np.array([0, 0, 0, -22.0 * STIFF / LENGTH**2, 0, 0])
    with pytest.raises(StaticsFailed, match="it flutters, a swing of") as failure:
        equilibrium(dynamics, tip=tip, tip_follows=True, thorough=False)
    assert 22.0 * failure.value.load_factor == pytest.approx(20.05, rel=1e-2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        equilibrium(dynamics, tip=0.85 * tip, tip_follows=True, thorough=False)
