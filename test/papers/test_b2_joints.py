"""B-2: every kind of joint, its coordinates, motors and reactions, against Newton and Euler."""

import by_hand
import numpy as np
import pytest
from scenes import scene_of
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.settled import Dynamics, Simulation

CHAIN = {
    "name": "joints",
    "numerics": {"step": 0.002},
    "gravity": [0.7, -1.3, -9.0],
    "base": {"position": [0.3, -0.2, 1.1], "rpy": [0.4, -0.7, 1.9]},
    "bodies": [
        {"joint": "rail", "kind": "prismatic", "axis": [0.2, 1.0, -0.4],
         "offset": {"position": [0.1, 0.0, 0.2], "rpy": [0.3, 0.1, -0.4]}},
        {"rigid_body": "cart", "mass": 1.3, "inertia": [0.01, 0.02, 0.025],
         "com": {"position": [0.05, 0.02, -0.04], "rpy": [0.3, 0.0, 0.5]}},
        {"joint": "wrist", "kind": "universal", "axes": [[0.1, 0.0, 1.0], [0.3, 1.0, 0.0]],
         "offset": {"position": [0.1, 0.2, 0.0]}},
        {"rigid_body": "arm", "mass": 0.7, "inertia": [0.004, 0.003, 0.006],
         "com": {"position": [0.15, -0.06, 0.08], "rpy": [2.3, 0.4, -0.5]}},
        {"joint": "weld", "kind": "fixed", "offset": {"position": [0.3, 0, 0], "rpy": [0, 1, 0]}},
        {"joint": "ball", "kind": "spherical"},
        {"rigid_body": "bob", "mass": 0.4, "inertia": [0.001, 0.002, 0.0015],
         "com": {"position": [0.1, 0.0, 0.1]}},
    ],
    "actuators": [
        {"joint_force": "drive", "joint": "rail"},
        {"joint_torque": "yaw", "joint": "wrist", "axis": "first"},
        {"joint_torque": "pitch", "joint": "wrist", "axis": "second"},
    ],
}  # fmt: skip
FLOATING = CHAIN | {
    "bodies": [{"joint": "base", "kind": "free"}, *CHAIN["bodies"][1:]],
    "actuators": CHAIN["actuators"][1:],
}


def state(dynamics, seed):
    return np.random.default_rng(seed).normal(size=(3, dynamics.n))


@pytest.mark.parametrize("document", [CHAIN, FLOATING], ids=["fixed", "free"])
@pytest.mark.parametrize("seed", range(3))
def test_joints_bear_what_newton_and_euler_ask_for(document, seed):
    """Reactions (3.21) of all joints of any kind for any motion, motors and springs apart."""
    dynamics = Dynamics(scene_of(document))
    q, v, a = state(dynamics, seed)
    found, expected = dynamics.reactions(q, v, a), by_hand.reactions(document, q, v, a)
    assert found.keys() == expected.keys()
    for name, wrench in expected.items():
        np.testing.assert_allclose(found[name], wrench, atol=1e-7, err_msg=name)


def test_efforts_are_the_reactions_along_the_free_axes():
    """r = 0 says no more than: what a joint lets go, nobody holds but motor, spring and damper."""
    document = CHAIN | {"bodies": [dict(body) for body in CHAIN["bodies"]]}
    document["bodies"][0] |= {"stiffness": 30.0, "damping": 2.0}
    document["bodies"][2] |= {"stiffness": 3.0, "damping": 0.2}
    dynamics = Dynamics(scene_of(document))
    q, v, _ = state(dynamics, 4)
    efforts = np.array([2.0, 0.3, -0.5])
    a = dynamics.forward_dynamics(q, v, efforts)
    reactions = by_hand.reactions(document, q, v, a)
    rail = np.array(CHAIN["bodies"][0]["axis"]) / np.linalg.norm(CHAIN["bodies"][0]["axis"])
    assert reactions["rail"][3:] @ rail == pytest.approx(2.0 - 30.0 * q[0] - 2.0 * v[0], abs=1e-7)
    yaw, pitch = (np.array(x) / np.linalg.norm(x) for x in CHAIN["bodies"][2]["axes"])
    # the first axis turned back by the second angle, into the frame after the joint
    yaw = Rotation.from_rotvec(-q[2] * pitch).apply(yaw)
    assert reactions["wrist"][:3] @ yaw == pytest.approx(0.3 - 3 * q[1] - 0.2 * v[1], abs=1e-7)
    assert reactions["wrist"][:3] @ pitch == pytest.approx(-0.5 - 3 * q[2] - 0.2 * v[2], abs=1e-7)
    np.testing.assert_allclose(reactions["ball"][:3], 0.0, atol=1e-7)


@pytest.mark.parametrize("document", [CHAIN, FLOATING], ids=["fixed", "free"])
def test_tangents_of_joints_are_derivatives(document):
    dynamics = Dynamics(scene_of(document))
    motion = state(dynamics, 7)
    for i, found in enumerate(dynamics.tangents(*motion)):
        for j in range(dynamics.n):

            def shifted(size, i=i, j=j):
                moved = [x.copy() for x in motion]
                moved[i][j] += size
                return dynamics.inverse_dynamics(*moved)

            np.testing.assert_allclose(found[:, j], by_hand.rate_of(shifted), atol=1e-7, rtol=1e-7)


def test_initial_velocities_of_balls_and_free_bases_are_twists():
    """Given: position and rotation vector; twist in the frame after the joint, angular first."""
    initial = {
        "positions": {"base": [0.5, -0.8, 1.1, 0.3, 0.2, -0.4], "ball": [1.0, 2.0, -0.5]},
        "velocities": {"base": [0.3, -0.2, 0.7, 1.0, -2.0, 0.5], "ball": [0.4, 0.1, -0.6]},
    }
    simulation = Simulation(scene_of(FLOATING | {"initial": initial}))
    dynamics, chain = simulation.dynamics, simulation.compiled.chain
    twists = dynamics.node_twists(simulation.q, simulation.v)
    np.testing.assert_allclose(twists[chain.frames["base"]], initial["velocities"]["base"])
    pose = se3.inverse(simulation.compiled.base) @ dynamics.node_poses(simulation.q)
    shift = pose[chain.frames["base"]][:3, 3]
    np.testing.assert_allclose(shift, [0.3, 0.2, -0.4], atol=1e-14)
    ball, before = (twists[chain.frames["ball"] - i] for i in (0, 1))
    turn = Rotation.from_rotvec(initial["positions"]["ball"]).as_matrix()
    np.testing.assert_allclose(ball[:3] - turn.T @ before[:3], initial["velocities"]["ball"])


def pendulum(t, y):
    """A ball on a rod of length 1 that does not spin about it: r̈ = g′ − λ r, λ from |r| = 1.

    With its inertia J it falls like a point mass in g′ = g m/(m + J).
    """
    r, u = y[:3], y[3:]
    g = np.array([0.0, 0.0, -9.0]) * 2.0 / 2.05
    return np.concatenate([u, g - (u @ u + g @ r) * r])


def test_spherical_pendulum_swings_over_the_top_as_in_absolute_coordinates():
    """Twice over the top, through changes of chart: position, energy, angular momentum."""
    document = {
        "name": "pendulum",
        "gravity": [0, 0, -9.0],
        "bodies": [
            {"joint": "ball", "kind": "spherical"},
            {"rigid_body": "bob", "mass": 2.0, "inertia": [0.05] * 3,
             "com": {"position": [1.0, 0.0, 0.0]}},
        ],
        "initial": {"velocities": {"ball": [0.0, 7.5, 0.6]}},
        "numerics": {"step": 0.002, "integrator": "sdirk4"},
    }  # fmt: skip
    simulation = Simulation(scene_of(document))
    start = [1.0, 0.0, 0.0, 0.0, 0.6, -7.5]
    exact = solve_ivp(pendulum, (0, 2), start, rtol=1e-11, atol=1e-11, t_eval=np.linspace(0, 2, 21))
    longest, changes = 0.0, 0
    for r in exact.y[:3].T[1:]:
        for _ in range(50):
            before = simulation.q.copy()
            simulation.advance(1)
            longest = max(longest, np.linalg.norm(simulation.q))
            changes += np.linalg.norm(simulation.q - before) > 3.0
        # the mass is at the centre, one offset beyond the joint's frame
        at = simulation.dynamics.node_poses(simulation.q)[-2][:3, 3]
        np.testing.assert_allclose(at, r, atol=2e-6)
    assert changes > 1 and longest < 4.0 * np.pi / 3 + 0.1
    spin = simulation.dynamics.momentum(simulation.q, simulation.v)[2]
    assert spin == pytest.approx(2.05 * 0.6, abs=1e-6)


def test_heavy_top_precesses_steadily_where_theory_says():
    """A Ω² cos θ − C ω₃ Ω + m g l = 0: a top at constant tilt, one turn of it and ten of spin."""
    m, g, arm, c, a = 0.8, 9.81, 0.1, 0.006, 0.004 + 0.8 * 0.1**2
    tilt, precession = 0.7, 3.0
    total = (a * precession**2 * np.cos(tilt) + m * g * arm) / (c * precession)  # ω₃
    along = np.array([np.cos(tilt), 0.0, np.sin(tilt)])  # world z in the frame of the top at t = 0
    spin = total - precession * np.cos(tilt)
    velocity = precession * along + spin * np.array([1.0, 0.0, 0.0])
    document = {
        "name": "top",
        "gravity": [0, 0, -g],
        "bodies": [
            {"joint": "foot", "kind": "spherical"},
            {"rigid_body": "disc", "mass": m, "inertia": [c, 0.004, 0.004],
             "com": {"position": [arm, 0.0, 0.0]}},
        ],
        "initial": {"positions": {"foot": [0.0, tilt - np.pi / 2, 0.0]},
                    "velocities": {"foot": velocity}},
        "numerics": {"step": 0.001, "integrator": "sdirk4"},
    }  # fmt: skip
    simulation = Simulation(scene_of(document))
    dynamics, foot = simulation.dynamics, simulation.compiled.chain.frames["foot"]
    for k in range(1, 11):
        simulation.advance(200)
        axis = dynamics.node_poses(simulation.q)[foot][:3, 0]
        azimuth = precession * 0.2 * k
        expected = [np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)]
        np.testing.assert_allclose(axis, expected, atol=3e-6)
    assert spin > 30.0
    twist = dynamics.node_twists(simulation.q, simulation.v)[foot]
    assert twist[0] == pytest.approx(total, rel=1e-7)


def test_double_pendulum_follows_lagrange():
    """Two point masses on rods: the textbook equations, integrated by scipy."""
    m1, m2, l1, l2, g = 1.0, 0.6, 0.8, 0.5, 9.81

    def rates(t, y):
        a, b, u, w = y
        matrix = [[(m1 + m2) * l1, m2 * l2 * np.cos(a - b)], [l1 * np.cos(a - b), l2]]
        right = [
            -m2 * l2 * w**2 * np.sin(a - b) - (m1 + m2) * g * np.sin(a),
            l1 * u**2 * np.sin(a - b) - g * np.sin(b),
        ]
        return [u, w, *np.linalg.solve(matrix, right)]

    document = {
        "name": "double",
        "gravity": [0, 0, -g],
        "base": {"rpy": [0, np.pi / 2, 0]},  # x down; turning about −y takes the bob towards +x
        "bodies": [
            {"joint": "one", "kind": "revolute", "axis": [0, -1, 0]},
            {"rigid_body": "m1", "mass": m1, "com": {"position": [l1, 0, 0]}},
            {"joint": "two", "kind": "revolute", "axis": [0, -1, 0],
             "offset": {"position": [l1, 0, 0]}},
            {"rigid_body": "m2", "mass": m2, "com": {"position": [l2, 0, 0]}},
        ],
        "initial": {"positions": {"one": 2.0, "two": 0.5}},
        "numerics": {"step": 0.002, "integrator": "sdirk4"},
    }  # fmt: skip
    simulation = Simulation(scene_of(document))
    simulation.advance(1000)
    exact = solve_ivp(rates, (0, 2), [2.0, 2.5, 0.0, 0.0], rtol=1e-11, atol=1e-11).y[:, -1]
    np.testing.assert_allclose(simulation.q, [exact[0], exact[1] - exact[0]], atol=3e-6)
    np.testing.assert_allclose(simulation.v, [exact[2], exact[3] - exact[2]], atol=3e-5)


def test_motion_does_not_depend_on_how_steps_are_grouped_through_changes_of_chart():
    initial = {"velocities": {"base": [9.0, 4.0, -3.0, 0.2, 0.1, 0.0], "ball": [3.0, 20.0, 1.0]}}
    document = FLOATING | {"initial": initial, "numerics": {"step": 0.002}}
    one, many = (Simulation(scene_of(document)) for _ in range(2))
    one.advance(600)
    for _ in range(60):
        many.advance(10)
    assert one.q.tobytes() == many.q.tobytes() and one.v.tobytes() == many.v.tobytes()
    assert abs(one.ledger()[-1]) < 0.02 * one.ledger()[0]
