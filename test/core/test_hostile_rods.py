"""Rods against solutions that share neither unknowns nor discretisation with the package."""

import numpy as np
import pytest
from cosserat_bvp import solve_rod
from scenes import ALL, SOFT, rod, rod_document, scene_of
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import fsolve

from soft_sim_ros.core.analysis.modes import modes
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation

E, G, RHO = SOFT["young_modulus"], SOFT["shear_modulus"], SOFT["density"]
LENGTH, RADIUS = 0.6, 0.03
AREA, INERTIA = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4
STIFF = np.array([2 * G * INERTIA, E * INERTIA, E * INERTIA, E * AREA, G * AREA, G * AREA])


def integrate_shape(strain, length=LENGTH):
    """Return tip position and rotation of a curve with strain(s) -> (6,), by DOP853."""

    def rates(s, y):
        turn = y[3:].reshape(3, 3)
        k, gamma = np.split(strain(s), 2)
        spin = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        return np.concatenate([turn @ gamma, (turn @ spin).ravel()])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    end = solve_ivp(rates, (0, length), start, rtol=1e-11, atol=1e-12, method="DOP853").y[:, -1]
    return end[:3], end[3:].reshape(3, 3)


def tip(dynamics, q):
    return dynamics.node_poses(q)[-1]


def test_follower_loads_in_space_are_an_initial_value_problem_from_the_tip():
    """Loads that follow the section make m' = −K×m − Γ×n − c, n' = −K×n − f an ODE."""
    force, moment = np.array([1.0, 4.0, -6.0]), np.array([0.5, -0.2, 0.6])  # per m
    tip_wrench = np.array([0.15, -0.2, 0.1, -1.0, 0.8, 1.2])
    rest = np.array([1.0, 2.0, -1.5, 1.0, 0.0, 0.0])
    document = rod_document(
        order=10,
        nodes=60,
        section={"shear_correction": 1.0, "reference": {"curvature": rest[:3]}},
        loads=[{"distributed": "d", "body": "rod", "force": force, "moment": moment,
                "frame": "body"}],
    )  # fmt: skip
    dynamics = Dynamics(scene_of(document))
    pose = tip(dynamics, equilibrium(dynamics, tip=tip_wrench, tip_follows=True))

    def rates(s, w):
        k, gamma = np.split(rest + w / STIFF, 2)
        m, n = w[:3], w[3:]
        return np.concatenate(
            [-np.cross(k, m) - np.cross(gamma, n) - moment, -np.cross(k, n) - force]
        )

    inner = solve_ivp(rates, (LENGTH, 0), tip_wrench, rtol=1e-11, atol=1e-12, dense_output=True)
    position, turn = integrate_shape(lambda s: rest + inner.sol(s) / STIFF)
    np.testing.assert_allclose(pose[:3, 3], position, atol=1e-7)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=1e-6)


def test_a_helical_tendon_acts_where_its_tension_does():
    """One tendon alone: the section carries n = −T t, m = −T d×t, t the tendon's direction."""
    tension, radius, turns, stop = 12.0, 0.022, 1.3, 0.4
    document = rod_document(order=12, nodes=50, section={"shear_correction": 1.0})
    helix = {"radius": radius, "angle": 0.3, "turns": turns}
    document["actuators"] = [{"tendon": "t", "rod": "rod", "end": stop, "helix": helix}]
    dynamics = Dynamics(scene_of(document))
    q = equilibrium(dynamics, efforts=[tension])
    rest = np.array([0, 0, 0, 1.0, 0, 0])
    rate = 2 * np.pi * turns / stop

    def path(s):
        phase = 0.3 + rate * s
        d = radius * np.array([0, np.cos(phase), np.sin(phase)])
        return d, radius * rate * np.array([0, -np.sin(phase), np.cos(phase)])

    def direction(xi, s):
        d, slope = path(s)
        t = xi[3:] + np.cross(xi[:3], d) + slope
        return d, t

    def strain(s):
        if s > stop:
            return rest

        def balance(xi):
            d, t = direction(xi, s)
            n = tension * t / np.linalg.norm(t)
            return (STIFF * (xi - rest) + np.concatenate([np.cross(d, n), n])) / STIFF

        return fsolve(balance, rest, xtol=1e-12)

    nodes, weights = np.polynomial.legendre.leggauss(60)
    s = 0.5 * stop * (nodes + 1)
    table = np.array([strain(x) for x in s])
    length = 0.5 * stop * sum(
        w * np.linalg.norm(direction(xi, x)[1]) for w, xi, x in zip(weights, table, s, strict=True)
    )  # fmt: skip
    free = stop * np.hypot(1, radius * rate)
    assert dynamics.ports(q, 0 * q)[0][0] == pytest.approx(free - length, rel=1e-5)
    fit = [np.polynomial.Legendre.fit(s, c, 25, domain=[0, stop]) for c in table.T]
    position, turn = integrate_shape(lambda x: np.array([f(x) for f in fit]), stop)
    position = position + turn @ [LENGTH - stop, 0, 0]
    pose = tip(dynamics, q)
    np.testing.assert_allclose(pose[:3, 3], position, atol=2e-6)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=2e-5)
    assert abs(pose[:3, 3] - [LENGTH, 0, 0]).max() > 0.01


def test_a_helix_and_a_pretwisted_strip_under_weight_and_end_load():
    cases = [
        ({"shape": "circle", "radius": 0.02}, [6.0, 0.0, 9.0]),
        ({"shape": "ellipse", "semi_axis_y": 0.03, "semi_axis_z": 0.012}, [[2.0, 8.0], 0.0, 1.0]),
    ]
    for shape, curvature in cases:
        a, b = shape.get("semi_axis_y", 0.02), shape.get("semi_axis_z", 0.02)
        area = np.pi * a * b
        y, z, twist = area * b**2 / 4, area * a**2 / 4, np.pi * a**3 * b**3 / (a**2 + b**2)
        stiffness = [G * twist, E * y, E * z, E * area, 0.8 * G * area, 0.8 * G * area]
        ends = [np.broadcast_to(c, 2) for c in curvature]
        section = {"cross_section": shape, "shear_correction": 0.8,
                   "reference": {"curvature": curvature}}  # fmt: skip
        dynamics = rod(order=11, nodes=50, section=section, gravity=(0, 3.0, -5.0))
        moment, force = np.array([0.02, -0.03, 0.04]), np.array([0.3, -0.2, 0.25])
        pose = tip(dynamics, equilibrium(dynamics, tip=np.concatenate([moment, force])))
        position, turn = solve_rod(
            LENGTH,
            stiffness,
            lambda s, ends=ends: np.array(
                [*(c[0] + (c[1] - c[0]) * s / LENGTH for c in ends), 1.0, 0, 0]
            ),
            density_force=RHO * area * np.array([0, 3.0, -5.0]),
            tip_force=force,
            tip_moment=moment,
            tolerance=1e-8,
        )
        np.testing.assert_allclose(pose[:3, 3], position, atol=1e-5)
        np.testing.assert_allclose(pose[:3, :3], turn, atol=5e-5)


def test_dead_and_follower_end_moments_differ_and_each_is_right():
    """A follower moment M on a twisted start bends to K = H⁻¹m(s); a dead one keeps m in space."""
    moment = np.array([0.25, 0.3, 0.0])
    dynamics = rod(order=10, nodes=60, section={"shear_correction": 1.0})
    wrench = np.concatenate([moment, np.zeros(3)])
    dead = tip(dynamics, equilibrium(dynamics, tip=wrench))
    follower = tip(dynamics, equilibrium(dynamics, tip=wrench, tip_follows=True))
    position, _ = solve_rod(
        LENGTH, STIFF, lambda s: np.array([0, 0, 0, 1.0, 0, 0]), tip_moment=moment
    )
    np.testing.assert_allclose(dead[:3, 3], position, atol=1e-7)

    def rates(s, m):
        return -np.cross(m / STIFF[:3], m)

    inner = solve_ivp(rates, (LENGTH, 0), moment, rtol=1e-11, atol=1e-12, dense_output=True)
    rest = np.array([0, 0, 0, 1.0, 0, 0])
    position, _ = integrate_shape(
        lambda s: rest + np.concatenate([inner.sol(s) / STIFF[:3], np.zeros(3)])
    )
    np.testing.assert_allclose(follower[:3, 3], position, atol=1e-7)
    assert np.linalg.norm(dead[:3, 3] - follower[:3, 3]) > 0.005


@pytest.mark.parametrize("thin", [0.3, 0.6])
def test_frequencies_of_a_tapered_rod_are_those_of_beam_finite_elements(thin):
    r0, n = 0.006, 60
    section = {"cross_section": {"shape": "circle", "radius": [r0, thin * r0]}}
    dynamics = rod(strains=["bend_z"], order=10, nodes=20, section=section)
    found = modes(dynamics, np.zeros(dynamics.n))[0][:3]
    size = 2 * n + 2
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    h = LENGTH / n
    points, weights = np.polynomial.legendre.leggauss(6)
    for e in range(n):
        for p, w in zip(0.5 * (points + 1), 0.5 * weights * h, strict=True):
            r = r0 * (1 + (thin - 1) * (e + p) / n)
            shape = np.array([1 - 3 * p**2 + 2 * p**3, h * (p - 2 * p**2 + p**3),
                              3 * p**2 - 2 * p**3, h * (p**3 - p**2)])  # fmt: skip
            slope = np.array([-6 * p + 6 * p**2, h * (1 - 4 * p + 3 * p**2),
                              6 * p - 6 * p**2, h * (3 * p**2 - 2 * p)]) / h  # fmt: skip
            bend = np.array([-6 + 12 * p, h * (-4 + 6 * p), 6 - 12 * p, h * (6 * p - 2)]) / h**2
            at = slice(2 * e, 2 * e + 4)
            stiffness[at, at] += w * E * np.pi * r**4 / 4 * np.outer(bend, bend)
            mass[at, at] += w * RHO * np.pi * r**2 * np.outer(shape, shape)
            mass[at, at] += w * RHO * np.pi * r**4 / 4 * np.outer(slope, slope)  # rotary inertia
    expected = np.sqrt(eigh(stiffness[2:, 2:], mass[2:, 2:], eigvals_only=True)[:3])
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def spinning(strains, rate, radius, order=9):
    """Return a rod on a turntable and the velocity of pure spin at ``rate`` in rad/s."""
    document = rod_document(strains=strains, order=order, radius=radius, nodes=24)
    document["bodies"].insert(0, {"joint": "hub", "kind": "revolute", "axis": [0, 0, 1]})
    dynamics = Dynamics(scene_of(document))
    v = np.zeros(dynamics.n)
    v[dynamics.compiled.coordinate_names.index("hub")] = rate
    return dynamics, v


@pytest.mark.parametrize(
    ("gamma", "flap"),  # Wright, Smith, Thresher & Wang, J. Appl. Mech. 49 (1982), hub radius 0
    [(0.0, (3.5160, 22.0345)), (2.0, (4.1373, 22.6149)), (12.0, (13.1702, 37.6031))],
)
def test_flapping_frequencies_of_a_spinning_beam_are_the_published_ones(gamma, flap):
    radius = 0.0005
    unit = np.sqrt(E * radius**2 / 4 / RHO) / LENGTH**2
    dynamics, v = spinning(["bend_y"], gamma * unit, radius)
    zero = np.zeros(dynamics.n)
    stiffness, _, mass = dynamics.tangents(zero, v, zero)
    found = np.sqrt(eigh(stiffness[1:, 1:], mass[1:, 1:], eigvals_only=True)[:2]) / unit
    np.testing.assert_allclose(found, flap, rtol=1e-4)


def test_steady_spin_stretches_a_rod_by_the_exact_amount():
    """EA x'' + ρA Ω² x = 0, x(0) = 0, x'(L) = 1 for the place x(s) of a section on the radius."""
    rate = 30.0
    dynamics, v = spinning(["stretch"], rate, 0.03)
    q, zero = np.zeros(dynamics.n), np.zeros(dynamics.n)
    for _ in range(8):
        residual = dynamics.inverse_dynamics(q, v, zero)
        stiffness = dynamics.tangents(q, v, zero)[0]
        q[1:] -= np.linalg.solve(stiffness[1:, 1:], residual[1:])
    k = rate * np.sqrt(RHO / E)
    assert tip(dynamics, q)[0, 3] == pytest.approx(
        np.sin(k * LENGTH) / (k * np.cos(k * LENGTH)), rel=1e-9
    )


def link_chain(n, length, radius, hub, viscosity, torque, duration):
    """Return hub angle and tip (3,) of rigid rods with n springs EI n/L, driven at the root.

    Lagrange's equations in the absolute angles φ of the links, integrated explicitly.
    """
    area, inertia = np.pi * radius**2, np.pi * radius**4 / 4
    spring = E * inertia * n / length
    links = np.full(n + 1, length / n)  # a hinge in the middle of each of n equal cells
    links[[0, -1]] *= 0.5
    mass = RHO * area * links
    beyond = mass.sum() - np.cumsum(mass)
    last = np.maximum.outer(np.arange(n + 1), np.arange(n + 1))
    lever = np.outer(links, links) * (beyond + mass / 2)[last]
    lever += np.diag(links**2 * -mass / 6 + RHO * inertia * links)
    lever[0, 0] += hub
    difference = np.diff(np.eye(n + 1), axis=0)
    bending = spring * difference.T @ difference
    loss = viscosity / G * bending  # one retardation time for all strains

    def rates(t, y):
        phi, w = np.split(y, 2)
        turn = phi[:, None] - phi[None, :]
        force = -bending @ phi - loss @ w - (lever * np.sin(turn)) @ w**2
        force[0] += torque
        return np.concatenate([w, np.linalg.solve(lever * np.cos(turn), force)])

    start = np.zeros(2 * n + 2)
    found = solve_ivp(rates, (0, duration), start, rtol=1e-7, atol=1e-8, method="DOP853")
    phi = found.y[: n + 1, -1]
    return np.array([phi[0], links @ np.cos(phi), links @ np.sin(phi)])


def test_spin_up_of_a_flexible_beam_is_the_limit_of_a_chain_of_rigid_links():
    radius, hub, viscosity, torque, duration = 0.01, 2e-3, 2000.0, 0.15, 0.25
    document = rod_document(
        strains=["bend_z"],
        radius=radius,
        material={"viscosity": viscosity},
        numerics={"basis": {"order": 6, "nodes": 16}, "step": 0.001, "integrator": "sdirk4"},
    )
    document["bodies"].insert(0, {"joint": "hub", "kind": "revolute", "axis": [0, 0, 1]})
    document["bodies"].insert(1, {"rigid_body": "rotor", "mass": 1.0, "inertia": [hub] * 3})
    document["actuators"] = [{"joint_torque": "motor", "joint": "hub"}]
    simulation = Simulation(scene_of(document))
    simulation.set_efforts([torque])
    simulation.advance(round(duration / 0.001))
    coarse, fine = (
        link_chain(n, LENGTH, radius, hub, viscosity, torque, duration) for n in (10, 20)
    )
    limit = fine + (fine - coarse) / 3.0
    found = simulation.sampler(2).poses()[-1, :2]
    np.testing.assert_allclose(found, limit[1:], atol=1e-4)
    assert np.linalg.norm(found) < 0.97 * LENGTH  # it did bend
    ledger = simulation.ledger()
    assert abs(ledger[-1]) < 1e-4 * ledger[3]


@pytest.mark.parametrize("integrator", ["sdirk2", "sdirk4", "implicit_midpoint"])
def test_angular_momentum_about_a_free_vertical_axis_is_kept(integrator):
    """Weight has no moment about a vertical hinge: ∂T/∂φ̇ is constant however the arm flaps."""
    document = rod_document(
        strains=ALL[:4],
        order=2,
        gravity=(0, 0, -9.81),
        radius=0.02,
        numerics={"basis": {"order": 2}, "step": 0.002, "integrator": integrator,
                  "newton_tolerance": 1e-12},
        initial={"velocities": {"hub": 4.0}},
    )  # fmt: skip
    document["bodies"].insert(0, {"joint": "hub", "kind": "revolute", "axis": [0, 0, 1]})
    drift = []
    for steps, size in ((100, 0.002), (200, 0.001)):
        document["numerics"]["step"] = size
        simulation = Simulation(scene_of(document))
        dynamics = simulation.dynamics
        start = (dynamics.mass_matrix(simulation.q) @ simulation.v)[0]
        simulation.advance(steps)
        drift.append(abs((dynamics.mass_matrix(simulation.q) @ simulation.v)[0] / start - 1))
    assert drift[1] < 1e-3
    assert drift[1] < 0.4 * drift[0] or drift[0] < 1e-9
