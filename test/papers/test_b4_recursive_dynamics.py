"""B-4: recursive inverse and forward dynamics of chains that mix all kinds of bodies."""

import by_hand
import numpy as np
import pytest
from scenes import ALL, SOFT, scene_of

from soft_sim_ros.core.mechanics.prescribed import prescribed_motion
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene import load_scene

SECTION = {"name": "s", "length": 0.3, "material": "soft",
           "cross_section": {"shape": "circle", "radius": [0.03, 0.02]}}  # fmt: skip
STRAIGHT = SECTION | {"length": 0.25}
MIXED = [
    {"joint": "hip", "kind": "universal", "axes": [[0, 0, 1], [0.2, 1, 0]], "damping": 0.1},
    {"rod": "rod", "strains": ALL, "sections": [SECTION]},
    {"rigid_body": "motor", "mass": 0.4, "inertia": [1e-3, 2e-3, 1.5e-3],
     "com": {"position": [0.02, 0.0, 0.03]}},
    {"joint": "knee", "kind": "revolute", "axis": [0.1, 1, 0.3], "stiffness": 2.0},
    {"flexible_link": "link", "strains": ["torsion", "bend_y", "bend_z"], "modes": 4,
     "sections": [STRAIGHT]},
    {"joint": "slide", "kind": "prismatic", "axis": [1, 0.2, 0]},
    {"rigid_body": "hand", "mass": 0.2, "inertia": [1e-3, 1e-3, 1e-3]},
    {"joint": "ball", "kind": "spherical"},
    {"rod": "tail", "strains": ["bend_y", "bend_z"], "sections": [STRAIGHT]},
]  # fmt: skip


def mixed(*first):
    bodies = [*first, *MIXED]
    return Dynamics(scene_of({
        "name": "mixed", "gravity": [0.7, -1.3, -9.0], "materials": {"soft": SOFT},
        "base": {"position": [0.3, -0.2, 1.1], "rpy": [0.4, -0.7, 1.9]}, "bodies": bodies,
        "actuators": [{"joint_torque": "t", "joint": "knee"}],
        "numerics": {"basis": {"order": 2}},
    }))  # fmt: skip


def state(dynamics, seed):
    """A deformed, moving state; stretch and shear small enough for rods to stay rods."""
    names = dynamics.compiled.coordinate_names
    size = [0.02 if "stretch" in x or "shear" in x else 0.05 if "mode" in x else 0.5 for x in names]
    return np.random.default_rng(seed).normal(size=(3, dynamics.n)) * size


HULL = {"rigid_body": "hull", "mass": 1.0, "inertia": [0.01, 0.02, 0.02]}
FREE = ({"joint": "base", "kind": "free"}, HULL)


@pytest.mark.parametrize("first", [(), FREE], ids=["fixed", "free"])
@pytest.mark.parametrize("seed", range(2))
def test_inverse_of_forward_is_the_identity(first, seed):
    """No force beyond the efforts is needed for the motion that they make, and back."""
    dynamics = mixed(*first)
    q, v, a = state(dynamics, seed)
    efforts = np.array([0.7])
    found = dynamics.forward_dynamics(q, v, efforts)
    scale = np.abs(dynamics.inverse_dynamics(q, v, 0 * found, efforts)).max()
    left = dynamics.inverse_dynamics(q, v, found, efforts)
    np.testing.assert_allclose(left, 0.0, atol=1e-9 * scale)
    # and forward of inverse: the force of a motion, put on the right-hand side, gives the motion
    force = dynamics.inverse_dynamics(q, v, a)
    again = found - dynamics.forward_dynamics(q, v, efforts)
    np.testing.assert_array_equal(again, 0.0)
    mass = dynamics.mass_matrix(q)
    bias = dynamics.inverse_dynamics(q, v, 0 * a)
    np.testing.assert_allclose(mass @ a, force - bias, atol=1e-9 * np.abs(force).max())
    np.testing.assert_allclose(mass @ found, -dynamics.inverse_dynamics(q, v, 0 * a, efforts),
                               atol=1e-9 * scale)  # fmt: skip


@pytest.mark.parametrize("seed", range(2))
def test_driven_hinges_and_free_links_agree_with_the_partitioned_matrix(seed):
    dynamics = mixed()
    q, v, a = state(dynamics, seed)
    names = dynamics.compiled.coordinate_names
    driven = np.array([x.split("/")[0] in ("hip", "knee", "slide", "ball") for x in names])
    motion = prescribed_motion(dynamics, q, v, a, driven)
    mass, bias = dynamics.mass_matrix(q), dynamics.inverse_dynamics(q, v, 0 * a)
    right = -bias[~driven] - mass[np.ix_(~driven, driven)] @ a[driven]
    expected = np.linalg.solve(mass[np.ix_(~driven, ~driven)], right)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(motion.accelerations[~driven], expected, atol=1e-7 * scale)
    np.testing.assert_array_equal(motion.accelerations[driven], a[driven])
    needed = mass[driven] @ motion.accelerations + bias[driven]
    np.testing.assert_allclose(motion.forces[driven], needed, atol=1e-7 * np.abs(needed).max())
    assert np.all(motion.forces[~driven] == 0.0)
    # what the motor of the knee must give is what its hinge bears along its axis, spring apart
    axis = np.array([0.1, 1.0, 0.3]) / np.linalg.norm([0.1, 1.0, 0.3])
    knee = names.index("knee")
    assert motion.reactions["knee"][:3] @ axis == pytest.approx(
        motion.forces[knee] - 2.0 * q[knee], rel=1e-6, abs=1e-6
    )


def test_ends_of_the_choice_are_inverse_and_forward_dynamics():
    dynamics = mixed()
    q, v, a = state(dynamics, 3)
    every = prescribed_motion(dynamics, q, v, a, np.ones(dynamics.n, dtype=bool))
    np.testing.assert_array_equal(every.forces, dynamics.inverse_dynamics(q, v, a))
    none = prescribed_motion(dynamics, q, v, a, np.zeros(dynamics.n, dtype=bool))
    np.testing.assert_array_equal(none.accelerations, dynamics.forward_dynamics(q, v))


def test_the_ground_bears_the_change_of_momentum():
    """Reaction at the first joint: dP/dt − weight of all that moves, P differentiated in time."""
    dynamics = mixed({"joint": "ground", "kind": "fixed"})
    q, v, a = state(dynamics, 5)
    found = dynamics.reactions(q, v, a)["ground"]

    def momentum(t):
        return dynamics.momentum(q + v * t + 0.5 * a * t * t, v + a * t)

    rate = by_hand.rate_of(momentum)
    pose, mass = dynamics.node_poses(q), dynamics.model.inertia[:, 0]
    gravity = dynamics.compiled.scene.gravity
    weight = np.concatenate([np.cross(mass @ pose[:, :3, 3], gravity), mass.sum() * gravity])
    turn, origin = pose[0, :3, :3], pose[0, :3, 3]
    force = turn @ found[3:]
    wrench = np.concatenate([turn @ found[:3] + np.cross(origin, force), force])
    np.testing.assert_allclose(wrench, rate - weight, atol=1e-6 * np.abs(rate).max())


def test_a_long_mixed_chain_needs_no_matrix():
    """Elimination body by body, against the dense mass matrix, at a chain of sixty bodies."""
    bodies = []
    for i in range(15):
        renamed = [dict(body) for body in MIXED[2:7]]
        for body in renamed:
            kind = next(iter(body))
            body[kind] += str(i)
        bodies += renamed
    dynamics = Dynamics(scene_of({
        "name": "long", "gravity": [0, 0, -9.81], "materials": {"soft": SOFT}, "bodies": bodies,
        "numerics": {"step": 0.002},
    }))  # fmt: skip
    q, v, _ = state(dynamics, 1) * 0.3
    found = dynamics.forward_dynamics(q, v)
    bias = dynamics.inverse_dynamics(q, v, 0 * q)
    expected = np.linalg.solve(dynamics.mass_matrix(q), -bias)
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())


def test_scene_of_mixed_bodies_is_packaged():
    dynamics = Dynamics(load_scene("mixed_chain"))
    kinds = {type(body).__name__ for body in dynamics.compiled.scene.bodies}
    assert kinds == {"Joint", "Rod", "RigidBody", "FlexibleLink"}
