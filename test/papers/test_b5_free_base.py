"""B-5: configurations SE(3) × Rᵐ: nothing holds the base, and the momentum map is conserved."""

import numpy as np
import pytest
from scenes import ALL, SOFT, rod_document, scene_of
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

from soft_sim_ros.core.integrators.problem import UPHOLD
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import StaticsFailed

FREE = {"joint": "base", "kind": "free"}
TWIST = [1.0, 3.0, -2.0, 0.3, 0.2, -0.1]


def flyer(*, base=None, initial=None, **options):
    """A soft rod in flight, bent and twisted when let go."""
    shape = {"rod/s": {"bend_y": 1.0, "torsion": 0.5}}
    start = {"velocities": {"base": TWIST}, "strains": shape} | (initial or {})
    document = rod_document(
        strains=options.pop("strains", ["torsion", "bend_y", "bend_z"]), order=2, initial=start,
        **options,
    )  # fmt: skip
    document["bodies"].insert(0, FREE)
    return document | ({"base": base} if base else {})


def momentum(simulation):
    return simulation.dynamics.momentum(simulation.q, simulation.v)


def test_momentum_of_a_flying_body_lasts_for_a_hundred_thousand_steps():
    """A bending body that tumbles for 200 s: 1e-10, angular and linear, far away from the start."""
    simulation = Simulation(scene_of(flyer(
        radius=0.02, material={"viscosity": 30.0},
        numerics={"step": 0.002, "integrator": "sdirk2", "newton_tolerance": 1e-7},
    )))  # fmt: skip
    start = momentum(simulation)
    scale = np.repeat([np.linalg.norm(start[:3]), np.linalg.norm(start[3:])], 3)
    turned = 0.0
    for _ in range(20):
        simulation.advance(5000)
        turned = max(turned, np.linalg.norm(simulation.q[:3]))
        assert np.all(abs(momentum(simulation) - start) < 1e-10 * scale)
    assert turned > np.pi
    travelled = simulation.q[3:6]
    assert np.linalg.norm(travelled) > 40.0  # arm's lengths away, and more


def test_conserving_momentum_does_no_harm_to_energy():
    """The same undamped flight with and without: energy drifts no more, momentum not at all."""
    drift = []
    for kept in (True, False):
        simulation = Simulation(scene_of(flyer(
            strains=ALL, numerics={"step": 0.002, "integrator": "implicit_midpoint"},
        )))  # fmt: skip
        if not kept:
            simulation._problem.calls[UPHOLD] = 0
        before = momentum(simulation)
        energy = sum(simulation.dynamics.energies(simulation.q, simulation.v))
        worst = 0.0
        for _ in range(10):
            simulation.advance(30)
            now = sum(simulation.dynamics.energies(simulation.q, simulation.v))
            worst = max(worst, abs(now / energy - 1.0))
        lost = np.abs(momentum(simulation) - before).max() / np.abs(before).max()
        drift.append((worst, lost))
    assert drift[0][0] < 1.5 * drift[1][0]
    assert drift[0][1] < 1e-12 < 1e-6 < drift[1][1]


def test_a_body_thrown_under_its_weight_keeps_its_balance():
    """P(t) = P₀ + m g t and the spin about the centre of mass stays, whatever bends."""
    gravity = np.array([0.3, -0.5, -9.81])
    base = {"position": [0.4, -1.0, 2.0], "rpy": [0.5, -0.3, 1.2]}
    simulation = Simulation(scene_of(flyer(
        base=base, gravity=gravity, numerics={"step": 0.002, "newton_tolerance": 1e-8},
    )))  # fmt: skip
    dynamics, mass = simulation.dynamics, simulation.model.inertia[:, 0]

    def centre():
        return mass @ dynamics.node_poses(simulation.q)[:, :3, 3] / mass.sum()

    def spin():
        total = momentum(simulation)
        return total[:3] - np.cross(centre(), total[3:])

    start, whirl, r0 = momentum(simulation), spin(), centre()
    for k in range(1, 6):
        simulation.advance(100)
        t = 0.2 * k
        now = momentum(simulation)
        np.testing.assert_allclose(now[3:], start[3:] + mass.sum() * gravity * t, rtol=1e-10)
        np.testing.assert_allclose(spin(), whirl, rtol=1e-9, atol=1e-9 * np.abs(whirl).max())
        path = r0 + start[3:] / mass.sum() * t + 0.5 * gravity * t * t
        np.testing.assert_allclose(centre(), path, atol=1e-11)


def test_a_thrust_changes_momentum_by_its_impulse_to_the_order_of_the_method():
    thrust = np.array([0.2, -0.3, 0.5])
    errors = []
    for step in (0.002, 0.001):
        simulation = Simulation(scene_of(flyer(
            loads=[{"point": "jet", "body": "rod", "force": thrust}],
            numerics={"step": step, "integrator": "sdirk2", "newton_tolerance": 1e-10},
        )))  # fmt: skip
        start = momentum(simulation)
        simulation.advance(round(0.2 / step))
        errors.append(np.linalg.norm(momentum(simulation)[3:] - start[3:] - 0.2 * thrust))
    assert errors[0] < 0.02 * 0.2 * np.linalg.norm(thrust)
    assert errors[1] < 0.35 * errors[0]


def test_inner_efforts_move_the_body_but_not_its_momentum():
    """A cat turns: a motor and a tendon between the parts, at rest in the whole."""
    document = flyer(
        initial={"velocities": {}, "strains": {}}, numerics={"step": 0.002},
        actuators=[{"tendon": "pull", "rod": "rod", "offset": [0.02, 0.01]},
                   {"joint_torque": "motor", "joint": "waist"}],
    )  # fmt: skip
    document["bodies"] += [
        {"joint": "waist", "kind": "revolute", "axis": [0.4, 1, 0.2]},
        {"rigid_body": "wheel", "mass": 0.4, "inertia": [1e-3, 2e-3, 1.5e-3],
         "com": {"position": [0.02, 0.03, 0.0]}},
    ]  # fmt: skip
    simulation = Simulation(scene_of(document))
    simulation.set_efforts([2.0, 0.01])
    simulation.advance(300)
    assert np.linalg.norm(simulation.q[:3]) > 0.1
    np.testing.assert_allclose(momentum(simulation), 0.0, atol=1e-14)


def test_the_momentum_map_is_the_derivative_of_kinetic_energy():
    """∂T/∂η₀ at the base, carried to the world's origin by Ad*: angular part first."""
    simulation = Simulation(
        scene_of(flyer(base={"position": [0.4, -1.0, 2.0], "rpy": [0.5, 0, 1]}))
    )
    dynamics, q, v = simulation.dynamics, simulation.q.copy(), simulation.v.copy()
    q[3:6] = [0.3, 0.5, -0.2]
    wrench = []
    for j in range(6):
        plus, minus = v.copy(), v.copy()
        plus[j] += 1.0
        minus[j] -= 1.0
        wrench.append(0.5 * (dynamics.energies(q, plus)[0] - dynamics.energies(q, minus)[0]))
    angular, linear = np.array(wrench[:3]), np.array(wrench[3:])
    turn = simulation.compiled.base[:3, :3]
    at = simulation.compiled.base[:3, 3] + turn @ q[3:6]
    push = turn @ linear
    expected = np.concatenate([turn @ angular + np.cross(at, push), push])
    np.testing.assert_allclose(dynamics.momentum(q, v), expected, rtol=1e-10, atol=1e-12)


def test_euler_top_spins_as_jacobi_says():
    """Free asymmetric body, I₁ < I₂ < I₃: ω(t) in elliptic functions, many turns."""
    i1, i2, i3 = 0.010, 0.016, 0.022
    start = np.array([0.0, 2.0, 9.0])
    document = {
        "name": "euler", "gravity": [0, 0, 0],
        "bodies": [FREE, {"rigid_body": "b", "mass": 1.0, "inertia": [i1, i2, i3]}],
        "initial": {"velocities": {"base": [*start, 0, 0, 0]}},
        "numerics": {"step": 0.001, "integrator": "sdirk4"},
    }  # fmt: skip
    simulation = Simulation(scene_of(document))
    energy, momentum2 = (start**2) @ [i1, i2, i3], (start**2) @ np.square([i1, i2, i3])
    # Landau and Lifshitz, section 37, for M² > 2E I₂, with ω₁ = 0 at the start
    rate = np.sqrt((i3 - i2) * (momentum2 - energy * i1) / (i1 * i2 * i3))
    m = (i2 - i1) * (energy * i3 - momentum2) / ((i3 - i2) * (momentum2 - energy * i1))
    a = [
        np.sqrt((energy * i3 - momentum2) / (i1 * (i3 - i1))),
        np.sqrt((energy * i3 - momentum2) / (i2 * (i3 - i2))),
        np.sqrt((momentum2 - energy * i1) / (i3 * (i3 - i1))),
    ]
    quarter = np.pi / 2 / rate  # only to look at instants all over the period
    for _ in range(8):
        simulation.advance(round(0.7 * quarter / 0.001))
        # here ω₂ is largest and ω₁ = 0 at t = 0: a quarter of a period after ω₂ = 0
        sn, cn, dn, _ = ellipj(rate * simulation.time + ellipk(m), m)
        twist = simulation.dynamics.node_twists(simulation.q, simulation.v)[-1]
        expected = [a[0] * cn, a[1] * sn, a[2] * dn]
        np.testing.assert_allclose(twist[:3], expected, atol=2e-6)


def test_where_the_frame_stands_does_not_matter():
    """Moving base and initial pose of the free body instead of the base frame: the same flight."""
    turn = Rotation.from_euler("xyz", [0.5, -0.3, 1.2])
    shift = np.array([0.4, -1.0, 2.0])
    gravity = np.array([0.0, 0.0, -9.81])
    one = Simulation(scene_of(flyer(
        gravity=gravity, base={"position": shift, "rpy": turn.as_euler("xyz")},
        material=SOFT, numerics={"integrator": "sdirk4"},
    )))  # fmt: skip
    vector = turn.as_rotvec()
    other = Simulation(scene_of(flyer(
        gravity=gravity, initial={"positions": {"base": [*vector, *shift]}},
        numerics={"integrator": "sdirk4"},
    )))  # fmt: skip
    for simulation in (one, other):
        simulation.advance(100)
    first, second = (s.sampler(5).poses() for s in (one, other))
    np.testing.assert_allclose(first[:, :3], second[:, :3], atol=2e-5)
    tip = one.dynamics.node_poses(one.q)[-1]
    np.testing.assert_allclose(first[-1, :3], tip[:3, 3], atol=1e-12)
    assert np.linalg.norm(first[-1, :3] - shift) < 10.0
    aligned = Rotation.from_quat(first[:, 3:]) * Rotation.from_quat(second[:, 3:]).inv()
    assert np.all(aligned.magnitude() < 1e-4)


def test_a_free_body_has_no_equilibrium_and_the_error_says_what_to_hold():

    document = flyer(gravity=[0, 0, -9.81])
    document["initial"] = {"state": "equilibrium"}
    with pytest.raises(StaticsFailed, match=r"initial.positions.base"):
        Simulation(scene_of(document))
