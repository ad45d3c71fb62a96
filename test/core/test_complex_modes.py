"""Damped and circulatory modes against closed forms, and Beck's flutter load."""

import numpy as np
import pytest
from scenes import rod, rod_document, scene_of
from scipy.optimize import brentq

from soft_sim_ros.core.analysis.modes import complex_modes, mode_poses, modes
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics

LENGTH, RADIUS, E, G, RHO = 0.6, 0.0005, 1e6, 1e6 / 3, 1000.0
AREA, INERTIA = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4
EI = E * INERTIA
PACE = np.sqrt(EI / (RHO * AREA)) / LENGTH**2  # a frequency is β² of these


def slender(**options):
    return rod(radius=RADIUS, strains=["bend_z"], order=8, nodes=20, **options)


def clamped_free_roots(count):
    return np.array(
        [
            brentq(lambda b: np.cos(b) + 1 / np.cosh(b), np.pi * i + 0.01, np.pi * (i + 1) - 0.01)
            for i in range(count)
        ]
    )


def test_a_viscous_cantilever_has_the_poles_of_the_damped_oscillator():
    """Kelvin–Voigt damps each mode by itself: s² + ω² T s + ω² = 0, T = η/G, above and below 1."""
    viscosity = 800_000.0  # the first two modes swing, the third creeps
    retardation = viscosity / G
    dynamics = slender(material={"viscosity": viscosity})
    found = complex_modes(dynamics, np.zeros(dynamics.n))
    omega = clamped_free_roots(3) ** 2 * PACE
    swinging = omega * retardation < 2
    assert swinging.tolist() == [True, True, False]
    for w in omega:
        for s in np.roots([1.0, w**2 * retardation, w**2]):
            if s.imag >= 0:
                # rotary inertia and the basis are the rest
                assert np.min(np.abs(found.values - s)) < 1e-4 * abs(s)
    first = np.argmin(np.abs(found.values.imag - omega[0]))
    assert found.damping_ratios[first] == pytest.approx(0.5 * omega[0] * retardation, rel=1e-4)
    assert found.growth < 0.0


def test_without_damping_they_are_the_real_modes():
    dynamics = slender()
    zero = np.zeros(dynamics.n)
    found = complex_modes(dynamics, zero)
    omega, shapes = modes(dynamics, zero)
    np.testing.assert_allclose(found.values[:5].imag, omega[:5], rtol=1e-7)
    np.testing.assert_allclose(found.frequencies[:5], omega[:5] / (2 * np.pi), rtol=1e-7)
    for i in range(3):
        along = shapes[:, i] / np.linalg.norm(shapes[:, i])
        shape = found.shapes[:, i] / np.linalg.norm(found.shapes[:, i])
        assert abs(np.vdot(shape, along)) == pytest.approx(1.0, abs=1e-9)


def boundary(k, w, dead):
    """Determinant of the ends of EI w⁗ + P w″ + ρA ẅ = 0, clamped at 0, free at L.

    k = P L²/EI and w = ρA ω² L⁴/EI; w″ = 0 at the tip, and w‴ + k w′ = 0 for a dead load, w‴ = 0
    for a follower.
    """
    root = np.sqrt(k**2 / 4 + w)
    a, b = np.sqrt(root + k / 2), np.sqrt(root - k / 2)
    sin, cos, sinh, cosh = np.sin(a), np.cos(a), np.sinh(b), np.cosh(b)
    kd = k if dead else 0.0
    # w = sin ax / a − sinh bx / b and cos ax − cosh bx are clamped at 0
    second = [-a * sin - b * sinh, -(a**2) * cos - b**2 * cosh]
    third = [-(a**2) * cos - b**2 * cosh, a**3 * sin - b**3 * sinh]
    first = [cos - cosh, -a * sin - b * sinh]
    return second[0] * (third[1] + kd * first[1]) - second[1] * (third[0] + kd * first[0])


def test_the_frequency_of_a_column_falls_to_zero_at_eulers_load_and_then_it_leaves():
    dynamics = slender()
    zero = np.zeros(dynamics.n)
    euler = np.pi**2 / 4

    def first(share):
        tip = np.array([0, 0, 0, -share * euler * EI / LENGTH**2, 0, 0])
        return complex_modes(dynamics, zero, tip=tip)

    free = first(0.0).values[0].imag
    for share in (0.3, 0.6, 0.9):
        w = brentq(lambda w, k=share * euler: boundary(k, w, True), 1e-6, 16.0)
        assert first(share).values[0].imag == pytest.approx(np.sqrt(w) * PACE, rel=1e-5)
    assert first(1 - 1e-6).values[0].imag < 2e-3 * free
    assert first(1 - 1e-6).growth < 1e-6 * free
    leaving = first(1.1)
    assert leaving.values[0].imag == 0.0 and leaving.growth > 0.2 * free


def becks_load():
    """Least P L²/EI at which the two lowest frequencies under a follower force meet."""

    def gap(k):
        # positive between its two lowest roots, and nowhere any more where these have met
        w = np.linspace(20.0, 400.0, 40001)
        return np.max(boundary(k, w, False))

    return brentq(gap, 15.0, 25.0, xtol=1e-9)


def test_a_follower_force_makes_a_cantilever_flutter_at_becks_load():
    expected = becks_load()
    assert expected == pytest.approx(20.05, abs=0.01)  # Beck's own number
    dynamics = slender()
    zero = np.zeros(dynamics.n)

    def growth(load):
        tip = np.array([0, 0, 0, -load * EI / LENGTH**2, 0, 0])
        return complex_modes(dynamics, zero, tip=tip, tip_follows=True).growth

    size = np.abs(modes(dynamics, zero)[0][0])
    assert growth(expected * 0.999) < 1e-5 * size
    assert growth(expected * 1.001) > 0.01 * size
    dead = complex_modes(dynamics, zero, tip=np.array([0, 0, 0, -5 * EI / LENGTH**2, 0, 0]))
    assert dead.growth > 0.0  # a dead force of a quarter of that buckles it


def test_internal_damping_lowers_the_flutter_load():
    """Ziegler's paradox: Beck's column with vanishing Kelvin–Voigt damping loses stability at
    10.94 EI/L² (Bolotin and Zhinzher 1969)."""
    dynamics = slender(material={"viscosity": 50.0})
    zero = np.zeros(dynamics.n)

    def growth(load):
        tip = np.array([0, 0, 0, -load * EI / LENGTH**2, 0, 0])
        return complex_modes(dynamics, zero, tip=tip, tip_follows=True).growth

    assert brentq(growth, 8.0, 15.0, xtol=1e-3) == pytest.approx(10.94, abs=0.02)


def test_a_mode_as_poses_has_the_shape_of_the_theory():
    dynamics = slender()
    zero = np.zeros(dynamics.n)
    found = complex_modes(dynamics, zero)
    s = np.linspace(0, LENGTH, 13)
    small = 1e-4
    moved = mode_poses(
        dynamics, zero, found.shapes[:, 1], s, amplitude=small, phases=[0.0, np.pi / 2, np.pi]
    )
    b = clamped_free_roots(2)[1] / LENGTH
    k = (np.sinh(b * LENGTH) - np.sin(b * LENGTH)) / (np.cosh(b * LENGTH) + np.cos(b * LENGTH))
    w = np.cosh(b * s) - np.cos(b * s) - k * (np.sinh(b * s) - np.sin(b * s))
    got = moved[0, :, 1]
    np.testing.assert_allclose(got / got[-1], w / w[-1], atol=2e-4)
    assert 0.1 * small < np.abs(got).max() / LENGTH < small
    np.testing.assert_allclose(moved[1, :, :3], np.outer(s, [1, 0, 0]), atol=1e-12)
    np.testing.assert_allclose(moved[2, :, 1], -got, atol=1e-10)
    # Re(φ e^{i phase}): what leads by a quarter is there a quarter earlier
    early = mode_poses(
        dynamics, zero, 1j * found.shapes[:, 1], s, amplitude=small, phases=[-0.5 * np.pi]
    )
    np.testing.assert_allclose(early[0], moved[0], atol=1e-12)


def test_modes_about_a_drooping_equilibrium_are_those_of_its_free_vibration():
    """A pendulum: a rigid body on a hinge, about its rest at the bottom, damped."""
    mass, arm, damping = 0.7, 0.4, 0.05
    document = rod_document(gravity=(0, 0, -9.81)) | {
        "bodies": [
            {"joint": "hinge", "kind": "revolute", "axis": [0, 1, 0], "damping": damping},
            {"joint": "arm", "kind": "fixed", "offset": {"position": [arm, 0, 0]}},
            {"rigid_body": "bob", "mass": mass},
        ],
        "numerics": {"step": 0.002},
    }
    dynamics = Dynamics(scene_of(document))
    q = equilibrium(dynamics, np.array([1.0]))
    assert q[0] == pytest.approx(np.pi / 2)
    found = complex_modes(dynamics, q).values
    inertia = mass * arm**2
    expected = np.roots([inertia, damping, mass * 9.81 * arm])
    np.testing.assert_allclose(found, expected[expected.imag > 0], rtol=1e-9)


def test_what_leaves_its_equilibrium_has_a_negative_frequency():
    """A pendulum that stands on its head: m a² θ̈ = m g a θ; hanging, the same swings."""
    mass, arm = 0.7, 0.4
    document = rod_document(gravity=(0, 0, -9.81)) | {
        "bodies": [
            {"joint": "hinge", "kind": "revolute", "axis": [0, 1, 0]},
            {"joint": "arm", "kind": "fixed", "offset": {"position": [arm, 0, 0]}},
            {"rigid_body": "bob", "mass": mass},
        ],
        "numerics": {"step": 0.002},
    }
    dynamics = Dynamics(scene_of(document))
    pace = np.sqrt(9.81 / arm)
    for angle, sign in ((0.5 * np.pi, 1.0), (-0.5 * np.pi, -1.0)):
        np.testing.assert_allclose(modes(dynamics, np.array([angle]))[0], [sign * pace])
    assert complex_modes(dynamics, np.array([-0.5 * np.pi])).growth == pytest.approx(pace)
