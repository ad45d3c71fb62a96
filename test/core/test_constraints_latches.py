"""Latches: what is made and released while the arm moves; what constraints say twice."""

import numpy as np
import pytest
from closed import SLACK, at, bar, four_bar, held_rod
from scenes import scene_of

from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import Diverged, NotMet

METHODS = ("sdirk2", "adaptive", "implicit_midpoint")


def swinging(constraints, **numerics):
    """Return a bar that swings from an angle."""
    return four_bar(constraints=constraints, **numerics) | {
        "bodies": bar("one", 0.3),
        "initial": {"positions": {"hinge_one": -0.9}},
    }


def caught(**rest):
    return {"name": "latch", "kind": "ball", "frames": [{"body": "end_one"}], **rest}


@pytest.mark.parametrize("integrator", METHODS)
@pytest.mark.parametrize("start", [0.15, 0.1505])
def test_what_a_latch_stops_is_booked_whatever_the_method(integrator, start):
    """All kinetic energy is lost, on the grid of steps or between two."""
    numerics = {"integrator": integrator, "step": 1e-3}
    if integrator == "adaptive":
        numerics["options"] = {"error": 1e-7}
    simulation = Simulation(scene_of(swinging([caught(start=start)], **numerics)))
    free = Simulation(scene_of(swinging([caught(start=9.0)], integrator="sdirk4", step=5e-4)))
    free.advance(round(start / 5e-4))
    simulation.advance(200)
    assert np.abs(simulation.v).max() < 1e-9
    ledger = simulation.ledger()
    assert ledger[5] == pytest.approx(free.ledger()[0], rel=1e-5)
    assert abs(ledger[-1]) < 1e-5 * ledger[5]
    assert simulation.q[0] == pytest.approx(free.q[0], abs=1e-5)


@pytest.mark.parametrize("integrator", METHODS)
def test_what_a_drive_gives_to_stop_at_a_latch_is_booked(integrator):
    """A rod at rest is caught by a plate that a drive keeps going: the plate loses no speed."""
    frames = [{"body": "rod"}, {"body": "hand", "offset": "here"}]
    latch = {"name": "far", "kind": "ball", "frames": frames, "start": 0.0305}
    numerics = {"step": 1e-3, "basis": {"order": 3}, "integrator": integrator}
    document = held_rod([latch], numerics=numerics)
    hand = {"joint": "hand", "kind": "prismatic", "axis": [0, 0, 1], "parent": "base",
            "offset": {"position": [0.5, 0, 0]}, "driven": "0.5*t"}  # fmt: skip
    document["bodies"] += [hand, {"rigid_body": "plate", "mass": 0.05, "inertia": [1e-5] * 3}]
    simulation = Simulation(scene_of(document))
    simulation.advance(32)
    kinetic, elastic, _, _, work, lost, residual = simulation.ledger()
    start = 0.5 * 0.05 * 0.5**2
    # the rod takes m* w² / 2 with the speed w, and as much is lost while it is brought there
    assert lost > 0.05 * start
    assert work > 2.0 * lost - 1e-9
    assert work == pytest.approx(kinetic + elastic - start + lost, rel=0.01)
    assert abs(residual) < 0.01 * lost


def test_the_adaptive_method_hits_what_is_made_and_released():
    """A bar that is held from 0.0505 s to 0.1013 s, against small steps of another method."""
    latch = [caught(start=0.0505, end=0.1013)]
    best = Simulation(scene_of(swinging(latch, integrator="sdirk4", step=1e-4)))
    best.advance(3000)
    off = []
    for error in (1e-5, 1e-7):
        numerics = {"integrator": "adaptive", "options": {"error": error}, "step": 1e-2}
        simulation = Simulation(scene_of(swinging(latch, **numerics)))
        simulation.advance(8)
        assert np.abs(simulation.v).max() < 1e-9
        simulation.advance(22)
        off.append(np.abs(simulation.q - best.q).max())
    assert off[0] < 1e-4
    assert off[1] < 1e-6


@pytest.mark.parametrize("integrator", ["sdirk2", "adaptive"])
def test_a_run_with_latches_is_the_same_whenever_it_is_looked_at(integrator):
    """In one call or in many, and from a state that was kept in the middle."""
    latch = [caught(start=0.0505, end=0.1013)]
    scene = scene_of(swinging(latch, integrator=integrator, step=1e-3))
    whole, parts = Simulation(scene), Simulation(scene)
    whole.advance(60)
    whole.release("latch")
    whole.advance(20)
    whole.hold("latch", here=True)
    whole.advance(20)
    for _ in range(6):
        parts.advance(10)
    parts = Simulation(parts.compiled, parts.state())
    parts.release("latch")
    parts.advance(20)
    parts.hold("latch", here=True)
    parts.advance(10)
    parts = Simulation(parts.compiled, parts.state())
    parts.advance(10)
    assert np.array_equal(whole.q, parts.q)
    assert np.array_equal(whole.v, parts.v)
    assert whole.state() == parts.state()


def test_rows_that_others_imply_are_named_with_those_others():
    """A pin of a planar loop says what hinges say, and a second pin what the first one said."""
    hinge = {"name": "pin", "kind": "hinge", "axis": [0, 1, 0], "frames": [{"body": "end_three"}]}
    again = hinge | {"name": "again", "kind": "ball"}
    again.pop("axis")
    dynamics = Dynamics(scene_of(four_bar(constraints=[hinge, again])))
    q = Simulation(dynamics.compiled).q
    found = dynamics.redundant_constraints(q)
    assert found["pin"] == (3, 5, ())
    assert found["again"] == (3, 3, ("pin",))
    assert "3 of 5 rows" in found["pin"].words()
    assert "joints" in found["pin"].words()
    assert "pin" in found["again"].words()


def test_what_is_held_once_is_not_called_redundant():
    dynamics = Dynamics(scene_of(held_rod([at("weld", [0.5, 0, 0])])))
    assert dynamics.redundant_constraints(np.zeros(dynamics.n)) == {}


def test_a_contradiction_names_both_sides_and_how_far_they_are_apart():
    one = {"name": "one", "kind": "ball", "frames": [{"body": "end_three"}]}
    two = {"name": "two", "kind": "distance", "length": 0.75,
           "frames": [{"body": "end_three"}, {"world": {"position": [0, 0, 0]}}]}  # fmt: skip
    simulation = Simulation(scene_of(four_bar(constraints=[one])))
    place = simulation.dynamics.node_poses(simulation.q)[-1, :3, 3]
    two["length"] = float(np.linalg.norm(place)) + 2e-4  # near enough to be tried
    with pytest.raises(NotMet, match=r"two.*one|one.*two") as found:
        Simulation(scene_of(four_bar(constraints=[one, two])))
    assert 1e-5 < found.value.distance < 3e-4


def test_a_run_that_ends_at_a_constraint_names_it_with_numbers():
    """A bar's end on a carriage that is driven out of its reach."""
    under = {"position": [0.3 * float(np.cos(0.9)), 0.0, 0.0]}
    carriage = {"joint": "carriage", "kind": "prismatic", "axis": [1, 0, 0], "parent": "base",
                "offset": under, "driven": "0.5*t"}  # fmt: skip
    frames = [{"body": "end_one"}, {"body": "carriage"}]
    far = {"name": "far", "kind": "plane", "axis": [1, 0, 0], "frames": frames}
    document = four_bar(constraints=[far]) | {
        "bodies": [*bar("one", 0.3), carriage],
        "initial": {"positions": {"hinge_one": 0.9}},
    }
    simulation = Simulation(scene_of(document))
    with pytest.raises(Diverged, match=r"'far'.* m and") as found:
        simulation.advance(1000)
    assert "constraint" in str(found.value)
    assert 0.3 * np.cos(0.9) + 0.5 * simulation.time == pytest.approx(0.3, abs=2e-3)


def test_who_writes_no_numerics_gets_the_accuracy_promised_with_constraints():
    """The contract chooses, and a much finer model agrees."""
    document = held_rod(
        [at("ball", [0.42, 0.0, 0.0])],
        gravity=[0, 0, -9.81],
        materials={"soft": SLACK | {"viscosity": 5e3}},
        rod={"strains": ["bend_y", "stretch"]},
        initial={"state": "equilibrium", "strains": {"rod/s": {"bend_y": -1.0}}},
    )
    document["constraints"][0]["end"] = 0.05
    free = dict(document)
    free.pop("numerics")
    fine = document | {"numerics": {"step": 5e-4, "integrator": "sdirk4",
                                    "basis": {"order": 6, "elements": 3}}}  # fmt: skip
    tips = []
    for given in (free, fine):
        simulation = Simulation(scene_of(given))
        simulation.advance(round(0.3e9 / simulation.step_ns))
        tips.append(simulation.dynamics.node_poses(simulation.q)[-1, :3, 3])
        assert simulation.time == pytest.approx(0.3)
    assert np.linalg.norm(tips[0] - tips[1]) < 1e-3 * 0.5
