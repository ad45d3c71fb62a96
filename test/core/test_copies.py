"""Copies and pickles are simulations of their own that go on with the same bits."""

import copy
import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from scenes import rod_document, scene_of, zoo_document

from soft_sim_ros.core.analysis.discrete_gradient import DiscreteGradient
from soft_sim_ros.core.backend.structs import Packed
from soft_sim_ros.core.mechanics.sampler import Sampler
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import NotCopied, OtherModel, StateError
from soft_sim_ros.scene import load_scene

WAYS = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda x: pickle.loads(pickle.dumps(x)),
}
ONE, TWO = 7, 25  # steps before and after


def bits(simulation):
    """Return everything that can be read off."""
    parts = (simulation.q, simulation.v, simulation.ledger(), *simulation.ports())
    rest = (simulation.time_ns, simulation.time_error, *simulation.statistics())
    return (*(part.tobytes() for part in parts), rest)


def drive(simulation, rng, steps):
    """Hold other efforts, push at the tip, go on."""
    low, high = np.array([a.limits for a in simulation.scene.actuators]).reshape(-1, 2).T
    low, high = np.clip(low, -0.2, 0.2), np.clip(high, -0.2, 0.2)
    simulation.set_efforts(rng.uniform(low, high))
    simulation.set_tip_wrench(0.01 * rng.normal(size=6), rng.choice(["world", "tip"]))
    simulation.advance(steps)


def go_on_alike(simulation):
    """Assert that all copies have the same state, go on with the same bits, and by themselves."""
    drive(simulation, np.random.default_rng(1), ONE)
    copies = {name: way(simulation) for name, way in WAYS.items()}
    now = bits(simulation)
    for name, other in copies.items():
        assert type(other) is type(simulation), name
        assert bits(other) == now, name
        assert not np.shares_memory(other.q, simulation.q), name
    drive(simulation, np.random.default_rng(2), TWO)
    then = bits(simulation)
    for name, other in copies.items():
        assert bits(other) == now, name  # the original moved alone
        drive(other, np.random.default_rng(2), TWO)
        assert bits(other) == then, name
    copies["copy"].reset()
    simulation.reset()
    assert bits(copies["copy"]) == bits(simulation)


@pytest.mark.parametrize(
    ("integrator", "options"),
    [("sdirk2", {}), ("sdirk3", {}), ("sdirk4", {}), ("implicit_midpoint", {}),
     ("generalized_alpha", {"rho": 0.7}), ("energy_midpoint", {}), ("adaptive", {"error": 1e-5})],
)  # fmt: skip
def test_a_copy_goes_on_with_the_same_bits_with_every_integrator(integrator, options):
    document = rod_document(
        strains=["bend_y", "bend_z"],
        order=2,
        gravity=(1.0, 2.0, -9.0),
        material={"viscosity": 300.0},
        numerics={"basis": {"order": 2}, "integrator": integrator, "options": options},
    )
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.0, 0.02]}]
    go_on_alike(Simulation(scene_of(document)))


# friction, commanded lengths, Maxwell branches, fibres, charts of rotation vectors, links, strings,
# companions of a tolerance aside: whatever has a memory
@pytest.mark.parametrize(
    "name",
    ["soft_arm", "tendon_arm", "winch_arm", "rubber_arm", "flying_body", "floating_frame",
     "catenary", "pneumatic_arm", "mixed_chain"],
)  # fmt: skip
def test_a_copy_of_a_packaged_scene_goes_on_with_the_same_bits(name):
    go_on_alike(Simulation(load_scene(name)))


def test_a_copy_has_the_memory_of_maxwell_branches():
    document = rod_document(
        strains=["bend_y"], order=2, gravity=(0, 0, -9.0),
        material={"viscosity": 30.0, "maxwell": {"ratio": 2.0, "time": 0.05}},
    )  # fmt: skip
    go_on_alike(Simulation(scene_of(document)))


def test_a_pickle_goes_on_in_another_process_with_the_same_bits(environment):
    simulation = Simulation(load_scene("soft_arm"))
    simulation.advance(ONE)
    code = (
        "import pickle, sys; s = pickle.load(sys.stdin.buffer); s.advance(25);"
        "sys.stdout.write((s.q.tobytes() + s.ledger().tobytes()).hex() + f' {s.time_ns}')"
    )
    command = [sys.executable, "-c", code]
    answer = subprocess.run(
        command, input=pickle.dumps(simulation), env=environment, capture_output=True, check=True
    )
    simulation.advance(25)
    expected = (simulation.q.tobytes() + simulation.ledger().tobytes()).hex()
    assert answer.stdout.decode() == f"{expected} {simulation.time_ns}"


def test_what_belongs_together_is_copied_together():
    simulation = Simulation(scene_of(zoo_document()))
    inputs, sampler = Inputs(simulation, 0.02, 0.05), simulation.sampler(4)
    inputs.command([0.1, 0.2, 5.0, 3.0])
    inputs.advance(20)  # in the middle of the ramp
    sampler.poses()
    for way in (WAYS["deepcopy"], WAYS["pickle"]):
        arm, orders, frames = way((simulation, inputs, sampler))
        assert orders.simulation is arm and arm is not simulation
        np.testing.assert_array_equal(frames.poses(), sampler.poses())
        before = sampler.poses().copy()
        orders.advance(30)
        assert np.abs(frames.poses() - before).max() > 1e-6  # it looks at the copy
        np.testing.assert_array_equal(sampler.poses(), before)
        alone = copy.deepcopy(simulation)
        twin = Inputs(alone, 0.02, 0.05)
        assert twin.simulation is alone
    inputs.advance(30)
    assert bits(arm) == bits(simulation)
    assert orders.take_events() == inputs.take_events()


def test_a_shallow_copy_of_inputs_or_a_sampler_is_of_the_same_arm():
    simulation = Simulation(scene_of(zoo_document()))
    inputs, sampler = Inputs(simulation, 0.0, 0.0), simulation.sampler(3)
    other, frames = copy.copy(inputs), copy.copy(sampler)
    other.take(other.effort_order([0.1, 0.2, 5.0, 3.0]))
    assert not inputs._held[:4].any()
    simulation.advance(5)
    np.testing.assert_array_equal(frames.poses(), sampler.poses())
    assert not np.shares_memory(frames.poses(), sampler.poses())
    one = sampler.poses().copy()
    snapshot = copy.deepcopy(Sampler(simulation.compiled, simulation.q, sampler.s))
    simulation.advance(5)
    assert np.abs(frames.poses() - one).max() > 1e-6
    np.testing.assert_array_equal(snapshot.poses(), one)


def test_copies_of_dynamics_have_scratch_of_their_own():
    dynamics = Simulation(scene_of(zoo_document())).dynamics
    q = 0.1 * np.random.default_rng(3).normal(size=dynamics.n) / dynamics.model.weight
    for way in WAYS.values():
        other = way(dynamics)
        zero = np.zeros(dynamics.n)
        dynamics.residual(q, zero, zero, dynamics.forcing())
        expected = dynamics.last_tangent((1.0, 0.0, 0.0))
        other.residual(zero, zero, zero, other.forcing())
        np.testing.assert_array_equal(dynamics.last_tangent((1.0, 0.0, 0.0)), expected)
        np.testing.assert_array_equal(other.mass_matrix(q), dynamics.mass_matrix(q))


def test_steps_of_a_discrete_gradient_can_be_copied_too():
    motion = DiscreteGradient(
        scene_of(rod_document(strains=["bend_y"], order=1, gravity=(0, 0, -1)))
    )
    motion.step(0.01)
    copies = [way(motion) for way in (WAYS["deepcopy"], WAYS["pickle"])]
    motion.step(0.01)
    for other in copies:
        other.step(0.01)
        assert other.q.tobytes() == motion.q.tobytes() and other.balance == motion.balance


def test_attributes_of_others_are_copied_with_it():
    simulation = Simulation(load_scene("soft_arm"))
    simulation.log = [1, 2]
    for name, way in WAYS.items():
        other = way(simulation)
        assert other.log == [1, 2]
        assert (other.log is simulation.log) == (name == "copy")


@pytest.mark.parametrize("way", WAYS)
def test_addresses_by_themselves_are_not_copied(way):
    simulation = Simulation(load_scene("soft_arm"))
    with pytest.raises(NotCopied, match="holds addresses; copy its Simulation"):
        WAYS[way](simulation._entry)
    with pytest.raises(NotCopied, match="holds addresses"):
        WAYS[way](Packed(simulation.model))


def test_a_pickle_whose_state_is_none_of_its_model_is_refused():
    simulation = Simulation(load_scene("soft_arm"))
    compiled, prune, start, state, rest = simulation.__getstate__()
    longer = replace(state, q=np.zeros(len(state.q) + 1))
    with pytest.raises(StateError, match="q is of shape"):
        object.__new__(Simulation).__setstate__((compiled, prune, start, longer, rest))
    other = Simulation(load_scene("tendon_arm")).state()
    with pytest.raises(OtherModel, match="'tendon_arm' does not fit the model of 'soft_arm'"):
        object.__new__(Simulation).__setstate__((compiled, prune, start, other, rest))
