"""B-2: chains of hinged Reissner beams against absolute coordinates, and spinning up."""

import numpy as np
import pytest
from planar_chain import Beams
from scenes import SOFT, scene_of
from scipy.integrate import quad, solve_ivp
from scipy.special import roots_legendre

from soft_sim_ros.core.settled import Dynamics, Simulation

RADIUS = 0.03
AREA, SECOND = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4
LENGTHS = (0.5, 0.4, 0.3)
TORQUES = (0.6, -0.3, 0.05)
RETARDATION = 0.002  # s; waves that neither mesh resolves die out
START = (0.2, -0.4, 0.5)  # absolute angles in rad


def manipulator(links):
    bodies = []
    for i in range(links):
        bodies += [
            {"joint": f"j{i}", "kind": "revolute", "axis": [0, 0, 1]},
            {"rod": f"r{i}", "strains": ["bend_z", "stretch", "shear_y"], "sections": [
                {"name": "s", "length": LENGTHS[i], "material": "soft", "shear_correction": 1.0,
                 "cross_section": {"shape": "circle", "radius": RADIUS}}]},
        ]  # fmt: skip
    relative = np.diff([0.0, *START[:links]])
    return {
        "name": "manipulator",
        "gravity": [0, -9.81, 0],
        "materials": {"soft": SOFT | {"viscosity": RETARDATION * SOFT["shear_modulus"]}},
        "bodies": bodies,
        "actuators": [{"joint_torque": f"t{i}", "joint": f"j{i}"} for i in range(links)],
        "initial": {"positions": {f"j{i}": relative[i] for i in range(links)}},
        "numerics": {"step": 0.001, "integrator": "sdirk4", "basis": {"order": 5}},
    }


@pytest.mark.parametrize("links", [2, 3])
def test_flexible_manipulator_moves_as_in_absolute_coordinates(links):
    """Large swings and bending of hinged beams under weight and torques: ends and hinge angles."""
    simulation = Simulation(scene_of(manipulator(links)))
    simulation.set_efforts(TORQUES[:links])
    simulation.advance(300)
    beams = Beams(
        LENGTHS[:links], SOFT["young_modulus"] * AREA, SOFT["shear_modulus"] * AREA,
        SOFT["young_modulus"] * SECOND, SOFT["density"] * AREA, SOFT["density"] * SECOND,
        9.81, TORQUES[:links], RETARDATION,
    )  # fmt: skip
    ends, angles = beams.extrapolated(START[:links], 0.3, 12)
    dynamics, chain = simulation.dynamics, simulation.compiled.chain
    poses = dynamics.node_poses(simulation.q)
    found = [poses[rod_map.last_node][:2, 3] for rod_map in chain.rods.values()]
    np.testing.assert_allclose(found, ends, atol=3e-4)
    turned = [poses[rod_map.first_node][:2, 0] for rod_map in chain.rods.values()]
    np.testing.assert_allclose(turned, np.stack([np.cos(angles), np.sin(angles)], 1), atol=3e-3)
    drop = np.linalg.norm(ends[-1] - np.cumsum(LENGTHS)[links - 1] * np.array([1.0, 0.0]))
    assert drop > 0.2


# The spin-up of Simo and Vu-Quoc (1986): EA, GA, EI, ρA, ρI of their beam, 10 m long
AXIAL, BENDING, LINE, LENGTH, LAST = 2.8e7, 1.4e4, 1.2, 10.0, 6.0


def blade(strains, order):
    width = np.sqrt(12 * BENDING / AXIAL)
    section = {
        "name": "s",
        "length": LENGTH,
        "material": "m",
        "shear_correction": 0.92857142857,
        "cross_section": {"shape": "rectangle", "width_y": width, "width_z": 1.0},
    }
    material = {"young_modulus": AXIAL / width, "shear_modulus": AXIAL / width / 2.6,
                "density": LINE / width}  # fmt: skip
    return Dynamics(scene_of({
        "name": "blade", "gravity": [0, 0, 0], "materials": {"m": material},
        "bodies": [{"joint": "hub", "kind": "revolute", "axis": [0, 0, 1]},
                   {"rod": "blade", "strains": strains, "sections": [section]}],
        "numerics": {"basis": {"order": order}},
    }))  # fmt: skip


def test_spinning_blade_gets_longer_as_published():
    """Steady state of the benchmark: the tip moves out by 5.14·10⁻⁴ m at 6 rad/s."""
    dynamics = blade(["bend_z", "stretch", "shear_y"], 3)
    q, v, zero = np.zeros(dynamics.n), np.zeros(dynamics.n), np.zeros(dynamics.n)
    v[0] = LAST
    for _ in range(6):
        r = dynamics.inverse_dynamics(q, v, zero)
        q[1:] -= np.linalg.solve(dynamics.tangents(q, v, zero)[0][1:, 1:], r[1:])
    tip = dynamics.node_poses(q)[-1][:3, 3]
    assert tip[0] - LENGTH == pytest.approx(5.14e-4, abs=1e-6)
    # the bar in tension: ρA Ω² L³/3EA, and what the longer bar adds
    assert tip[0] - LENGTH == pytest.approx(LINE * LAST**2 * LENGTH**3 / 3 / AXIAL, rel=2e-3)


def spin(t):
    """Return angle, rate and acceleration of the hub: 15 s to the last speed."""
    w = 2 * np.pi / 15
    angle = LAST / 15 * (t * t / 2 + (np.cos(w * t) - 1) / w**2)
    return angle, LAST / 15 * (t - np.sin(w * t) / w), LAST / 15 * (1 - np.cos(w * t))


def test_spin_up_lags_as_the_linear_theory_of_blades_says():
    """Tip deflection while the hub is turned as prescribed: Euler–Bernoulli with centrifugal force.

    q̈ + (K + Ω²(S − M)) q = −Ω̇ p, in clamped–free modes, S = ∫ ½ρA(L² − x²) φ′φ′. Deflections reach
    6 % of the length, so the exact beam differs by their square.
    """
    dynamics = blade(["bend_z"], 3)
    n = dynamics.n

    def exact(t, y):
        angle, rate, acceleration = spin(t)
        q, v = np.concatenate([[angle], y[: n - 1]]), np.concatenate([[rate], y[n - 1 :]])
        a = np.zeros(n)
        a[0] = acceleration
        r = dynamics.inverse_dynamics(q, v, a)
        return np.concatenate([v[1:], -np.linalg.solve(dynamics.mass_matrix(q)[1:, 1:], r[1:])])

    roots = (1.8751040687, 4.6940911330, 7.8547574382)
    x, w = (0.5 * LENGTH * z for z in roots_legendre(30))
    x = x + 0.5 * LENGTH

    def mode(root):
        ratio = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))
        z = root * x / LENGTH
        shape = np.cosh(z) - np.cos(z) - ratio * (np.sinh(z) - np.sin(z))
        slope = np.sinh(z) + np.sin(z) - ratio * (np.cosh(z) - np.cos(z))
        return shape, slope * root / LENGTH

    shapes, slopes = (np.array(z) for z in zip(*(mode(root) for root in roots), strict=True))
    mass = LINE * (shapes * w) @ shapes.T
    stiff = np.diag(BENDING * np.power(roots, 4) / LENGTH**4 * np.diag(mass) / LINE)
    tension = 0.5 * LINE * (slopes * w * (LENGTH**2 - x**2)) @ slopes.T
    load = LINE * (shapes * w) @ x

    def linear(t, y):
        _, rate, acceleration = spin(t)
        pull = (stiff + rate**2 * (tension - mass)) @ y[:3] + acceleration * load
        return np.concatenate([y[3:], -np.linalg.solve(mass, pull)])

    times = np.linspace(0, 18, 37)
    options = {"t_eval": times, "rtol": 1e-6, "atol": 1e-7}
    blades = solve_ivp(linear, (0, 18), np.zeros(6), **options)
    expected = 2.0 * blades.y[:3].T @ [1, -1, 1]
    q = solve_ivp(exact, (0, 18), np.zeros(2 * (n - 1)), **options).y[: n - 1].T
    found = [dynamics.node_poses(np.array([0.0, *row]))[-1][1, 3] for row in q]
    assert np.abs(expected).max() > 0.5
    np.testing.assert_allclose(found, expected, atol=0.015 * np.abs(expected).max())
    assert quad(lambda t: spin(t)[1], 0, 15)[0] == pytest.approx(spin(15.0)[0])
