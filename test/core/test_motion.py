"""Motion against the theory of small vibrations, and the order of every integrator."""

import itertools

import numpy as np
import pytest
from scenes import ALL, rod, rod_document, rod_simulation, scene_of
from scipy.integrate import trapezoid
from scipy.linalg import eig
from scipy.optimize import brentq

from soft_sim_ros.core.analysis.modes import frequencies, modes
from soft_sim_ros.core.settled import Simulation

LENGTH, RADIUS, E, G, RHO = 0.6, 0.006, 1e6, 1e6 / 3, 1000.0
AREA, INERTIA = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4


def test_bending_frequencies_of_a_slender_clamped_rod():
    dynamics = rod(radius=RADIUS, strains=["bend_y", "bend_z"], order=9, nodes=16)
    roots = [
        brentq(lambda b: np.cos(b) * np.cosh(b) + 1, x - 0.5, x + 0.5) for x in (1.9, 4.7, 7.8)
    ]
    expected = np.array(roots) ** 2 / LENGTH**2 * np.sqrt(E * INERTIA / (RHO * AREA))
    found = modes(dynamics, np.zeros(dynamics.n))[0]
    # every frequency twice: two bending planes; rotary inertia lowers the third by (r/L)² effects
    np.testing.assert_allclose(found[[0, 2, 4]], expected, rtol=2e-3)
    np.testing.assert_allclose(found[[1, 3, 5]], found[[0, 2, 4]], rtol=1e-9)
    assert frequencies(dynamics)[0] == pytest.approx(found[0] / (2 * np.pi))


def test_rotary_inertia_lowers_a_frequency_by_rayleighs_amount():
    """Rayleigh: relative change −½ (I/A) ∫w'² / ∫w²; a second-order effect, so tested by itself."""

    def lowest(radius):
        found = modes(d := rod(radius=radius, strains=["bend_z"], order=9, nodes=16), 0 * d._zero)
        return found[0][0] / radius  # ω ∝ r in Euler–Bernoulli theory

    b = 1.8751040687119611 / LENGTH
    x = np.linspace(0, LENGTH, 4001)
    k = (np.sinh(b * LENGTH) - np.sin(b * LENGTH)) / (np.cosh(b * LENGTH) + np.cos(b * LENGTH))
    w = np.cosh(b * x) - np.cos(b * x) - k * (np.sinh(b * x) - np.sin(b * x))
    slope = b * (np.sinh(b * x) + np.sin(b * x) - k * (np.cosh(b * x) - np.cos(b * x)))
    ratio = trapezoid(slope**2, x) / trapezoid(w**2, x)
    radius = 0.03
    expected = -0.5 * radius**2 / 4 * ratio
    assert lowest(radius) / lowest(1e-4) - 1 == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize(
    ("strain", "speed"),
    [("stretch", np.sqrt(E / RHO)), ("torsion", np.sqrt(G / RHO))],
)
def test_axial_and_torsional_frequencies_of_a_clamped_rod(strain, speed):
    dynamics = rod(strains=[strain], order=8, nodes=14)
    found = modes(dynamics, np.zeros(dynamics.n))[0][:3]
    np.testing.assert_allclose(found, np.array([0.5, 1.5, 2.5]) * np.pi * speed / LENGTH, rtol=1e-6)


def test_torsion_of_an_ellipse_uses_saint_venants_constant_and_the_polar_inertia():
    a, b = 0.03, 0.01
    section = {"cross_section": {"shape": "ellipse", "semi_axis_y": a, "semi_axis_z": b}}
    dynamics = rod(strains=["torsion"], section=section, order=6)
    constant = np.pi * a**3 * b**3 / (a**2 + b**2)
    polar = np.pi * a * b * (a**2 + b**2) / 4
    expected = 0.5 * np.pi / LENGTH * np.sqrt(G * constant / (RHO * polar))
    assert modes(dynamics, np.zeros(dynamics.n))[0][0] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("strain", ["bend_z", "stretch", "torsion"])
def test_kelvin_voigt_damping_ratio_is_half_omega_times_the_retardation_time(strain):
    viscosity = 400.0
    retardation = viscosity / G
    dynamics = rod(strains=[strain], order=6, material={"viscosity": viscosity})
    zero = np.zeros(dynamics.n)
    stiffness, damping, mass = dynamics.tangents(zero, zero, zero)
    omega = modes(dynamics, zero)[0][0]
    n = dynamics.n
    state = np.block(
        [
            [np.zeros((n, n)), np.eye(n)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
        ]
    )
    poles = eig(state)[0]
    slowest = poles[np.argmin(np.abs(np.abs(poles) - omega))]
    assert -slowest.real / abs(slowest) == pytest.approx(0.5 * omega * retardation, rel=1e-6)


def test_free_decay_in_time_has_that_frequency_and_damping():
    viscosity = 5000.0
    document = rod_document(
        radius=RADIUS,
        strains=["bend_z"],
        order=4,
        material={"viscosity": viscosity},
        numerics={"basis": {"order": 4}, "step": 0.002, "integrator": "sdirk4"},
        initial={"strains": {"rod/s": {"bend_z": 0.01}}},
    )
    simulation = Simulation(scene_of(document))
    dynamics = simulation.dynamics
    omega, shape = modes(dynamics, np.zeros(dynamics.n))
    to_mode = shape[:, 0] @ dynamics.mass_matrix(np.zeros(dynamics.n))
    zeta = 0.5 * omega[0] * viscosity / G
    damped = omega[0] * np.sqrt(1 - zeta**2)
    start = to_mode @ simulation.q
    for _ in range(10):
        simulation.advance(50)
        t = simulation.time
        decay = np.exp(-zeta * omega[0] * t)
        expected = (
            start * decay * (np.cos(damped * t) + zeta * omega[0] / damped * np.sin(damped * t))
        )
        assert to_mode @ simulation.q == pytest.approx(expected, abs=2e-3 * abs(start))


def swing(step, integrator, duration=0.32, viscosity=2000.0, **options):
    """Free fall of a soft clamped rod, in space."""
    simulation = rod_simulation(
        radius=0.02,
        strains=ALL[:4],
        order=2,
        gravity=(1.0, 3.0, -9.0),
        material={"viscosity": viscosity},
        numerics={
            "basis": {"order": 2},
            "step": step,
            "integrator": integrator,
            "newton_tolerance": 1e-12,
            "options": options,
        },
    )
    simulation.advance(round(duration / step))
    return simulation


@pytest.fixture(scope="module")
def reference():
    fine = swing(0.0005, "sdirk4")
    return fine.q.copy(), fine.v.copy(), fine.dynamics.model.weight


@pytest.mark.parametrize(
    ("integrator", "order", "steps", "options"),
    [
        ("sdirk2", 2, (0.004, 0.002, 0.001), {}),
        ("sdirk3", 3, (0.008, 0.004, 0.002), {}),
        ("sdirk4", 4, (0.016, 0.008, 0.004), {}),
        ("implicit_midpoint", 2, (0.004, 0.002, 0.001), {}),
        ("generalized_alpha", 2, (0.004, 0.002, 0.001), {"rho": 0.3}),
        ("generalized_alpha", 2, (0.004, 0.002, 0.001), {"rho": 0.9}),
        ("energy_midpoint", 2, (0.004, 0.002, 0.001), {}),
    ],
)
def test_integrator_has_its_order(reference, integrator, order, steps, options):
    q, _, weight = reference
    errors = [np.abs((swing(h, integrator, **options).q - q) * weight).max() for h in steps]
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(slope - order) < 0.25, errors


@pytest.mark.parametrize(
    ("integrator", "order", "largest"),
    [("sdirk2", 2, 0.008), ("sdirk4", 4, 0.004), ("implicit_midpoint", 2, 0.008)],
)
def test_energy_residual_falls_with_the_order_of_the_method(integrator, order, largest):
    # light damping: in a stiff transient every method of this kind falls back to its stage order
    steps = largest * np.array([1.0, 0.5, 0.25])
    residuals = []
    for h in steps:
        simulation = swing(h, integrator, duration=0.0, viscosity=20.0)
        worst = 0.0
        for _ in range(10):  # the largest of ten, so that no zero of the error is hit by chance
            simulation.advance(round(0.032 / h))
            worst = max(worst, abs(simulation.ledger()[-1]))
        residuals.append(worst)
    slope = np.polyfit(np.log(steps), np.log(residuals), 1)[0]
    assert slope > order - 0.4, residuals
    assert residuals[-1] < 1e-3 * simulation.ledger()[0]


def test_conservative_method_keeps_the_energy_of_undamped_motion():
    simulation = rod_simulation(
        radius=0.02,
        strains=["bend_y", "bend_z"],
        order=2,
        gravity=(0, 3.0, -9.0),
        numerics={
            "basis": {"order": 2},
            "step": 0.002,
            "integrator": "implicit_midpoint",
            "newton_tolerance": 1e-12,
        },
    )
    worst = 0.0
    for _ in range(50):
        simulation.advance(100)
        ledger = simulation.ledger()
        worst = max(worst, abs(ledger[-1]))
    assert worst < 1e-3 * ledger[1]


def test_spatial_error_falls_exponentially_with_the_order_of_the_basis():
    def tip(order):
        d = rod(strains=ALL[:4], order=order, gravity=(0, 0, -9.81), nodes=24)
        from soft_sim_ros.core.analysis.statics import equilibrium

        return d.node_poses(equilibrium(d))[-1][:3, 3]

    exact = tip(12)
    errors = [np.linalg.norm(tip(p) - exact) for p in (1, 3, 5, 7)]
    assert all(b < 0.2 * a for a, b in itertools.pairwise(errors)), errors


def test_segment_error_falls_with_the_fourth_power_of_the_segment():
    def tip(nodes):
        d = rod(strains=ALL[:4], order=2, gravity=(0, 3.0, -9.81), nodes=nodes)
        q = np.random.default_rng(3).normal(size=d.n) * 0.4 / d.model.weight
        q[9:] *= 0.05
        return d.node_poses(q)[-1][:3, 3]

    # Gauss–Lobatto nodes of m segments have spacing of order 1/m
    exact = tip(100)
    counts = np.array([6, 11, 21])
    errors = [np.linalg.norm(tip(m) - exact) for m in counts]
    slope = -np.polyfit(np.log(counts - 1), np.log(errors), 1)[0]
    assert abs(slope - 4.0) < 0.5, errors
