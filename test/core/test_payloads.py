"""Payloads are attached and dropped while the arm moves."""

import pickle

import numpy as np
import pytest
from forests import forest_document, rod
from scenes import scene_of

from soft_sim_ros.core.analysis.modes import complex_modes
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import BadArgument, SceneError

SLACK = {"soft": {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1000.0, "viscosity": 3e3}}
LOAD = {"rigid_body": "load", "mass": 0.1, "inertia": [2e-5, 2e-5, 3e-5],
        "com": {"position": [0.01, 0.005, 0.0], "rpy": [0.2, 0.1, 0.0]}}  # fmt: skip
NUMERICS = {"step": 1e-3, "basis": {"order": 2}}


def arm(attached, *others, numerics=NUMERICS, bodies=(), **rest):
    load = LOAD if attached is None else LOAD | {"attached": attached}
    bodies = [*bodies, rod("rod", 0.3), load, *others]
    return scene_of(forest_document(bodies, materials=SLACK, numerics=numerics, **rest))


@pytest.mark.parametrize("integrator", ["sdirk2", "adaptive"])
@pytest.mark.parametrize("first", [False, True])
def test_an_arm_with_a_payload_moves_as_one_that_was_made_with_it(integrator, first):
    """To the bit, whether it has been there from the start or came at once."""
    numerics = NUMERICS | {"integrator": integrator}
    made, loaded = (
        Simulation(arm(None, numerics=numerics)),
        Simulation(arm(first, numerics=numerics)),
    )
    loaded.attach("load")
    for simulation in (made, loaded):
        simulation.advance(100)
    np.testing.assert_array_equal(loaded.q, made.q)
    np.testing.assert_array_equal(loaded.v, made.v)
    loaded.drop("load")
    bare = Simulation(arm(False, numerics=numerics))
    bare.set_state(made.q, made.v)
    for simulation in (bare, loaded):
        simulation.advance(100)
    np.testing.assert_allclose(loaded.q, bare.q, atol=1e-6 if integrator == "adaptive" else 1e-13)


def test_statics_and_modes_of_its_dynamics_are_those_with_the_payload():
    simulation = Simulation(arm(False))
    bare, made = Dynamics(arm(False)), Dynamics(arm(None))
    rest = equilibrium(made)
    simulation.attach("load")
    np.testing.assert_allclose(equilibrium(simulation.dynamics), rest, rtol=1e-9, atol=1e-12)
    first = [complex_modes(d, rest).frequencies[0] for d in (simulation.dynamics, made, bare)]
    assert first[0] == pytest.approx(first[1], rel=1e-12)
    assert first[2] > 1.3 * first[0]


def test_a_payload_that_moves_with_the_arm_brings_its_energy_and_no_jump():
    numerics = NUMERICS | {"integrator": "adaptive", "options": {"error": 1e-9}}
    simulation = Simulation(arm(False, numerics=numerics))
    simulation.advance(60)
    before = simulation.ledger()
    v = simulation.v.copy()
    simulation.attach("load")
    after = simulation.ledger()
    np.testing.assert_array_equal(simulation.v, v)
    tip = simulation.dynamics.tip_jacobian(simulation.q)[3:] @ v
    assert after[0] - before[0] == pytest.approx(0.5 * 0.1 * tip @ tip, rel=0.2)  # near the tip
    assert after[3:6] == pytest.approx(before[3:6]) and after[6] == pytest.approx(before[6])
    simulation.advance(60)
    simulation.drop("load")
    simulation.advance(60)
    assert abs(simulation.ledger()[6]) < 1e-6 * simulation.ledger()[0]


def test_a_payload_that_rested_is_caught_with_the_momentum_of_both():
    """A free rod, without weight: what moved alone moves on with the payload."""
    free = {"joint": "base", "kind": "free"}
    scene = arm(False, bodies=[free], gravity=[0, 0, 0])
    simulation = Simulation(scene)
    v = np.zeros(simulation.n_coordinates)
    v[2], v[3:6] = 1.5, [0.3, -0.2, 0.4]
    simulation.set_state(np.zeros(len(v)), v)
    momentum = (simulation.dynamics.mass_matrix(simulation.q) @ simulation.v)[:6].copy()
    energy = simulation.ledger()[0]
    simulation.attach("load", at_rest=True)
    caught = (simulation.dynamics.mass_matrix(simulation.q) @ simulation.v)[:6]
    np.testing.assert_allclose(caught, momentum, rtol=1e-12, atol=1e-15)
    # the speed of the tip where it is caught: an inelastic impact loses energy, all of it booked
    ledger = simulation.ledger()
    assert 0.0 < ledger[0] < energy and ledger[5] == pytest.approx(energy - ledger[0])
    assert abs(ledger[6]) < 1e-14


def test_a_rigid_payload_at_rest_is_caught_as_in_the_books():
    """Two masses on a rail: v = m₁ v₁/(m₁ + m₂), and the lost energy ½ μ v₁²."""
    bodies = [
        {"joint": "rail", "kind": "prismatic", "axis": [1, 0, 0]},
        {"rigid_body": "cart", "mass": 0.3},
        {"rigid_body": "parcel", "mass": 0.2, "attached": False},
    ]
    document = forest_document(bodies, numerics={"step": 1e-3}, gravity=[0, 0, 0])
    simulation = Simulation(scene_of(document))
    simulation.set_state([0.0], [2.0])
    simulation.attach("parcel", at_rest=True)
    assert simulation.v[0] == pytest.approx(1.2)
    assert simulation.ledger()[5] == pytest.approx(0.5 * (0.3 * 0.2 / 0.5) * 4.0)
    simulation.drop("parcel")
    assert simulation.v[0] == pytest.approx(1.2) and simulation.payloads == {"parcel": False}


def test_what_is_attached_is_part_of_the_state(tmp_path):
    simulation = Simulation(arm(False))
    simulation.advance(20)
    simulation.attach("load")
    simulation.advance(20)
    state = simulation.state()
    state.save(tmp_path / "state.npz")
    other = Simulation(simulation.compiled)
    other.restore(type(state).load(tmp_path / "state.npz"))
    assert other.payloads == {"load": True}
    third = pickle.loads(pickle.dumps(simulation))
    untouched = Simulation(simulation.compiled)
    for one in (simulation, other, third):
        one.advance(50)
    assert other.state() == simulation.state() == third.state()
    assert untouched.payloads == {"load": False}
    simulation.reset()
    assert simulation.payloads == {"load": False}


def test_what_is_no_payload_is_refused():
    simulation = Simulation(arm(False))
    with pytest.raises(BadArgument, match="one of the payloads load"):
        simulation.attach("rod")
    with pytest.raises(SceneError, match="attached"):
        arm("perhaps")
    with pytest.raises(BadArgument, match="none"):
        Simulation(arm(None)).drop("load")
