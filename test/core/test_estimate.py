"""What the energy ledger knows about motion that the steps do not show, against closed forms."""

import numpy as np
import pytest
from scenes import SOFT, rod_document, rod_simulation, scene_of

from soft_sim_ros.core.accuracy.estimate import Balance, Estimated, hidden_motion
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import EnergyGained, Inaccurate

LENGTH, RADIUS, YOUNG = 0.6, 0.01, 1e6
PLANE = {"length": LENGTH, "radius": RADIUS, "strains": ["bend_z"], "order": 5}
INERTIA = 0.25 * np.pi * RADIUS**4
OMEGA = 1.875104**2 / LENGTH**2 * np.sqrt(YOUNG * INERTIA / (1000.0 * np.pi * RADIUS**2))


def test_all_hidden_the_reach_is_that_of_the_cantilevers_compliance():
    dynamics = rod_simulation(**PLANE).dynamics
    reach, decay = hidden_motion(dynamics, np.zeros(dynamics.n), 1e3)
    compliance = LENGTH**3 / (3.0 * YOUNG * INERTIA)
    assert reach == pytest.approx(np.sqrt(2.0 * compliance), rel=1e-9)
    assert decay == 0.0


def test_a_short_step_hides_nothing():
    dynamics = rod_simulation(**PLANE).dynamics
    assert hidden_motion(dynamics, np.zeros(dynamics.n), 1e-9) == (0.0, 0.0)


def test_hidden_without_the_slowest_mode_is_the_compliance_without_its_share():
    # the static share of mode 1 under a tip force is φ(L)²/ω² with ∫ρAφ² = 1, φ(L)² = 4/(ρAL)
    dynamics = rod_simulation(**PLANE).dynamics
    reach, _ = hidden_motion(dynamics, np.zeros(dynamics.n), 1.9 / OMEGA)
    line = 1000.0 * np.pi * RADIUS**2
    rest = LENGTH**3 / (3.0 * YOUNG * INERTIA) - 4.0 / (line * LENGTH * OMEGA**2)
    assert reach == pytest.approx(np.sqrt(2.0 * rest), rel=2e-3)


def test_the_decay_is_that_of_the_slowest_mode():
    # Kelvin–Voigt with retardation time τ: amplitude e^(−τω²t/2), energy e^(−τω²t)
    tau = 0.02 / OMEGA
    material = {"viscosity": tau * SOFT["shear_modulus"]}
    dynamics = rod_simulation(**PLANE, material=material).dynamics
    _, decay = hidden_motion(dynamics, np.zeros(dynamics.n), 1e3)
    assert decay == pytest.approx(tau * OMEGA**2, rel=1e-3)


def test_a_vibration_that_one_step_ends_is_what_the_estimate_says():
    bend = {"rod/s": {"bend_z": 0.05}}
    document = rod_document(**PLANE, initial={"strains": bend})
    document["numerics"] |= {"step": round(1e3 / OMEGA), "integrator": "sdirk2"}
    simulation = Simulation(scene_of(document))
    balance, sampler = Balance(simulation), simulation.sampler(2)
    amplitude = sampler.poses()[-1, 1]
    simulation.advance(20)
    balance.update()
    assert abs(sampler.poses()[-1, 1]) < 1e-3 * amplitude  # L-stable: gone
    # a pure moment's shape is not the one in which energy reaches furthest: √(4/3) of it
    assert balance.hidden == pytest.approx(np.sqrt(4.0 / 3.0) * amplitude, rel=1e-2)


def test_the_estimate_is_beyond_the_true_error_of_a_swing_and_near_it():
    document = rod_document(**PLANE, gravity=(0.0, -9.81, 0.0), material={"viscosity": 300.0})
    tips = {}
    for step in (0.01, 1e-4):
        simulation = Simulation(
            scene_of(document | {"numerics": document["numerics"] | {"step": step}})
        )
        pair, sampler, track = Estimated(simulation), simulation.sampler(2), []
        for _ in range(50):
            simulation.advance(round(0.01 / step))
            if step == 0.01:
                pair.follow(1)
                estimate = pair.error_rel
            track.append(sampler.poses()[-1, :3].copy())
        tips[step] = np.array(track)
    error = np.linalg.norm(tips[0.01] - tips[1e-4], axis=1).max() / LENGTH
    assert error < estimate < 10.0 * error


def test_beyond_the_limit_the_run_is_refused_at_its_time():
    document = rod_document(**PLANE, gravity=(0.0, -9.81, 0.0))
    document["numerics"] |= {"step": 0.1}
    simulation = Simulation(scene_of(document))
    pair = Estimated(simulation, 0.01)
    with pytest.raises(Inaccurate) as caught:
        for _ in range(100):
            simulation.advance(1)
            pair.follow(1)
    assert caught.value.time == simulation.time
    assert caught.value.estimate > 0.01


def test_energy_from_nowhere_is_refused(monkeypatch):
    simulation = rod_simulation(**PLANE, gravity=(0.0, -9.81, 0.0))
    pair = Estimated(simulation, 1e9)
    simulation.advance(10)
    ledger = simulation.ledger()
    ledger[0] += 1.0  # of kinetic energy that nothing has paid for
    ledger[-1] += 1.0
    monkeypatch.setattr(simulation, "ledger", lambda: ledger)
    with pytest.raises(EnergyGained):
        pair.follow(10)
