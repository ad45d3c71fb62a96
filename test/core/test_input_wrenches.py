"""Wrenches that are commanded while the arm moves, at places of their own."""

import numpy as np
import pytest
from forests import forest_document, rod
from scenes import scene_of

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.bounds import Bounds
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import BadArgument, CommandError, SceneError

SLACK = {"soft": {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1000.0, "viscosity": 3e3}}
NUMERICS = {"step": 1e-3, "basis": {"order": 2}}
WRENCH = [0.001, 0.002, -0.003, 0.05, 0.1, -0.05]


def pushed(*loads, numerics=NUMERICS, **rest):
    bodies = [rod("rod", 0.3), {"rigid_body": "hand", "mass": 0.02}]
    document = forest_document(bodies, materials=SLACK, numerics=numerics, **rest)
    return scene_of(document | {"loads": list(loads)})


@pytest.mark.parametrize("frame", ["world", "body"])
@pytest.mark.parametrize("place", [{"body": "rod", "s": 0.12}, {"body": "hand"}])
@pytest.mark.parametrize(
    ("integrator", "apart"), [("sdirk2", 1e-12), ("generalized_alpha", 1e-12), ("adaptive", 1e-7)]
)
def test_it_is_a_load_of_the_scene_that_begins_when_it_is_given(frame, place, integrator, apart):
    numerics = NUMERICS | {"integrator": integrator}
    if integrator == "adaptive":  # its steps end at the start of a load, not at that of an input
        numerics |= {"options": {"error": 1e-10}}
    own = {"point": "push", "frame": frame, "moment": WRENCH[:3], "force": WRENCH[3:]} | place
    base = {"position": [0.1, 0.0, 0.2], "rpy": [0.4, 0.2, -0.3]}
    known = Simulation(pushed(own | {"schedule": {"start": 0.03}}, numerics=numerics, base=base))
    told = Simulation(
        pushed({"input": "push", "frame": frame} | place, numerics=numerics, base=base)
    )
    for simulation in (known, told):
        simulation.advance(30)
    told.set_wrench("push", WRENCH)
    for simulation in (known, told):
        simulation.advance(70)
    assert np.abs(known.q).max() > 0.05
    np.testing.assert_allclose(told.q, known.q, atol=apart)
    np.testing.assert_allclose(told.ledger(), known.ledger(), atol=apart)


def test_it_adds_to_a_load_at_the_same_place_and_ends_where_it_began():
    steady = {"point": "steady", "body": "rod", "s": 0.12, "force": [0, 0.05, 0]}
    both = Simulation(pushed(steady, {"input": "push", "body": "rod", "s": 0.12}))
    alone = Simulation(pushed(steady))
    twice = Simulation(pushed(steady | {"force": [0, 0.1, 0]}))
    both.set_wrench("push", [0, 0, 0, 0, 0.05, 0])
    for simulation in (both, alone, twice):
        simulation.advance(50)
    np.testing.assert_allclose(both.q, twice.q, atol=1e-13)
    both.set_wrench("push", np.zeros(6))
    both.set_state(alone.q, alone.v)
    alone.set_state(alone.q, alone.v)
    for simulation in (both, alone):
        simulation.advance(50)
    np.testing.assert_allclose(both.q, alone.q, atol=1e-13)


def test_each_has_its_limits_its_timeout_and_its_name():
    scene = pushed(
        {"input": "left", "body": "rod", "s": 0.1, "limits": {"force": 0.5}},
        {"input": "right", "body": "hand", "frame": "body"},
    )
    simulation = Simulation(scene)
    inputs = Inputs(simulation, 0.05, 0.02, Bounds.of_arm(scene, simulation.length))
    order = inputs.wrench([0, 0, 0, 3.0, 4.0, 0], of="left")
    assert order.clamped == ("force of 5 N cut to 0.5 N",)
    inputs.wrench([0, 0, 0, 0, 0, 0.1], frame=None, of="right")
    inputs.advance(30)
    push, follows, _ = simulation.live()
    np.testing.assert_allclose(push[0, 3:], [0.3, 0.4, 0.0])
    np.testing.assert_array_equal(follows, [0, 1])
    inputs.wrench([0, 0, 0, 0, 0, 0.1], frame=None, of="right")
    inputs.advance(45)  # the left one is stale, the right one is not
    push, *_ = simulation.live()
    assert not push[0].any() and push[1, 5] == 0.1
    assert [text for _, text in inputs.take_events()] == ["command_timeout: ~/external_wrench/left"]
    assert inputs.withdraw() == ["~/external_wrench/right"]
    assert not simulation.live().push.any()


def test_its_work_is_in_the_ledger():
    numerics = NUMERICS | {"integrator": "adaptive", "options": {"error": 1e-8}}
    simulation = Simulation(pushed({"input": "push", "body": "rod", "s": 0.2}, numerics=numerics))
    simulation.set_wrench("push", [0, 0, 0, 0, -0.3, 0])
    simulation.advance(100)
    kinetic, *_, work, lost, residual = simulation.ledger()
    assert work > 1e-3 and kinetic > 1e-4 and lost > 0.0
    assert abs(residual) < 1e-5 * work


def test_what_is_no_wrench_is_refused():
    simulation = Simulation(pushed({"input": "push", "body": "rod"}))
    with pytest.raises(BadArgument, match="one of the input loads push"):
        simulation.set_wrench("pull", np.zeros(6))
    with pytest.raises(BadArgument, match="'world' or 'body'"):
        simulation.set_wrench("push", np.zeros(6), "tip")
    with pytest.raises(BadArgument, match="wrench"):
        simulation.set_wrench("push", [np.nan, 0, 0, 0, 0, 0])
    inputs = Inputs(simulation, 0.0, 0.0)
    with pytest.raises(CommandError, match="no such wrench"):
        inputs.wrench(np.zeros(6), of="pull")
    with pytest.raises(CommandError, match=r"not finite: force\.x"):
        inputs.wrench([0, 0, 0, np.inf, 0, 0], of="push")
    with pytest.raises(SceneError, match="force"):
        pushed({"input": "push", "body": "rod", "force": [0, 0, 1]})
    with pytest.raises(SceneError, match="limits"):
        pushed({"input": "push", "body": "rod", "limits": {"force": -1.0}})
