"""Reissner's beam under follower forces and moments, B (3.12)–(3.17), in two formulations."""

import numpy as np
import pytest
from scenes import random_state, rod, rod_document, rod_simulation, scene_of, zoo_document
from scipy.integrate import solve_ivp
from scipy.linalg import eig
from scipy.optimize import brentq, root

from soft_sim_ros import load_scene
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics import spatial
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.scene import packaged_scenes

LENGTH, E, G, RHO = 0.6, 1e6, 1e6 / 3, 1000.0
EFFORTS = np.array([0.3, -0.2, 8.0, 5.0])


# Two formulations of one beam


@pytest.mark.parametrize("seed", range(4))
def test_material_and_spatial_formulation_agree_at_random_states_of_a_manipulator(seed):
    """Joints, curved rods, rigid bodies, tendons, dead and follower loads, weight."""
    dynamics = Dynamics(scene_of(zoo_document()))
    q, v, a = random_state(dynamics, seed)
    material = dynamics.inverse_dynamics(q, v, a, EFFORTS, 1.0)
    fixed = spatial.inverse_dynamics(dynamics, q, v, a, EFFORTS, 1.0)
    np.testing.assert_allclose(fixed, material, rtol=0, atol=1e-14 * np.abs(material).max())


# the spatial formulation refuses shapes to touch and constraints
OPEN = [
    name
    for name in packaged_scenes()
    if not (load_scene(name).environment or load_scene(name).constraints)
]


@pytest.mark.parametrize("name", OPEN)
def test_both_formulations_agree_on_every_scene_of_the_package(name):
    """All joints, a free base, floating frames, hyperelastic rods, chambers, winches."""
    dynamics = Dynamics(load_scene(name))
    q, v, a = random_state(dynamics, 1)
    material = dynamics.inverse_dynamics(q, v, a)
    fixed = spatial.inverse_dynamics(dynamics, q, v, a)
    np.testing.assert_allclose(fixed, material, rtol=0, atol=1e-13 * np.abs(material).max())


def test_spatial_twists_and_wrenches_are_those_of_the_sections():
    dynamics = Dynamics(scene_of(zoo_document()))
    q, v, a = random_state(dynamics, 5)
    fixed = spatial.motion(dynamics, q, v, a)
    jacobian, rate = dynamics.jacobians(q, v)
    for k, pose in enumerate(fixed.pose):
        to_fixed = spatial.se3.Ad(pose)
        np.testing.assert_allclose(fixed.twist[k], to_fixed @ jacobian[k] @ v, atol=1e-11)
        # d/dt (Ad η) = Ad (η̇ + [η, η]) = Ad η̇
        body = jacobian[k] @ a + rate[k] @ v
        np.testing.assert_allclose(fixed.rate[k], to_fixed @ body, atol=1e-9)
    np.testing.assert_allclose(dynamics.compiled.base @ fixed.pose, dynamics.node_poses(q))


def follower_loads(scale=1.0):
    """Return follower forces and moments at the tip, inside, and along the whole rod."""
    return [
        {"point": "tip", "body": "rod", "frame": "body",
         "force": np.array([-0.3, 0.4, 0.25]) * scale, "moment": np.array([0.05, 0.02, -0.08])
         * scale},
        {"distributed": "along", "body": "rod", "frame": "body",
         "force": np.array([0.3, -0.9, 0.8]) * scale, "moment": np.array([0.06, 0.05, -0.04])
         * scale},
    ]  # fmt: skip


def test_both_formulations_give_one_motion():
    """The same Runge–Kutta scheme, with the equations of motion of either formulation alone."""
    dynamics = rod(order=1, loads=follower_loads(2.0), radius=0.02, material={"viscosity": 200.0})
    n = dynamics.n
    zero = np.zeros(n)

    def material(q, v):
        return dynamics.forward_dynamics(q, v)

    def fixed(q, v):
        bias = spatial.inverse_dynamics(dynamics, q, v, zero)
        rest = spatial.inverse_dynamics(dynamics, q, zero, zero)
        columns = [spatial.inverse_dynamics(dynamics, q, zero, e) - rest for e in np.eye(n)]
        return np.linalg.solve(np.stack(columns, axis=1), -bias)

    def run(acceleration, h=2e-4, steps=60):
        q, v = np.zeros(n), np.zeros(n)
        for _ in range(steps):
            k1 = acceleration(q, v)
            middle = v + 0.5 * h * k1
            k2 = acceleration(q + 0.5 * h * v, middle)
            q, v = q + h * middle, v + h * k2
        return q

    one, other = run(material), run(fixed)
    size = np.abs(one * dynamics.model.weight).max()
    assert size > 0.01  # it has moved
    assert np.abs((one - other) * dynamics.model.weight).max() < 1e-9 * size


def test_every_step_of_a_long_motion_solves_both_formulations():
    """Large turns under follower loads; implicit midpoint, whose stage is a state of the motion."""
    simulation = rod_simulation(
        order=2,
        radius=0.02,
        loads=follower_loads(3.0),
        material={"viscosity": 300.0},
        numerics={
            "integrator": "implicit_midpoint", "step": 0.002, "basis": {"order": 2},
            "newton_tolerance": 1e-10,
        },
    )  # fmt: skip
    dynamics, h = simulation.dynamics, 0.002
    worst = reach = 0.0
    for _ in range(100):
        q, v = simulation.q.copy(), simulation.v.copy()
        simulation.advance(1)
        a = (simulation.v - v) / h
        # midpoint: q + h/2 (v + h/2 a), v + h/2 a, a
        stage = (q + 0.5 * h * (v + 0.5 * h * a), v + 0.5 * h * a, a)
        size = np.abs(dynamics.mass_matrix(stage[0]) @ a).max()
        material = dynamics.inverse_dynamics(*stage, time=0.1)
        fixed = spatial.inverse_dynamics(dynamics, *stage, time=0.1)
        worst = max(worst, np.abs(fixed - material).max() / size)
        reach = max(reach, np.abs(dynamics.node_poses(simulation.q)[-1, :3, 3]).max())
        assert np.abs(fixed).max() < 1e-6 * size  # Newton's method ends there
    assert simulation.statistics().refused == 0  # every step is one stage
    assert worst < 1e-12
    assert reach > 0.3


# Statics: the material equations as an initial value problem from the tip


def material_statics(stiffness, tip, along):
    """Return tip pose (4, 4) of a straight rod under follower loads only.

    Follower loads are known in section axes, so (3.15) can be integrated backwards from the tip,
    M′ = −K × M − Γ × N − m, N′ = −K × N − n, without shooting; then r′ = R Γ, R′ = R K× forwards.
    """

    def wrench_rate(s, y):
        m, n = y[:3], y[3:]
        k, g = m / stiffness[:3], n / stiffness[3:] + [1.0, 0.0, 0.0]
        return -np.concatenate(
            [np.cross(k, m) + np.cross(g, n) + along[:3], np.cross(k, n) + along[3:]]
        )

    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    wrench = solve_ivp(wrench_rate, (LENGTH, 0.0), tip, dense_output=True, **options).sol

    def pose_rate(s, y):
        w = wrench(s)
        k, g = w[:3] / stiffness[:3], w[3:] / stiffness[3:] + [1.0, 0.0, 0.0]
        turn = y[3:].reshape(3, 3)
        return np.concatenate([turn @ g, np.cross(turn, k).ravel()])  # rows × K = R K×

    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    end = solve_ivp(pose_rate, (0.0, LENGTH), start, **options).y[:, -1]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = end[3:].reshape(3, 3), end[:3]
    return pose


def test_follower_forces_and_moments_in_space_at_the_end_and_along_the_rod():
    dynamics = rod(order=8, elements=2, nodes=30, radius=0.016, loads=follower_loads())
    section = dynamics.compiled.scene.bodies[0].sections[0]
    stiffness = section.stiffness(np.array(0.5))
    loads = follower_loads()
    tip, along = (np.concatenate([x["moment"], x["force"]]) for x in loads)
    expected = material_statics(stiffness, tip, along)
    found = dynamics.node_poses(equilibrium(dynamics, stable=False))[-1]
    turn = np.arccos(0.5 * (np.trace(expected[:3, :3]) - 1.0))
    assert turn > 1.0
    np.testing.assert_allclose(found, expected, atol=2e-6)
    # the sign of any of the loads matters a thousand times more than the tolerance
    for change in range(6):
        other = np.concatenate([tip, along])
        other[change] *= -1.0
        assert np.abs(material_statics(stiffness, other[:6], other[6:]) - expected).max() > 2e-3


@pytest.mark.parametrize("load", [1.0, 5.0, 15.0])
def test_cantilever_under_a_force_normal_to_its_tip(load):
    """Inextensible elastica with follower end force P, P L²/EI up to 15: the tip turns past 180°.

    In the tip's own frame the force is known, so the curve can be drawn from there to the clamp.
    """
    radius = 0.006
    stiffness = E * np.pi * radius**4 / 4
    force = load * stiffness / LENGTH**2

    def rate(s, y):  # s from the tip to the clamp; x, y, φ in the tip frame, φ(0) = 0
        return [-np.cos(y[2]), -np.sin(y[2]), force * y[0] / stiffness]

    y = solve_ivp(rate, (0, LENGTH), [0.0, 0.0, 0.0], rtol=1e-12, atol=1e-14).y[:, -1]
    turn = -y[2]
    c, s = np.cos(turn), np.sin(turn)
    clamp = np.array([c * y[0] - s * y[1], s * y[0] + c * y[1]])
    dynamics = rod(radius=radius, strains=["bend_z"], order=7, elements=3, nodes=20)
    wrench = np.array([0, 0, 0, 0, force, 0.0])
    q = equilibrium(dynamics, tip=wrench, tip_follows=True, stable=False)
    pose = dynamics.node_poses(q)[-1]
    np.testing.assert_allclose(pose[:2, 3], -clamp, atol=1e-6 * LENGTH)
    assert np.arctan2(pose[1, 0], pose[0, 0]) == pytest.approx(
        np.arctan2(np.sin(turn), np.cos(turn)), abs=1e-6
    )


# Flutter: what only a non-symmetric tangent can see


def squared_frequencies(load, kind, radius=0.001):
    """Return λ = ω² L⁴ ρA/EI of a cantilever under ``load`` EI/L² following its tangent."""
    area, inertia = np.pi * radius**2, np.pi * radius**4 / 4
    force = load * E * inertia / LENGTH**2
    loads = {
        "beck": [{"point": "jet", "body": "rod", "frame": "body", "force": [-force, 0, 0]}],
        "leipholz": [
            {"distributed": "jet", "body": "rod", "frame": "body", "force": [-force / LENGTH, 0, 0]}
        ],
    }[kind]
    dynamics = rod(strains=["bend_z"], order=9, nodes=36, radius=radius, loads=loads)
    zero = np.zeros(dynamics.n)
    stiffness, _, mass = dynamics.tangents(zero, zero, zero)
    scale = LENGTH**4 * RHO * area / (E * inertia)
    values = eig(stiffness, mass, right=False) * scale
    return values[np.argsort(values.real)]


def beck_equation(load, omega):
    """Beck 1952: zero at the frequencies ω (in √(EI/ρA)/L²) of the column under ``load`` EI/L²."""
    root = np.sqrt(load**2 / 4 + omega**2)
    a, b = np.sqrt(root + load / 2), np.sqrt(root - load / 2)
    even = 2 * omega**2 * np.cosh(b) * np.cos(a)
    return load**2 + 2 * omega**2 + even + load * omega * np.sinh(b) * np.sin(a)


@pytest.mark.parametrize("load", [0.0, 5.0, 10.0, 15.0, 19.0])
def test_frequencies_of_becks_column(load):
    grid = np.linspace(0.5, 40.0, 4000)
    values = beck_equation(load, grid)
    at = np.flatnonzero(values[:-1] * values[1:] < 0)[:2]
    expected = [brentq(lambda w: beck_equation(load, w), grid[i], grid[i + 1]) for i in at]
    found = squared_frequencies(load, "beck")[:2]
    np.testing.assert_allclose(np.sqrt(found.real), expected, rtol=2e-4)
    assert np.all(np.abs(found.imag) < 1e-6)


@pytest.mark.parametrize(("kind", "critical"), [("beck", 20.0509), ("leipholz", 40.0537)])
def test_flutter_load(kind, critical):
    """Beck 1952: 20.05 EI/L². Leipholz 1962, load along the column: 40.05 EI/L²."""

    def apart(load):
        first, second = squared_frequencies(load, kind)[:2]
        return (first - second).real if first.imag == 0.0 else abs((first - second).imag)

    assert apart(0.99 * critical) < 0.0 < apart(1.01 * critical)
    assert brentq(apart, 0.99 * critical, 1.01 * critical, xtol=1e-4) == pytest.approx(
        critical, rel=3e-4
    )


def growth_of_becks_column(load):
    """Return the imaginary part of the fluttering ω, in √(EI/ρA)/L²."""

    def both(x):
        value = beck_equation(load, complex(x[0], x[1]))
        return [value.real, value.imag]

    found = root(both, [11.0, 3.0], tol=1e-12)
    assert found.success
    return abs(found.x[1])


@pytest.mark.parametrize("load", [22.0, 30.0])
def test_beyond_flutter_a_simulated_column_grows_as_becks_equation_says(load):
    radius = 0.006
    area, inertia = np.pi * radius**2, np.pi * radius**4 / 4
    force = load * E * inertia / LENGTH**2
    unit = np.sqrt(E * inertia / (RHO * area)) / LENGTH**2
    rate = growth_of_becks_column(load) * unit
    document = rod_document(
        radius=radius,
        strains=["bend_z"],
        order=6,
        loads=[{"point": "jet", "body": "rod", "frame": "body", "force": [-force, 0, 0]}],
        initial={"strains": {"rod/s": {"bend_z": 1e-6}}},
        numerics={"basis": {"order": 6}, "step": 0.005, "integrator": "sdirk4"},
    )
    simulation = Simulation(scene_of(document))

    times, sizes = [], []
    simulation.advance(int(2.0 / rate / 0.005))  # other modes stay behind
    for _ in range(int(8.0 / rate / 0.005)):
        simulation.advance(1)
        times.append(simulation.time)
        sizes.append(sum(simulation.dynamics.energies(simulation.q, simulation.v)[:2]))
    slope = np.polyfit(times, np.log(sizes), 1)[0]
    assert slope == pytest.approx(2.0 * rate, rel=0.02)


def test_the_scene_stands_above_eulers_load_and_below_becks():
    scene = load_scene("beck_column")
    section = scene.bodies[0].sections[0]
    unit = section.stiffness(np.array(0.5))[2] / section.length**2
    force = -scene.loads[0].force[0]
    assert 2.0 * np.pi**2 / 4 * unit < force < 20.05 * unit
    simulation = Simulation(scene)
    simulation.advance(400)
    reach = np.abs(simulation.sampler(2).poses()[-1, :2]).max()
    assert 1e-4 < reach < 0.3  # it swings, it does not fall


def test_a_follower_is_seen_to_follow():
    """A dead force of the same size would have buckled the column: it does not stand."""
    dynamics = Dynamics(scene_of(rod_document(radius=0.006, strains=["bend_z"], order=5)))
    stiffness = E * np.pi * 0.006**4 / 4
    wrench = np.array([0, 0, 0, -10.0 * stiffness / LENGTH**2, 0, 0])
    zero = np.zeros(dynamics.n)
    signs = []
    for follows in (False, True):
        data = dynamics.forcing(tip=wrench, tip_follows=follows)
        dynamics.residual(zero, zero, zero, data)
        signs.append(np.linalg.det(dynamics.last_tangent((1.0, 0.0, 0.0)) / stiffness) > 0)
    assert signs == [False, True]
