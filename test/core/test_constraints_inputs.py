"""Held ends feel what is commanded while the arm moves."""

import numpy as np
import pytest
from closed import SLACK, held_rod
from scenes import scene_of

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import BadArgument

FAR = {"name": "far", "kind": "weld", "frames": [{"body": "rod"}]}
DAMPED = {"materials": {"soft": SLACK | {"viscosity": 3e4}}}


@pytest.mark.parametrize("integrator", ["sdirk2", "adaptive"])
def test_the_reaction_to_a_commanded_wrench_is_that_to_the_same_load(integrator):
    numerics = {"step": 1e-3, "basis": {"order": 5, "elements": 2}, "integrator": integrator}
    push = [0.0, 0.0, 1e-4, 0.0, 0.02, 0.01]  # so little that the rod is not stretched
    point = {"point": "push", "body": "rod", "s": 0.2, "moment": push[:3], "force": push[3:]}
    given = {"input": "push", "body": "rod", "s": 0.2}
    found = []
    for load in (point, given):
        document = held_rod([FAR], numerics=numerics, **DAMPED) | {"loads": [load]}
        simulation = Simulation(scene_of(document))
        if load is given:
            simulation.set_wrench("push", push)
        simulation.advance(1500)
        found.append((simulation.q.copy(), simulation.reactions()["far"]))
    (q, known), (p, told) = found
    np.testing.assert_allclose(p, q, atol=1e-6 * np.abs(q).max())
    np.testing.assert_allclose(told.force, known.force, atol=1e-8)
    np.testing.assert_allclose(told.moment, known.moment, atol=1e-9)
    # of a clamped beam at rest that is pushed at a of L: F a² (3 L − 2 a)/L³ at the far end, and
    # the moment M adds 6 M a (L − a)/L³ to it
    a, length = 0.2, 0.5
    share = a**2 * (3.0 * length - 2.0 * a) / length**3
    turn = 6.0 * push[2] * a * (length - a) / length**3
    assert -known.force[1] == pytest.approx(push[4] * share + turn, rel=0.02)
    assert -known.force[2] == pytest.approx(push[5] * share, rel=0.02)


def test_a_held_end_goes_where_the_joint_that_carries_it_is_commanded():
    frames = [{"body": "rod"}, {"body": "hand"}]
    document = held_rod([{"name": "far", "kind": "weld", "frames": frames}], **DAMPED)
    hand = {"joint": "hand", "kind": "prismatic", "axis": [0, 0, 1], "parent": "base",
            "offset": {"position": [0.5, 0, 0]}, "driven": {"within": 0.1}}  # fmt: skip
    document["bodies"].append(hand)
    simulation = Simulation(scene_of(document))
    simulation.set_driven("hand", 0.05)
    simulation.advance(150)
    far = simulation.dynamics.node_poses(simulation.q)[simulation.compiled.node_of("rod"), :3, 3]
    np.testing.assert_allclose(far, [0.5, 0.0, 0.05], atol=1e-11)
    # what the drive gives is what holds the end, as the joint has no mass: to the error of a step
    reaction = simulation.reactions()["far"]
    assert simulation.driven()[2][0] == pytest.approx(reaction.force[2], rel=1e-3)
    assert abs(simulation.ledger()[6]) < 1e-4 * simulation.ledger()[4]


def test_a_payload_that_rested_is_not_caught_by_an_arm_with_constraints():
    document = held_rod([FAR])
    document["bodies"].append({"rigid_body": "load", "mass": 0.1, "attached": False})
    simulation = Simulation(scene_of(document))
    with pytest.raises(BadArgument, match="at_rest"):
        simulation.attach("load", at_rest=True)
    simulation.attach("load")
    simulation.advance(5)
    assert simulation.payloads == {"load": True}
