"""Rigid chains against Newton and Euler in absolute coordinates, with explicit joint reactions."""

import numpy as np
import pytest
from scenes import SOFT, scene_of
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.settled import Simulation

GRAVITY = np.array([0.7, -1.3, -9.0])
BASE = {"position": [0.3, -0.2, 1.1], "rpy": [0.4, -0.7, 1.9]}
JOINTS = [
    {"joint": "hip", "kind": "revolute", "axis": [0.3, 0.5, -0.8], "stiffness": 1.4,
     "damping": 0.05, "offset": {"position": [0.1, 0.02, 0.03], "rpy": [0.1, 0.2, 0.3]}},
    {"joint": "knee", "kind": "revolute", "axis": [-0.2, 1.0, 0.4],
     "offset": {"position": [0.4, -0.1, 0.05], "rpy": [-1.0, 0.4, 2.0]}},
]  # fmt: skip
BODIES = [
    {"rigid_body": "thigh", "mass": 1.3, "inertia": [0.01, 0.02, 0.025],
     "com": {"position": [0.21, 0.05, -0.04], "rpy": [0.3, 0.0, 0.5]}},
    {"rigid_body": "shank", "mass": 0.7, "inertia": [0.004, 0.003, 0.006],
     "com": {"position": [0.15, -0.06, 0.08], "rpy": [2.3, 0.4, -0.5]}},
]  # fmt: skip
TORQUES = np.array([0.8, -0.6])
DEAD = np.array([0.3, -1.0, 0.5])  # N, along world axes, at the knee
FOLLOWER = np.array([0.2, -0.1, 0.15])  # N·m, in the frame of the shank


def document():
    return {
        "name": "rigid",
        "gravity": GRAVITY.tolist(),
        "base": BASE,
        "materials": {"unused": SOFT},
        "bodies": [JOINTS[0], BODIES[0], JOINTS[1], BODIES[1]],
        "actuators": [
            {"joint_torque": "hip_torque", "joint": "hip"},
            {"joint_torque": "knee_torque", "joint": "knee"},
        ],
        "loads": [
            {"point": "push", "body": "knee", "force": DEAD.tolist()},
            {"point": "turn", "body": "shank", "moment": FOLLOWER.tolist(), "frame": "body"},
        ],
        "initial": {"positions": {"hip": 0.4, "knee": -0.9}, "velocities": {"hip": 1.5}},
        "numerics": {"step": 0.002, "integrator": "sdirk4", "newton_tolerance": 1e-12},
    }


def pose(entry):
    """Return rotation matrix and position of a pose entry."""
    turn = Rotation.from_euler("xyz", entry.get("rpy", [0, 0, 0])).as_matrix()
    return turn, np.array(entry.get("position", [0.0, 0.0, 0.0]))


def absolute_accelerations(q, v):
    """Return q̈ (2,) from 24 equations: Newton and Euler of both bodies, both joints closed.

    Unknown: acceleration of both centres, angular accelerations, joint forces and moments.
    """
    frame, origin = pose(BASE)
    spin = np.zeros(3)
    hinges, axes, turns, centres, inertias, spins = [], [], [], [], [], []
    for i in range(2):
        turn, shift = pose(JOINTS[i]["offset"])
        origin, frame = origin + frame @ shift, frame @ turn
        axis = np.array(JOINTS[i]["axis"]) / np.linalg.norm(JOINTS[i]["axis"])
        hinges.append(origin)
        axes.append(frame @ axis)
        frame = frame @ Rotation.from_rotvec(q[i] * axis).as_matrix()
        spin = spin + v[i] * axes[i]
        spins.append(spin)
        turns.append(frame)
        to_com, com = pose(BODIES[i]["com"])
        centres.append(origin + frame @ com)
        principal = frame @ to_com
        inertias.append(principal @ np.diag(BODIES[i]["inertia"]) @ principal.T)
    m = [body["mass"] for body in BODIES]
    torque = TORQUES - [JOINTS[0]["stiffness"] * q[0] + JOINTS[0]["damping"] * v[0], 0.0]

    def cross(a):
        return np.cross(np.eye(3), a)  # matrix of a ×

    # x = a1 (0:3), α1 (3:6), a2, α2, F1 (12:15), T1, F2 (18:21), T2
    # F, T: from the body before on the body at its hinge, without the axial torque
    A, b = np.zeros((24, 24)), np.zeros(24)
    for i in range(2):
        own, row = 6 * i, 12 * i
        r = hinges[i] - centres[i]
        A[row : row + 3, own : own + 3] = m[i] * np.eye(3)
        A[row : row + 3, 12 + own : 15 + own] = -np.eye(3)
        b[row : row + 3] = m[i] * GRAVITY
        A[row + 3 : row + 6, own + 3 : own + 6] = inertias[i]
        A[row + 3 : row + 6, 12 + own : 15 + own] = -cross(r)
        A[row + 3 : row + 6, 15 + own : 18 + own] = -np.eye(3)
        b[row + 3 : row + 6] = torque[i] * axes[i] - np.cross(spins[i], inertias[i] @ spins[i])
    r = hinges[1] - centres[0]  # reactions of the knee, with its torque, on the thigh
    A[0:3, 18:21] = np.eye(3)
    A[3:6, 18:21], A[3:6, 21:24] = cross(r), np.eye(3)
    b[3:6] -= torque[1] * axes[1]
    b[12:15] += DEAD  # at the hinge of the knee, on the shank
    b[15:18] += np.cross(hinges[1] - centres[1], DEAD) + turns[1] @ FOLLOWER
    # joint 1: the hinge rests; joint 2: both bodies move alike there
    A[6:9, 0:3], A[6:9, 3:6] = np.eye(3), -cross(hinges[0] - centres[0])
    b[6:9] = -np.cross(spins[0], np.cross(spins[0], hinges[0] - centres[0]))
    A[18:21, 6:9], A[18:21, 9:12] = np.eye(3), -cross(hinges[1] - centres[1])
    A[18:21, 0:3], A[18:21, 3:6] = -np.eye(3), cross(hinges[1] - centres[0])
    b[18:21] = np.cross(spins[0], np.cross(spins[0], hinges[1] - centres[0])) - np.cross(
        spins[1], np.cross(spins[1], hinges[1] - centres[1])
    )
    # relative angular acceleration is along the axis (2 equations), no free moment along it (1)
    for i in range(2):
        row = 9 + 12 * i
        across = np.linalg.svd(axes[i][None])[2][1:]
        A[row : row + 2, 6 * i + 3 : 6 * i + 6] = across
        if i == 1:
            A[row : row + 2, 3:6] = -across
            b[row : row + 2] = across @ np.cross(spins[0], v[1] * axes[1])
        A[row + 2, 15 + 6 * i : 18 + 6 * i] = axes[i]
    x = np.linalg.solve(A, b)
    first = axes[0] @ x[3:6]
    return np.array([first, axes[1] @ (x[9:12] - x[3:6] - np.cross(spins[0], v[1] * axes[1]))])


@pytest.mark.parametrize("seed", range(3))
def test_two_hinged_bodies_obey_newton_and_euler(seed):
    dynamics = Simulation(scene_of(document())).dynamics
    q, v = np.random.default_rng(seed).normal(size=(2, 2)) * 2.0
    found = dynamics.forward_dynamics(q, v, efforts=TORQUES)
    np.testing.assert_allclose(found, absolute_accelerations(q, v), rtol=1e-9, atol=1e-9)


def test_they_move_as_an_explicit_integrator_moves_them():
    simulation = Simulation(scene_of(document()))
    simulation.set_efforts(TORQUES)
    simulation.advance(400)

    def rates(t, y):
        return np.concatenate([y[2:], absolute_accelerations(y[:2], y[2:])])

    found = solve_ivp(rates, (0, 0.8), [0.4, -0.9, 1.5, 0.0], rtol=1e-8, atol=1e-8, method="DOP853")
    np.testing.assert_allclose(simulation.q, found.y[:2, -1], atol=2e-6)
    np.testing.assert_allclose(simulation.v, found.y[2:, -1], atol=2e-5)
    ledger = simulation.ledger()
    assert abs(ledger[-1]) < 1e-6 * abs(ledger[:6]).max()


def test_a_rod_that_hardly_bends_moves_as_the_rigid_body_of_its_mass():
    """E → ∞: two hinged stiff rods and the two rigid bodies of the same mass and inertia."""
    length, radius, density = 0.5, 0.02, 1000.0
    mass = density * np.pi * radius**2 * length
    thin = mass * radius**2 / 4 + mass * length**2 / 12
    rods, bodies = [], []
    for i, axis in enumerate(([0, 1, 0.3], [0.2, 1, -0.4])):
        shift = {"offset": {"position": [length, 0.0, 0.0]}} if i else {}
        hinge = {"joint": f"j{i}", "kind": "revolute", "axis": axis}
        rods += [hinge, {"rod": f"r{i}", "sections": [
            {"name": "s", "length": length, "material": "hard",
             "cross_section": {"shape": "circle", "radius": radius}}]}]  # fmt: skip
        bodies += [hinge | shift, {"rigid_body": f"b{i}", "mass": mass,
                                   "inertia": [mass * radius**2 / 2, thin, thin],
                                   "com": {"position": [length / 2, 0, 0]}}]  # fmt: skip
    common = {
        "gravity": [0, 0, -9.81],
        "materials": {"hard": SOFT | {"young_modulus": 1e14, "shear_modulus": 4e13}},
        "actuators": [{"joint_torque": f"t{i}", "joint": f"j{i}"} for i in range(2)],
        "initial": {"positions": {"j1": 0.7}},
    }
    common["materials"]["hard"]["viscosity"] = 1e8
    numerics = {"step": 0.002, "integrator": "sdirk4"}
    ends = []
    for chain in (rods, bodies):
        basis = {"basis": {"order": 1}} if chain is rods else {}
        simulation = Simulation(scene_of(
            {"name": "chain", "bodies": chain, "numerics": numerics | basis} | common
        ))  # fmt: skip
        simulation.set_efforts([0.5, -0.2])
        simulation.advance(250)
        at = [simulation.coordinate_names.index(name) for name in ("j0", "j1")]
        ends.append((simulation.q[at].copy(), simulation.v[at].copy()))
    np.testing.assert_allclose(ends[0][0], ends[1][0], atol=1e-5)
    np.testing.assert_allclose(ends[0][1], ends[1][1], atol=1e-4)
