"""Tendons whose length is commanded: a unilateral spring of the tendon's own stiffness."""

import numpy as np
import pytest
from scenes import ALL, rod_document, scene_of

from soft_sim_ros.core.analysis.modes import modes
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.core.simulation.simulation import LEDGER

LENGTH, RADIUS, E = 0.6, 0.03, 1e6
AREA = np.pi * RADIUS**2
STIFF = 5e4  # EA of the tendons, N
WINCH = {"control": "length", "axial_stiffness": STIFF}


def arm(*tendons, **options):
    """Return the document of a clamped rod with tendons t0, t1, …"""
    document = rod_document(**options)
    document["actuators"] = [{"tendon": f"t{i}", "rod": "rod"} | t for i, t in enumerate(tendons)]
    return document


def dynamics_of(*tendons, **options):
    return Dynamics(scene_of(arm(*tendons, **options)))


PATHS = {
    "straight": {"offset": [0.02, 0.01]},
    "helical, mid-rod": {"helix": {"radius": 0.02, "turns": 0.8}, "start": 0.1, "end": 0.5},
}


@pytest.mark.parametrize("path", PATHS)
def test_the_length_that_a_tension_gives_gives_that_tension(path):
    """y(T) from tension control; commanding y + T ℓ₀/EA must find the same shape and tension."""
    tension = 12.0
    by_tension = dynamics_of(PATHS[path], gravity=(0, 0, -4.0), order=3)
    q = equilibrium(by_tension, efforts=[tension])
    position = by_tension.ports(q, 0 * q)[0][0]
    by_length = dynamics_of(PATHS[path] | WINCH, gravity=(0, 0, -4.0), order=3)
    command = [position + tension * by_length.model.tendon_rest[0] / STIFF]
    found = equilibrium(by_length, efforts=command)
    np.testing.assert_allclose(found, q, atol=1e-9 * np.abs(q).max())
    assert by_length.port_efforts(found, 0 * q, command)[0] == pytest.approx(tension, rel=1e-8)
    assert position > 1e-3


def test_a_stiff_tendon_prescribes_the_bending_angle():
    """Bending only: T = k (y − d θ) and EI θ/L = T d, so θ → y/d as k = EA/L → ∞."""
    d, command = 0.02, 0.01
    for stiffness in (1e2, 1e5, 1e9):
        winch = {"offset": [d, 0.0], "control": "length", "axial_stiffness": stiffness}
        dynamics = dynamics_of(winch, strains=["bend_z"], order=2)
        turn = dynamics.node_poses(equilibrium(dynamics, efforts=[command]))[-1]
        spring, beam = stiffness / LENGTH, E * np.pi * RADIUS**4 / 4 / LENGTH
        angle = command * d * spring / (beam + spring * d**2)
        assert np.arctan2(turn[1, 0], turn[0, 0]) == pytest.approx(angle, rel=1e-9)
    assert angle == pytest.approx(command / d, rel=1e-5)


def test_a_slack_tendon_does_nothing_at_all():
    winch, plain = {"offset": [0.02, 0.0]} | WINCH, {"offset": [0.02, 0.0]}
    options = {"gravity": (0, 0, -5.0), "material": {"viscosity": 200.0}}
    paid_out = Simulation(scene_of(arm(winch, **options)))
    paid_out.set_efforts([-0.05])
    without = Simulation(scene_of(arm(plain, **options)))
    for simulation in (paid_out, without):
        simulation.advance(50)
    assert paid_out.q.tobytes() == without.q.tobytes()
    assert paid_out.ports()[2][0] == 0.0
    np.testing.assert_allclose(paid_out.ledger(), without.ledger(), rtol=1e-9, atol=1e-15)


def test_of_two_antagonists_one_goes_slack_and_the_arm_bends_as_if_alone():
    pair = [{"offset": [0.02, 0.0]} | WINCH, {"offset": [-0.02, 0.0]} | WINCH]
    both, one = dynamics_of(*pair, strains=["bend_z"]), dynamics_of(pair[0], strains=["bend_z"])
    q = equilibrium(both, efforts=[0.008, -0.02])
    tensions = both.port_efforts(q, 0 * q, np.array([0.008, -0.02]))
    assert tensions[0] > 1.0 and tensions[1] == 0.0
    np.testing.assert_allclose(q, equilibrium(one, efforts=[0.008]), atol=1e-9)
    # pulled in on both sides they fight: the arm stays straight, both tensions are k times it
    q = equilibrium(both, efforts=[0.001, 0.001])
    np.testing.assert_allclose(
        both.port_efforts(q, 0 * q, np.array([0.001, 0.001])), 0.001 * STIFF / LENGTH, rtol=1e-9
    )
    assert np.abs(q).max() < 1e-9


def test_a_held_tendon_stiffens_the_arm_against_a_load():
    """An axial tendon in parallel with the rod: tip force F = (EA + EA_t) Δ/L beyond slackness."""
    dynamics = dynamics_of({"offset": [0.0, 0.0]} | WINCH, strains=["stretch"], order=1)
    pull = np.array([0, 0, 0, 20.0, 0, 0])
    stretched = [
        dynamics.node_poses(equilibrium(dynamics, efforts=[y], tip=sign * pull))[-1][0, 3] - LENGTH
        for y, sign in ((0.0, 1.0), (0.0, -1.0))
    ]
    assert stretched[0] == pytest.approx(20.0 * LENGTH / (E * AREA + STIFF), rel=1e-9)
    assert stretched[1] == pytest.approx(-20.0 * LENGTH / (E * AREA), rel=1e-9)  # slack


def heavy_tip(**winch):
    """Return the document of a rod that only stretches, a tendon along it, 50 kg at its end."""
    document = arm(
        {"offset": [0.0, 0.0]} | WINCH | winch, strains=["stretch"], order=0,
        material={"density": 1.0}, numerics={"basis": {"order": 0}, "step": 2e-4,
                                             "integrator": "sdirk4"},
    )  # fmt: skip
    document["bodies"].append({"rigid_body": "mass", "mass": 50.0})
    return document


def test_a_mass_on_rod_and_tendon_swings_at_the_frequency_of_both_springs():
    dynamics = Dynamics(scene_of(heavy_tip()))
    q = equilibrium(dynamics, efforts=[0.002])
    omega = np.sqrt((E * AREA + STIFF) / LENGTH / 50.0)
    simulation = Simulation(scene_of(heavy_tip()))
    simulation.set_efforts([0.002])
    simulation.set_state(q * 1.01, 0 * q)
    half = np.pi / omega
    simulation.advance(round(half / 2e-4))
    # after half a period it is on the other side of the equilibrium
    assert simulation.q[0] - q[0] == pytest.approx(-0.01 * q[0], rel=1e-3)
    found = modes(dynamics, q, np.array([0.002]))[0][0]
    assert found == pytest.approx(omega, rel=1e-4)
    slack = modes(dynamics, q, np.array([-0.1]))[0][0]
    assert slack == pytest.approx(np.sqrt(E * AREA / LENGTH / 50.0), rel=1e-4)


def test_axial_damping_lets_it_decay_as_a_dashpot_does():
    """Amplitude after one period: exp(−c/(2 m) · period), c = axial damping / ℓ₀."""
    damping = 600.0
    document = heavy_tip(axial_damping=damping)
    dynamics = Dynamics(scene_of(document))
    q = equilibrium(dynamics, efforts=[0.002])
    simulation = Simulation(scene_of(document))
    simulation.set_efforts([0.002])
    simulation.set_state(q * 1.01, 0 * q)
    rest = damping / LENGTH / (2 * 50.0)
    omega = np.sqrt((E * AREA + STIFF) / LENGTH / 50.0 - rest**2)
    period = 2 * np.pi / omega
    simulation.advance(round(period / 2e-4))
    left = (simulation.q[0] - q[0]) / (0.01 * q[0])
    assert left == pytest.approx(np.exp(-rest * period), rel=2e-3)
    ledger = dict(zip(LEDGER, simulation.ledger(), strict=True))
    stored = 0.5 * (E * AREA + STIFF) / LENGTH * (0.01 * q[0] * LENGTH) ** 2
    assert ledger["dissipated"] == pytest.approx(stored * (1 - left**2), rel=5e-3)


def test_the_work_of_a_winch_is_in_the_ledger_step_by_step():
    """Jumps of the command do the work by which the stored energy jumps; holding does none."""
    winch = {"offset": [0.02, 0.0], "axial_damping": 5.0} | WINCH | {"axial_stiffness": 500.0}
    document = arm(winch, winch | {"offset": [-0.01, 0.015]}, strains=ALL[:4], order=2,
                   material={"viscosity": 300.0}, gravity=(0, 0, -9.81),
                   numerics={"integrator": "implicit_midpoint", "step": 5e-4})  # fmt: skip
    simulation = Simulation(scene_of(document))
    rng = np.random.default_rng(3)
    work, held = 0.0, np.zeros(2)
    taut = np.zeros(2)
    for _ in range(12):
        command = rng.uniform(-0.004, 0.012, 2)
        stretch = [np.maximum(0.0, command - simulation.ports()[0]) for command in (held, command)]
        stiffness = 500.0 / simulation.model.tendon_rest
        work += 0.5 * stiffness @ (stretch[1] ** 2 - stretch[0] ** 2)
        simulation.set_efforts(command)
        simulation.advance(60)
        held = command
        taut += simulation.ports()[2] > 0.0
    ledger = dict(zip(LEDGER, simulation.ledger(), strict=True))
    assert ledger["actuator_work"] == pytest.approx(work, rel=1e-9)
    assert np.all((taut > 0) & (taut < 12))  # both were taut, and slack
    assert abs(ledger["residual"]) < 5e-3 * ledger["dissipated"]


@pytest.mark.parametrize("integrator", ["sdirk2", "implicit_midpoint", "generalized_alpha"])
def test_a_rope_of_steel_on_a_soft_arm_needs_no_smaller_step(integrator):
    """EA = 2·10⁵ N on an arm of 2800 N, a jump of 1 cm, default step: the length is reached."""
    winch = {"offset": [0.02, 0.0], "control": "length", "axial_stiffness": 2e5}
    document = arm(winch, strains=ALL[:4], order=3, material={"viscosity": 2000.0},
                   numerics={"integrator": integrator})  # fmt: skip
    simulation = Simulation(scene_of(document))
    simulation.set_efforts([0.01])
    simulation.advance(1500)
    assert simulation.statistics().refused == 0
    position, _, tension = simulation.ports()
    assert position[0] + tension[0] * LENGTH / 2e5 == pytest.approx(0.01, rel=1e-5)
    assert tension[0] > 3.0


def test_a_small_command_of_a_winch_pulls_a_taut_tendon_and_not_a_slack_one():
    """Force per command: EA/ℓ₀ times the gradient of what is pulled in, and none 1 mm from taut."""
    pair = [{"offset": [0.02, 0.0]} | WINCH, {"offset": [-0.02, 0.0]} | WINCH]
    dynamics = dynamics_of(*pair, strains=["bend_z"])
    q = np.zeros(dynamics.n)
    gradient = np.array([dynamics.ports(q, unit)[1] for unit in np.eye(dynamics.n)])
    found = dynamics.effort_matrix(q, np.array([1e-3, -1e-3]))
    np.testing.assert_allclose(found[:, 0], STIFF / LENGTH * gradient[:, 0], rtol=1e-6, atol=1e-9)
    assert np.abs(found[:, 0]).max() > 1.0 and not found[:, 1].any()
