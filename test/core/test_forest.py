"""A forest of bodies obeys the same equations as a chain, whatever hangs where."""

import copy

import numpy as np
import pytest
from differences import central_difference
from forests import EFFORTS, forest_document, place, rod, tree, tree_document
from scenes import random_state, scene_of

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.analysis.inverse_kinematics import inverse_kinematics
from soft_sim_ros.core.analysis.linearisation import linearise
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.compile.scene import compile_scene
from soft_sim_ros.core.mechanics import spatial
from soft_sim_ros.core.recursion.elimination import dense, factor, solve
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.settled import Dynamics, Simulation


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("which", [0, 1, 2])
def test_the_tangent_of_a_forest_is_its_difference_quotient(seed, which):
    dynamics = tree()
    state = list(random_state(dynamics, seed))
    exact = dynamics.tangents(*state, efforts=EFFORTS)[which]

    def residual(x):
        moved = [*state]
        moved[which] = x
        return dynamics.inverse_dynamics(*moved, efforts=EFFORTS)

    size = np.full(dynamics.n, 1e-4) / np.maximum(dynamics.model.weight, 1e-3)
    quotient = central_difference(residual, state[which], size)
    scale = np.sqrt(np.outer(*2 * [np.abs(np.diag(exact)) + 1e-12]))
    assert np.max(np.abs(exact - quotient) / (scale + np.abs(exact))) < 2e-6


@pytest.mark.parametrize("seed", range(3))
def test_the_spatial_formulation_finds_the_same_forces_in_a_forest(seed):
    dynamics = Dynamics(scene_of(tree_document(materials=MATERIAL)))
    q, v, a = random_state(dynamics, seed)
    one = dynamics.inverse_dynamics(q, v, a, EFFORTS)
    other = spatial.inverse_dynamics(dynamics, q, v, a, EFFORTS)
    np.testing.assert_allclose(one, other, atol=1e-11 * np.abs(one).max())


MATERIAL = {"soft": {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1000.0}}


def test_elimination_solves_the_whole_matrix_of_a_forest():
    dynamics = tree()
    q, v, a = random_state(dynamics, 4)
    dynamics.residual(q, v, a, dynamics.forcing(EFFORTS))
    system, matrix = dynamics._system, np.zeros((dynamics.n, dynamics.n))
    tangent(dynamics.model, dynamics._data, (1.0, 30.0, 900.0), system)
    dense(dynamics.model, system, matrix)
    assert factor(dynamics.model, system)
    right = np.random.default_rng(1).normal(size=dynamics.n)
    x = right.copy()
    solve(dynamics.model, system, x)
    expected = np.linalg.solve(matrix, right)
    np.testing.assert_allclose(x, expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())


def test_bodies_of_different_branches_do_not_feel_each_other():
    dynamics = tree()
    q, _, _ = random_state(dynamics, 5)
    mass = dynamics.mass_matrix(q)
    names = dynamics.compiled.coordinate_names
    alone = [i for i, name in enumerate(names) if name.startswith("second/")]
    others = [i for i in range(len(names)) if i not in alone]
    assert len(alone) > 6
    assert not mass[np.ix_(alone, others)].any()
    thumb = [i for i, name in enumerate(names) if name.startswith("thumb/")]
    stem = [i for i, name in enumerate(names) if name.startswith("stem/")]
    assert not mass[np.ix_(thumb, stem)].any()
    assert mass[np.ix_(thumb, [names.index("swing")])].all()


CHAIN = [
    {"joint": "swing", "kind": "revolute", "axis": [0, 1, 0], "stiffness": 2.0},
    rod("one", 0.2),
    {"rigid_body": "ring", "mass": 0.1, "com": {"position": [0.01, 0, 0.02]}},
    rod("two", 0.3),
]


@pytest.mark.parametrize("order", [[0, 1, 2, 3], [3, 2, 1, 0], [2, 0, 3, 1]])
def test_a_forest_that_is_a_chain_has_its_bits_however_it_is_written(order):
    chain = compile_scene(scene_of(forest_document(CHAIN)))
    bodies = copy.deepcopy(CHAIN)
    for body, parent in zip(bodies, ["base", "swing", "one", "ring"], strict=True):
        body["parent"] = parent
    other = compile_scene(scene_of(forest_document([bodies[i] for i in order])))
    assert chain.coordinate_names == other.coordinate_names
    for one, two in zip(flat(chain.model), flat(other.model), strict=True):
        np.testing.assert_array_equal(one, two)


def flat(part):
    if isinstance(part, tuple):
        return [array for inner in part for array in flat(inner)]
    return [part]


def test_two_arms_move_as_each_does_alone():
    """Also where they stand elsewhere and otherwise, with other numbers of coordinates."""
    far = {"position": [0.3, -0.5, 0.2], "rpy": [0.5, 1.0, -0.3]}
    one, two = rod("one", 0.3), rod("two", 0.45)
    both = Simulation(scene_of(forest_document([one, two | {"parent": place("base", **far)}])))
    alone = [
        Simulation(scene_of(forest_document([one]))),
        Simulation(scene_of(forest_document([two], base=far))),
    ]
    for simulation in [both, *alone]:
        simulation.advance(300)
    first = alone[0].n_coordinates
    moved = [np.abs(s.q).max() for s in alone]
    assert min(moved) > 0.1
    np.testing.assert_allclose(both.q[:first], alone[0].q, atol=1e-7 * moved[0])
    np.testing.assert_allclose(both.q[first:], alone[1].q, atol=1e-7 * moved[1])


def test_a_ring_along_a_rod_is_a_load_along_it():
    """At rest a heavy ring at s bends a rod as its weight there does."""
    s, mass, g = 0.21, 0.2, np.array([1.0, -2.0, -9.0])
    ring = {"rigid_body": "ring", "mass": mass, "parent": place("rod", s)}
    weight = {"point": "w", "body": "rod", "s": s, "force": (mass * g).tolist()}
    with_ring = Dynamics(scene_of(forest_document([rod("rod", 0.4), ring])))
    loaded = Dynamics(scene_of(forest_document([rod("rod", 0.4)], loads=[weight])))
    one, two = equilibrium(with_ring), equilibrium(loaded)
    tips = [
        d.node_poses(q)[d.compiled.chain.ends["rod"], :3, 3]
        for d, q in ((with_ring, one), (loaded, two))
    ]
    np.testing.assert_allclose(tips[0], tips[1], atol=1e-9)
    assert np.linalg.norm(tips[0] - [0.4, 0, 0]) > 0.05


def test_what_the_ground_bears_is_the_sum_of_what_branches_hand_on():
    """The internal wrench after the base, of branches that begin there, is that of all of them."""
    dynamics = tree()
    q, v, a = random_state(dynamics, 9)
    wrench = dynamics.internal_wrench(q, v, a)
    first = np.flatnonzero(dynamics.model.tree.node == 0)
    assert len(first) == 2
    poses = dynamics.node_poses(q)
    handed = np.zeros(6)
    for k in first:
        relative = se3.inverse(poses[0]) @ poses[k + 1]
        handed += se3.Ad(se3.inverse(relative)).T @ wrench.before[k + 1]
    np.testing.assert_allclose(wrench.after[0], handed, atol=1e-9 * np.abs(handed).max())


def free_tree(**rest):
    """A body with a rod to each side and a rod on a rod, which nothing holds."""
    spin = {"velocities": {"floating": [0.5, -2.0, 1.0, 0.3, 0.2, -0.1]}}
    bodies = [
        {"joint": "floating", "kind": "free"},
        {"rigid_body": "hub", "mass": 0.3, "inertia": [4e-4, 5e-4, 6e-4]},
        rod("ahead", 0.3),
        rod("behind", 0.25, place("hub", position=[-0.02, 0, 0], rpy=[0.3, 0.2, 3.0])),
        rod("aside", 0.15, place("ahead", 0.2, rpy=[0, 0, 1.3])),
    ]
    return forest_document(
        bodies, materials=MATERIAL, gravity=[0.0, 0.0, 0.0], initial=spin, **rest
    )


def test_momentum_of_a_free_tree_is_kept():
    simulation = Simulation(scene_of(free_tree()))
    dynamics = simulation.dynamics
    before = dynamics.momentum(simulation.q, simulation.v)
    start = simulation.q.copy()
    simulation.advance(300)
    after = dynamics.momentum(simulation.q, simulation.v)
    assert np.abs(simulation.q - start).max() > 0.1
    size = np.concatenate([np.full(3, np.linalg.norm(before[:3])), np.full(3, 0.1)])
    assert np.abs((after - before) / size).max() < 1e-10


def test_each_of_two_free_bodies_keeps_its_own_momentum_while_a_third_is_pushed():
    """One free tree beside a loaded arm, and a ball that falls."""
    document = free_tree()
    document["gravity"] = [0.0, 0.0, -3.0]
    document["bodies"] += [
        {"joint": "falls", "kind": "free", "parent": "base", "offset": {"position": [0, 1, 0]}},
        {"rigid_body": "ball", "mass": 0.2, "inertia": [1e-4, 2e-4, 3e-4]},
        rod("arm", 0.3, place("base", position=[0, -1, 0])),
    ]
    document["initial"]["velocities"]["falls"] = [3.0, 2.0, 9.0, 0.0, 0.1, 0.0]
    document["loads"] = [{"point": "push", "body": "arm", "force": [0, 0.2, 0]}]
    simulation = Simulation(scene_of(document))
    dynamics = simulation.dynamics
    steps = 200
    time = steps * 1e-3
    columns = simulation.compiled.chain.joints["falls"]
    before = own_momentum(dynamics, simulation, columns)
    simulation.advance(steps)
    after = own_momentum(dynamics, simulation, columns)
    fallen = simulation.q[columns[5]] + 0.5 * 3.0 * time**2
    assert abs(fallen) < 1e-12
    np.testing.assert_allclose(after[:3], before[:3], atol=1e-12)
    np.testing.assert_allclose(after[3:], before[3:] + np.array([0, 0, -0.6 * time]), atol=1e-12)


def own_momentum(dynamics, simulation, columns):
    """Angular momentum about its centre, and momentum, of the ball alone (6,) in the world."""
    node = dynamics.compiled.chain.ends["ball"]
    pose = dynamics.node_poses(simulation.q)[node]
    twist = dynamics.node_twists(simulation.q, simulation.v)[node]
    spin = pose[:3, :3] @ (np.array([1e-4, 2e-4, 3e-4]) * twist[:3])
    return np.concatenate([spin, 0.2 * pose[:3, :3] @ twist[3:]])


def test_inverse_kinematics_holds_any_frame():
    """Of two tendon fingers on one palm, each is led to where it was seen before."""
    tendons = [
        {"tendon": f"{finger}{i}", "rod": finger, "offset": offset, "limits": [0, 40]}
        for finger in ("one", "two")
        for i, offset in enumerate([[0.01, 0.0], [0.0, 0.01]])
    ]
    bodies = [
        {"rigid_body": "palm", "mass": 0.3},
        rod("one", 0.2, place("palm", position=[0, 0.05, 0])),
        rod("two", 0.25, place("palm", position=[0, -0.05, 0])),
    ]
    dynamics = Dynamics(scene_of(forest_document(bodies, actuators=tendons)))
    for finger, efforts in (("one", [12.0, 5.0, 0.0, 0.0]), ("two", [0.0, 0.0, 8.0, 15.0])):
        q = equilibrium(dynamics, efforts=np.array(efforts))
        seen = dynamics.node_poses(q)[dynamics.compiled.node_of(finger), :3, 3]
        found = inverse_kinematics(dynamics, seen, frame=finger, check=False)
        np.testing.assert_allclose(found.pose[:3, 3], seen, atol=1e-8)
        np.testing.assert_allclose(found.efforts, efforts, atol=1e-4)


def test_linearisation_of_a_frame_is_its_small_motion():
    dynamics = tree()
    q = equilibrium(dynamics, efforts=np.array(EFFORTS), check=False)
    system = linearise(dynamics, q, np.array(EFFORTS), frame="finger")
    node = dynamics.compiled.node_of("finger")
    size = 1e-6 / dynamics.model.weight
    slope = central_difference(lambda x: dynamics.node_poses(x)[node, :3, 3], q, size)
    assert system.outputs[:3] == ("finger_x", "finger_y", "finger_z")
    np.testing.assert_allclose(system.C[:3, : dynamics.n], slope, atol=1e-6 * np.abs(slope).max())
