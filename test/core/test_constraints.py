"""Frames that are held at frames: mechanisms, order in time, energy, momentum, latches."""

import numpy as np
import pytest
from closed import SLACK, at, bar, four_bar, held_rod
from forests import place, rod
from scenes import scene_of

from soft_sim_ros.core.mechanics.scipy_adapter import FirstOrder
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import Diverged, NoSuchPlace, NotMet, SceneError


def two_links(angle, ground):
    """Return the angles of the second and third bar over the one before, by the law of cosines."""
    # from the end of the first bar to the pin, in the plane x, −z in which the bars turn
    joint = 0.3 * np.array([np.cos(angle), np.sin(angle)])
    way = ground - joint
    reach = float(np.linalg.norm(way))
    bend = np.arccos((reach**2 - 0.5**2 - 0.4**2) / (2.0 * 0.5 * 0.4))
    first = np.arctan2(way[1], way[0]) - np.arctan2(0.4 * np.sin(bend), 0.5 + 0.4 * np.cos(bend))
    return first - angle, bend


@pytest.mark.parametrize("kind", ["ball", "hinge"])
def test_a_four_bar_turns_as_the_law_of_cosines_says(kind):
    """A hinge says four things twice in a plane: that changes nothing."""
    simulation = Simulation(scene_of(four_bar(kind)))
    sums = np.cumsum(simulation.q)
    ground = sum(
        length * np.array([np.cos(a), np.sin(a)])
        for length, a in zip((0.3, 0.5, 0.4), sums, strict=True)
    )
    turned = 0.0
    for _ in range(10):
        before = simulation.q[0]
        simulation.advance(30)
        turned += abs(simulation.q[0] - before)
        second, third = two_links(simulation.q[0], ground)
        ways = simulation.q[1:] - [second, third]
        np.testing.assert_allclose((ways + np.pi) % (2.0 * np.pi) - np.pi, 0.0, atol=1e-9)
    assert turned > 0.5


@pytest.mark.parametrize(
    ("integrator", "order"), [("sdirk2", 2), ("implicit_midpoint", 2), ("sdirk3", 3)]
)
def test_constraints_leave_a_method_its_order(integrator, order):
    exact = {"newton_tolerance": 1e-13}
    best = Simulation(scene_of(four_bar(step=2.5e-4, integrator="sdirk4", **exact)))
    best.advance(1200)
    errors = []
    for step in (4e-3, 2e-3):
        simulation = Simulation(scene_of(four_bar(step=step, integrator=integrator, **exact)))
        simulation.advance(round(0.3 / step))
        errors.append(np.abs(simulation.q - best.q).max())
    assert errors[0] / errors[1] == pytest.approx(2.0**order, rel=0.1)


def test_the_adaptive_method_keeps_what_it_is_told_with_constraints():
    best = Simulation(scene_of(four_bar(step=2.5e-4, integrator="sdirk4", newton_tolerance=1e-13)))
    best.advance(1200)
    off = []
    for error in (1e-6, 1e-8):
        numerics = {"integrator": "adaptive", "options": {"error": error}, "step": 1e-2}
        simulation = Simulation(scene_of(four_bar(**numerics)))
        simulation.advance(30)
        off.append(np.abs(simulation.q - best.q).max())
        assert np.abs(gap(simulation)).max() < 1e-11
    assert off[0] < 1e-5
    assert off[1] < 1e-6


def gap(simulation):
    """Return how far all rows are from being met."""
    dynamics, rest = simulation.dynamics, np.zeros(simulation.n_coordinates)
    dynamics.residual(simulation.q, simulation.v, rest, dynamics.forcing())
    return dynamics.constraints.value


def test_frames_do_not_drift_apart():
    """1e5 steps; the arm is 1.2 m long."""
    simulation = Simulation(scene_of(four_bar(step=2e-3)))
    for _ in range(10):
        simulation.advance(10_000)
        assert np.abs(gap(simulation)).max() < 1e-11


def test_fixed_constraints_do_no_work():
    simulation = Simulation(scene_of(four_bar(step=1e-3, integrator="energy_midpoint")))
    for _ in range(5):
        simulation.advance(100)
        ledger = simulation.ledger()
        assert ledger[4] == 0.0  # work of loads
        assert abs(ledger[-1]) < 1e-6 * ledger[0]


def loop_document(**rest):
    """Return a free body with two rods that are welded to one another: a closed loop."""
    bodies = [
        {"joint": "free", "kind": "free"},
        {"rigid_body": "hub", "mass": 0.2, "inertia": [1e-4, 1e-4, 1e-4]},
        rod("left", 0.3, place("hub", position=[0.0, 0.05, 0.0])),
        rod("right", 0.3, place("hub", position=[0.0, -0.05, 0.0])),
    ]
    frames = [{"body": "left"}, {"body": "right", "offset": "here"}]
    return {
        "name": "loop",
        "gravity": [0.0, 0.0, -9.81],
        "materials": {"soft": SLACK | {"viscosity": 1e3}},
        "bodies": bodies,
        "constraints": [{"name": "bridge", "kind": "weld", "frames": frames}],
        "initial": {"velocities": {"free": [1.0, 0.3, -2.0, 0.2, 0.0, 1.0]}},
        "numerics": {"step": 1e-3, "basis": {"order": 1}},
    } | rest


def test_a_free_closed_loop_keeps_its_momentum():
    simulation = Simulation(scene_of(loop_document()))
    start = simulation.dynamics.momentum(simulation.q, simulation.v)
    simulation.advance(200)
    found = simulation.dynamics.momentum(simulation.q, simulation.v)
    mass = simulation.model.inertia[:, 0].sum()
    fallen = start[3:] + np.array([0.0, 0.0, -9.81 * 0.2 * mass])
    np.testing.assert_allclose(found[3:], fallen, atol=1e-9 * np.linalg.norm(fallen))
    assert np.abs(gap(simulation)).max() < 1e-10


def pendulum(**rest):
    pin = {"name": "latch", "kind": "ball", "frames": [{"body": "end_one"}], **rest}
    return four_bar(constraints=[pin]) | {
        "bodies": bar("one", 0.3),
        "initial": {"positions": {"hinge_one": -0.9}},
    }


def test_a_released_latch_lets_go_at_once():
    """Like a pendulum that nothing ever held, from the time of the release on."""
    scheduled = Simulation(scene_of(pendulum(end=0.1505)))
    by_hand, free = Simulation(scene_of(pendulum())), Simulation(scene_of(pendulum(end=-1.0)))
    by_hand.advance(150)
    assert by_hand.q[0] == pytest.approx(-0.9, abs=1e-12)
    state = by_hand.state()
    by_hand.release("latch")
    by_hand.advance(200)
    free.advance(200)
    np.testing.assert_allclose(by_hand.q, free.q, atol=1e-7)
    scheduled.advance(150)
    assert scheduled.q[0] == pytest.approx(-0.9, abs=1e-12)
    scheduled.advance(200)
    assert 1e-5 < abs(scheduled.q[0] - free.q[0]) < 0.05
    by_hand.restore(state)  # in which it is held
    by_hand.advance(10)
    assert by_hand.q[0] == pytest.approx(-0.9, abs=1e-12)
    with pytest.raises(NoSuchPlace, match="latch"):
        by_hand.release("letch")


def test_a_latch_that_catches_stops_a_bar_and_books_what_that_loses():
    simulation = Simulation(scene_of(pendulum(end=-1.0)))
    simulation.advance(150)
    with pytest.raises(NotMet, match="latch"):
        simulation.hold("latch")
    before = simulation.ledger()
    simulation.hold("latch", here=True)
    simulation.advance(50)
    after = simulation.ledger()
    assert np.abs(simulation.v).max() < 1e-9
    assert after[5] == pytest.approx(before[0], rel=1e-6)  # all kinetic energy, and no other
    assert abs(after[-1]) < 1e-9 + abs(before[-1])


def test_a_state_goes_on_with_the_same_bits():
    simulation = Simulation(scene_of(loop_document()))
    simulation.advance(20)
    state = simulation.state()
    simulation.advance(20)
    q = simulation.q.copy()
    other = Simulation(simulation.compiled, state)
    other.advance(20)
    assert np.array_equal(q, other.q)
    assert other.state() == simulation.state()


def test_what_contradicts_itself_is_named():
    constraints = [
        {"name": "one", "kind": "ball", "frames": [{"body": "end_three"}]},
        {"name": "two", "kind": "distance", "length": 0.75,
         "frames": [{"body": "end_three"}, {"world": {"position": [0, 0, 0]}}]},
    ]  # fmt: skip
    with pytest.raises(NotMet, match="two") as caught:
        Simulation(scene_of(four_bar(constraints=constraints)))
    assert caught.value.distance > 0.01


def test_a_gap_is_told_in_metres():
    with pytest.raises(NotMet, match=r"far.* 0\.1 m") as caught:
        Simulation(scene_of(held_rod([at("ball", [0.4, 0, 0])])))
    assert caught.value.distance == pytest.approx(0.1)


def test_a_constraint_made_where_frames_are_apart_stops_the_run():
    pin = {"name": "latch", "kind": "ball", "start": 0.05,
           "frames": [{"body": "end_one"}, {"world": {"position": [0.3, 0.0, 0.0]}}]}  # fmt: skip
    document = pendulum() | {"constraints": [pin]}
    simulation = Simulation(scene_of(document))
    with pytest.raises(Diverged, match="constraint"):
        simulation.advance(100)
    assert simulation.time == pytest.approx(0.05)


@pytest.mark.parametrize(
    "use",
    [
        lambda dynamics: FirstOrder(dynamics),
        lambda dynamics: dynamics.internal_wrench(np.zeros(dynamics.n)),
    ],
)
def test_forms_without_constraints_say_so(use):
    dynamics = Dynamics(scene_of(four_bar()))
    with pytest.raises(SceneError, match="constraints"):
        use(dynamics)


def test_what_drives_a_held_end_is_booked_as_work():
    """A rod's far end is carried across by a joint without any mass."""
    document = held_rod(
        [{"name": "far", "kind": "weld", "frames": [{"body": "rod"}, {"body": "hand"}]}]
    )
    hand = {"joint": "hand", "kind": "prismatic", "axis": [0, 0, 1], "parent": "base",
            "offset": {"position": [0.5, 0, 0]}, "driven": "0.03*(1 - cos(6*t))"}  # fmt: skip
    document["bodies"].append(hand)
    simulation = Simulation(scene_of(document))
    simulation.advance(200)
    kinetic, elastic, _, _, work, lost, residual = simulation.ledger()
    assert work > 1e-3
    assert work - lost == pytest.approx(kinetic + elastic, rel=1e-5)
    assert abs(residual) < 1e-5 * work
    far = simulation.dynamics.node_poses(simulation.q)[simulation.compiled.node_of("rod"), :3, 3]
    np.testing.assert_allclose(far, [0.5, 0.0, 0.03 * (1.0 - np.cos(1.2))], atol=1e-11)


def test_a_method_that_was_not_checked_with_constraints_is_refused():
    with pytest.raises(SceneError, match=r"numerics\.integrator"):
        Simulation(scene_of(four_bar(integrator="generalized_alpha")))


@pytest.mark.parametrize("integrator", ["sdirk2", "adaptive"])
@pytest.mark.parametrize("forces", [np.nan, 1e30])
def test_a_failed_attempt_leaves_no_forces_for_the_next_one(integrator, forces):
    """Multipliers that Newton's method has lost are no first guess of a shorter step."""
    lost, calm = (
        Simulation(scene_of(four_bar(step=2e-3, integrator=integrator))) for _ in range(2)
    )
    for simulation in (lost, calm):
        simulation.advance(20)
    lost._closed.multiplier[:] = forces
    for simulation in (lost, calm):
        simulation.advance(20)
    np.testing.assert_allclose(lost.q, calm.q, atol=1e-5)
    place = lost.reactions()["pin"].force - calm.reactions()["pin"].force
    assert np.abs(place).max() < 1e-3 * np.abs(calm.reactions()["pin"].force).max()
