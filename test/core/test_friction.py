"""Coulomb friction along tendons: the capstan formula, the loss, the limits."""

import numpy as np
import pytest
from differences import central_difference
from scenes import ALL, random_state, rod_document, scene_of
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics.sampler import Sampler
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.core.simulation.simulation import LEDGER

LENGTH, TENSION, MU = 0.6, 10.0, 0.3


def arm(*tendons, **options):
    """Return the document of a clamped rod with tendons t0, t1, …"""
    document = rod_document(**options)
    document["actuators"] = [{"tendon": f"t{i}", "rod": "rod"} | t for i, t in enumerate(tendons)]
    return document


def stations(dynamics, actuator=0):
    """Return the arc lengths in m at which tensions are told."""
    model, chain = dynamics.model, dynamics.compiled.chain
    begin, end = model.tendon_ptr[actuator : actuator + 2]
    spans = np.array([chain.segments[k].span for k in model.tendon_seg[begin:end]])
    gauss = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
    return (spans[:, :1] + np.diff(spans, axis=1) * gauss).ravel()


def slipping(dynamics, q, speed):
    """Return rates (n,) at which the whole tendon slips towards the winch (speed > 0) or back."""
    zero = np.zeros(dynamics.n)
    unit = np.eye(dynamics.n)
    gradient = np.array([dynamics.ports(q, e)[1][0] for e in unit])
    rates = gradient / (gradient @ gradient) * speed
    assert dynamics.ports(q, rates)[1][0] == pytest.approx(speed)
    return rates + zero


@pytest.mark.parametrize("speed", [10.0, -10.0])
@pytest.mark.parametrize(("start", "end"), [(0.0, LENGTH), (0.1, 0.45)])
def test_around_an_arc_the_tension_falls_as_on_a_capstan(speed, start, end):
    """T(s) = T₀ exp(∓ μ κ s): of a rod bent to an arc, at every point of the tendon."""
    tendon = {"offset": [0.02, 0.0], "start": start, "end": end, "friction": MU}
    dynamics = Dynamics(scene_of(arm(tendon, strains=["bend_z"], order=0)))
    curvature = 4.0
    q = np.full(dynamics.n, curvature)
    v = slipping(dynamics, q, speed)
    along = stations(dynamics) - start
    expected = TENSION * np.exp(-np.sign(speed) * MU * curvature * along)
    found = dynamics.tensions(q, v, np.array([TENSION]), 0)
    # the last station slips slowly: what lies beyond it moves little
    np.testing.assert_allclose(found[:-1], expected[:-1], rtol=1e-5)
    np.testing.assert_allclose(found[-1], expected[-1], rtol=1e-3)
    assert abs(found[-1] / TENSION - 1) > 0.2


def test_a_helix_rubs_in_a_straight_rod_too():
    """Its direction turns by ω² r/√(1 + ω² r²) per arc length, whatever the rod does."""
    turns, radius = 2.0, 0.02
    tendon = {"helix": {"radius": radius, "turns": turns}, "friction": MU}
    dynamics = Dynamics(scene_of(arm(tendon, strains=["stretch", "torsion"], order=0)))
    q = np.zeros(dynamics.n)
    rate = 2 * np.pi * turns / LENGTH
    wrap = rate**2 * radius / np.hypot(1, rate * radius)
    found = dynamics.tensions(q, slipping(dynamics, q, 10.0), np.array([TENSION]), 0)
    expected = TENSION * np.exp(-MU * wrap * stations(dynamics))
    np.testing.assert_allclose(found[:-1], expected[:-1], rtol=1e-5)


def test_the_wrap_of_a_tendon_in_a_deformed_rod_is_the_angle_its_chords_turn_by():
    """Against the polygon of 2000 points of the tendon in the world, bent and twisted in space."""
    tendon = {"helix": {"radius": [0.02, 0.01], "angle": 0.4, "turns": 1.0}, "friction": MU}
    dynamics = Dynamics(scene_of(arm(tendon, order=2, nodes=60)))
    q, _, _ = random_state(dynamics, 3)
    q *= 0.5
    along = np.linspace(0.0, LENGTH, 2001)
    poses = Sampler(dynamics.compiled, q, along).poses()
    offset = dynamics.compiled.scene.actuators[0].stretches[0].offset(along)
    points = poses[:, :3] + Rotation.from_quat(poses[:, 3:]).apply(offset)
    chords = np.diff(points, axis=0)
    chords /= np.linalg.norm(chords, axis=1)[:, None]
    turned = np.linalg.norm(np.cross(chords[:-1], chords[1:]), axis=1)
    wrap = np.concatenate([[0.0], np.cumsum(turned)])
    found = dynamics.tensions(q, slipping(dynamics, q, 100.0), np.array([TENSION]), 0)
    # slip may turn around somewhere: only where it goes with the winch it is the plain formula
    measured = -np.log(found / TENSION) / MU
    expected = np.interp(stations(dynamics), 0.5 * (along[1:] + along[:-1]), wrap)
    part = slice(0, int(np.argmax(np.diff(measured) <= 0)) or None)
    assert expected[part].max() > 1.0
    np.testing.assert_allclose(measured[part], expected[part], rtol=5e-3, atol=5e-3)


@pytest.mark.parametrize("curvature", [3e-4, 1.5e-3, 6e-3])
def test_wraps_too_small_to_count_are_rounded_off_and_the_tangent_knows(curvature):
    """κ²/√(κ² + κ₀²) instead of κ, κ₀ = 1 mrad over the length: the force and its derivative."""
    tendon = {"offset": [0.02, 0.0]}
    rough, smooth = (
        Dynamics(scene_of(arm(tendon | rubs, strains=["bend_z"], order=1)))
        for rubs in ({"friction": MU}, {})
    )
    q, zero = np.array([curvature, 0.1 * curvature]), np.zeros(2)
    v = slipping(rough, q, 10.0)
    flat = np.array([curvature, 0.0])
    rounded = curvature**2 / np.hypot(curvature, 1e-3 / LENGTH)
    found = rough.tensions(flat, v, np.array([TENSION]), 0)
    expected = MU * rounded * stations(rough)
    np.testing.assert_allclose(np.log(TENSION / found)[:-1], expected[:-1], rtol=1e-3)

    def rubbing(x):
        loads = (v, zero, np.array([TENSION]))
        return rough.inverse_dynamics(x, *loads) - smooth.inverse_dynamics(x, *loads)

    exact = [d.tangents(q, v, zero, np.array([TENSION]))[0] for d in (rough, smooth)]
    quotient = central_difference(rubbing, q, np.full(2, 1e-2 * curvature))
    np.testing.assert_allclose(exact[0] - exact[1], quotient, atol=1e-4 * np.abs(quotient).max())


def test_slip_below_the_slip_speed_is_a_creep_and_rest_has_no_friction():
    """σ = u/√(u² + v₀²): the drop of tension is proportional to slow slip, and none at rest."""
    tendon = {"offset": [0.02, 0.0], "friction": MU, "slip_speed": 0.01}
    dynamics = Dynamics(scene_of(arm(tendon, strains=["bend_z"], order=0)))
    q = np.full(dynamics.n, 4.0)
    efforts = np.array([TENSION])

    def drop(speed):
        last = dynamics.tensions(q, slipping(dynamics, q, speed), efforts, 0)[-2]
        return np.log(TENSION / last)

    assert drop(1e-6) == pytest.approx(0.1 * drop(1e-5), rel=1e-6)
    assert drop(1e-5) == pytest.approx(1e-3 * drop(10.0), rel=0.5)  # mean slip is half the winch's
    assert drop(-1e-5) == pytest.approx(-drop(1e-5), rel=1e-9)
    np.testing.assert_array_equal(dynamics.tensions(q, 0 * q, efforts, 0), TENSION)


def test_an_equilibrium_does_not_know_friction():
    smooth, rough = (
        Dynamics(scene_of(arm({"offset": [0.02, 0.01]} | rubs, order=3)))
        for rubs in ({}, {"friction": MU})
    )
    shapes = [equilibrium(x, efforts=[TENSION]) for x in (smooth, rough)]
    np.testing.assert_allclose(*shapes, atol=1e-13)


def swing(friction, integrator="sdirk2", step=1e-3, parts=200):
    """Pull, release and pull again; return the simulation and dissipated energies on the way."""
    tendon = {"offset": [0.02, 0.0]} | ({} if friction is None else {"friction": friction})
    document = arm(tendon, strains=ALL[:4], order=2, gravity=(0, 0, -9.81),
                   numerics={"integrator": integrator, "step": step})  # fmt: skip
    simulation = Simulation(scene_of(document))
    lost = []
    for tension in (20.0, 5.0, 15.0):
        simulation.set_efforts([tension])
        for _ in range(10):
            simulation.advance(parts // 10)
            lost.append(simulation.ledger()[LEDGER.index("dissipated")])
    return simulation, np.array(lost)


def test_friction_only_ever_takes_energy_and_the_ledger_knows_how_much():
    """An elastic rod without viscosity: all that is lost is lost to the tendon."""
    simulation, lost = swing(0.4, "implicit_midpoint", 5e-4, 400)
    ledger = dict(zip(LEDGER, simulation.ledger(), strict=True))
    assert np.all(np.diff(lost) >= 0.0) and lost[-1] > 0.02 * ledger["actuator_work"] > 0.0
    assert abs(ledger["residual"]) < 0.02 * lost[-1]
    _, none = swing(None)
    assert np.all(none == 0.0)


def test_friction_fades_continuously_to_none():
    smooth, _ = swing(None)
    gaps = [np.abs(swing(mu)[0].q - smooth.q).max() for mu in (1e-3, 1e-6, 1e-9)]
    assert gaps[0] > 1e3 * gaps[2]
    np.testing.assert_allclose(gaps[1] / gaps[0], 1e-3, rtol=0.3)
    # no friction asked for is no friction at all: the same arrays, the same bits
    assert swing(0.0)[0].q.tobytes() == smooth.q.tobytes()


def test_a_pulled_and_a_released_arm_lag_behind_the_one_without_friction():
    """Hysteresis: quasi-statically, with friction the arm bends less on the way up, more down."""

    def bend(friction):
        tendon = {"offset": [0.02, 0.0], "friction": friction}
        if friction:
            tendon["slip_speed"] = 1e-4
        document = arm(tendon, strains=["bend_z"], order=4, material={"viscosity": 3e4},
                       numerics={"step": 2e-3})  # fmt: skip
        simulation = Simulation(scene_of(document))
        found = []
        for tension in [*np.linspace(0, 20, 40), *np.linspace(20, 8, 25)]:
            simulation.set_efforts([tension])
            simulation.advance(20)
            found.append(simulation.ports()[0][0])
        return found[24], found[-1]  # both near 12 N and 8 N

    (up, down), (up_smooth, down_smooth) = bend(0.5), bend(0.0)
    assert up < 0.97 * up_smooth and down > 1.02 * down_smooth
