"""Driven joints that follow commands while the arm moves."""

import pickle

import numpy as np
import pytest
from forests import forest_document, rod
from scenes import scene_of

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import BadArgument, CommandError, SceneError

SLACK = {"soft": {"young_modulus": 1e6, "poisson_ratio": 0.5, "density": 1000.0, "viscosity": 3e3}}
NUMERICS = {"step": 1e-3, "basis": {"order": 2}}


def carried(driven, kind="prismatic", **rest):
    joint = {"joint": "rail", "kind": kind, "driven": driven}
    joint |= {"axis": [0, 1, 0]} if kind in ("prismatic", "revolute") else {}
    options = {"materials": SLACK, "numerics": NUMERICS} | rest
    return scene_of(forest_document([joint, rod("rod", 0.3)], **options))


def way(end, lasts, now=(0.0, 0.0, 0.0)):
    """The polynomial of fifth degree between two states of position, rate and acceleration."""
    rows, right = [], []
    for t, state in ((0.0, now), (lasts, end)):
        for d in range(3):
            row = [
                float(np.prod(np.arange(k, k - d, -1))) * t ** (k - d) if k >= d else 0.0
                for k in range(6)
            ]
            rows.append(row)
            right.append(state[d])
    return np.polynomial.Polynomial(np.linalg.solve(rows, right))


def recorded(simulation, steps):
    states = []
    for _ in range(steps):
        simulation.advance(1)
        states.append((simulation.q[0], simulation.v[0]))
    return np.array(states).T


@pytest.mark.parametrize("integrator", ["sdirk2", "adaptive"])
def test_it_reaches_what_it_is_told_smoothly_from_however_it_moves(integrator):
    simulation = Simulation(
        carried({"within": 0.1, "start": 0.02}, numerics=NUMERICS | {"integrator": integrator})
    )
    assert simulation.q[0] == 0.02
    simulation.advance(5)
    simulation.set_driven("rail", 0.1)
    first = way((0.1, 0.0, 0.0), 0.1, (0.02, 0.0, 0.0))
    q, v = recorded(simulation, 60)
    times = 1e-3 * np.arange(1, 61)
    np.testing.assert_allclose(q, first(times), atol=1e-14)
    np.testing.assert_allclose(v, first.deriv()(times), atol=1e-12)
    # on its way it is told something else
    now = [first.deriv(d)(0.06) if d else first(0.06) for d in range(3)]
    simulation.set_driven("rail", -0.05, 0.3, within=0.2)
    second = way((-0.05, 0.3, 0.0), 0.2, now)
    q, v = recorded(simulation, 300)
    times = 1e-3 * np.arange(1, 201)
    np.testing.assert_allclose(q[:200], second(times), atol=1e-13)
    np.testing.assert_allclose(v[:200], second.deriv()(times), atol=1e-11)
    # from there its rate stays
    np.testing.assert_allclose(q[200:], -0.05 + 0.3 * 1e-3 * np.arange(1, 101), atol=1e-13)


def test_a_rate_alone_is_reached_without_a_jump_of_the_acceleration():
    simulation = Simulation(carried({"within": 0.1}))
    simulation.set_driven("rail", velocity=0.4)
    q, v = recorded(simulation, 150)
    rates = np.diff(np.concatenate([[0.0], v])) / 1e-3
    assert v[99:] == pytest.approx(0.4) and abs(rates[0]) < 0.2
    # r (3 x² − 2 x³) of x = t/0.1 s: its jerk is 6 r/0.1² at most
    assert np.abs(np.diff(rates)).max() <= 6.0 * 0.4 / 0.1**2 * 1e-3
    # the way is half of what the rate would have made at once, as the ramp is symmetric
    assert q[99] == pytest.approx(0.5 * 0.4 * 0.1)


def test_the_arm_feels_a_command_as_it_feels_the_same_motion_by_formula():
    formula = "0.05*(10*(t/0.2)**3 - 15*(t/0.2)**4 + 6*(t/0.2)**5)"
    told, known = Simulation(carried({"within": 0.2})), Simulation(carried(formula))
    told.set_driven("rail", 0.05)
    for _ in range(4):
        told.advance(50)
        known.advance(50)
        np.testing.assert_allclose(told.q, known.q, atol=1e-12)
        np.testing.assert_allclose(
            told.driven()[2],
            known.dynamics.drive_forces(known.q, known.v, time=known.time),
            rtol=1e-9,
        )
    assert told.ledger()[4] == pytest.approx(known.ledger()[4], rel=1e-9)


def test_the_force_of_a_drive_is_the_rate_of_momentum():
    """Free of weight and of damping, what is given to the rail is what the arm gains."""
    scene = carried({"within": 0.2}, gravity=[0, 0, 0])
    simulation = Simulation(scene)
    simulation.set_driven("rail", 0.05)
    simulation.advance(60)

    def momentum():
        dynamics = simulation.dynamics
        return (dynamics.mass_matrix(simulation.q) @ simulation.v)[0]

    simulation.advance(1)
    before = momentum()
    simulation.advance(1)
    force = simulation.driven()[2][0]
    simulation.advance(1)
    assert force == pytest.approx((momentum() - before) / 2e-3, rel=1e-3)


def test_a_state_saved_on_the_way_goes_on_with_the_same_bits(tmp_path):
    simulation = Simulation(carried({"within": 0.1}))
    simulation.set_driven("rail", 0.1, 0.2)
    simulation.advance(40)
    state = simulation.state()
    state.save(tmp_path / "state.npz")
    twins = [pickle.loads(pickle.dumps(simulation)), Simulation(simulation.compiled)]
    twins[1].restore(type(state).load(tmp_path / "state.npz"))
    for one in (simulation, *twins):
        one.advance(200)
    for twin in twins:
        assert twin.state() == simulation.state()
    simulation.reset()
    assert simulation.q[0] == 0.0 and simulation.v[0] == 0.0


def test_a_rate_that_nobody_renews_ends_and_a_position_is_held():
    simulation = Simulation(carried({"within": 0.05}))
    inputs = Inputs(simulation, command_timeout=0.2, ramp=0.1)
    inputs.drive(["rail"], velocities=[0.5])
    inputs.advance(200)
    assert simulation.v[0] == pytest.approx(0.5)
    inputs.advance(100)
    assert simulation.v[0] == 0.0
    assert inputs.take_events() == [(201_000_000, "command_timeout: rail")]
    inputs.drive(["rail"], [0.02])
    inputs.advance(1000)
    assert simulation.q[0] == pytest.approx(0.02) and inputs.take_events() == []


def test_what_drives_are_told_does_not_depend_on_how_steps_are_grouped():
    runs = []
    for size in (1, 7, 50):
        inputs = Inputs(Simulation(carried({"within": 0.05})), 0.03, 0.01)
        inputs.drive(["rail"], [0.01], [0.5])
        left = 350
        while left:
            some = min(size, left)
            inputs.advance(some)
            left -= some
        runs.append(inputs.simulation.state())
    assert runs[0] == runs[1] == runs[2]


def test_what_cannot_be_followed_is_withdrawn_and_the_drive_brought_to_rest():
    simulation = Simulation(carried({"within": 1e-3}))
    inputs = Inputs(simulation, 0.0, 0.0)
    inputs.drive(["rail"], [1e4])
    assert inputs.withdraw() == ["rail"]
    assert inputs.withdraw() == []
    inputs.advance(20)
    assert simulation.q[0] == 0.0


def test_a_free_base_goes_to_the_pose_it_is_told_and_beyond_half_a_turn():
    frame = {"position": [0.1, 0.0, 0.3], "rpy": [0.3, -0.2, 0.5]}
    scene = carried({"within": 0.1}, kind="free", base=frame)
    simulation = Simulation(scene)
    dynamics = simulation.dynamics
    node = dynamics.compiled.chain.frames["rail"]

    def pose():
        return dynamics.node_poses(simulation.q)[node]

    for angle in (2.0, 3.0, 4.0):  # about an axis of the world
        turn = np.concatenate(
            [np.sin(0.5 * angle) * np.array([0, 0.6, 0.8]), [np.cos(0.5 * angle)]]
        )
        target = np.concatenate([[0.2, 0.1, 0.5 - 0.1 * angle], turn])
        before = simulation.q[:3].copy()
        simulation.set_driven_pose("rail", target)
        simulation.advance(120)
        np.testing.assert_allclose(pose(), se3.pose_matrix(target[:3], turn), atol=1e-12)
        assert np.linalg.norm(simulation.q[:3] - before) < 2.5  # no turn back


def test_the_twist_of_a_pose_is_along_the_axes_that_move():
    scene = carried({"within": 0.1}, kind="free")
    simulation = Simulation(scene)
    turn = np.array([0.1, -0.3, 0.2, 0.0])
    turn[3] = np.sqrt(1.0 - turn @ turn)
    twist = np.array([0.5, -0.2, 0.3, 0.1, 0.2, -0.3])
    simulation.set_driven_pose("rail", [0.1, 0.2, 0.3, *turn], twist)
    simulation.advance(100)
    node = simulation.dynamics.compiled.chain.frames["rail"]
    h = 1e-6
    ahead, behind = (
        simulation.dynamics.node_poses(simulation.q + s * h * simulation.v)[node] for s in (1, -1)
    )
    found = se3.log(se3.inverse(behind) @ ahead) / (2.0 * h)
    np.testing.assert_allclose(found, twist, atol=1e-8)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("rod", 0.1), "they are driven within some time"),
        (("rail", None), "a position or a velocity"),
        (("rail", float("nan")), "position"),
        (("rail", 0.1, None, 0.0), "at least the step of 0.001 s"),
        (("rail", 0.1, None, 9e-4), "at least the step of 0.001 s"),
        (("rail", 1e308, None, 1e-3), "finite"),
    ],
)
def test_what_is_no_command_is_refused(arguments, complaint):
    simulation = Simulation(carried({"within": 0.1}))
    simulation.set_driven("rail", 0.01)
    simulation.advance(10)
    with pytest.raises(BadArgument, match=complaint):
        simulation.set_driven(*arguments)


def test_orders_say_what_is_wrong_with_them():
    inputs = Inputs(Simulation(carried({"within": 0.1}, kind="free")), 0.0, 0.0)
    with pytest.raises(CommandError, match="follows no commands"):
        inputs.drive(["rod"], [0.1])
    with pytest.raises(CommandError, match="not finite: rail/x"):
        inputs.drive(["rail/x"], [np.inf])
    with pytest.raises(CommandError, match="quaternion of length"):
        inputs.drive_pose("rail", [0, 0, 0, 0, 0, 0, 2])
    with pytest.raises(CommandError, match="follows no poses"):
        inputs.drive_pose("rod", [0, 0, 0, 0, 0, 0, 1])
    with pytest.raises(CommandError, match="expected a position or a velocity"):
        inputs.joint_command(["rail/x"], [1.0])
    assert inputs.drive(["rail/x", "rail/y"], [np.nan, 0.1]).goals[0].name == "rail/y"


def test_driven_coordinates_need_no_mass_of_their_own():
    """A wrist about an axis about which the base turns as well: together they move one mass."""
    base = {"joint": "base", "kind": "free", "driven": {"within": 0.1}}
    wrist = {"joint": "wrist", "kind": "revolute", "axis": [0, 1, 0], "driven": {"within": 0.1}}
    moment = {"moment": "pitch", "rod": "rod", "section": "s", "strain": "bend_y"}
    document = forest_document([base, wrist, rod("rod", 0.3)], materials=SLACK)
    del document["numerics"]  # chosen by trial runs
    simulation = Simulation(scene_of(document | {"actuators": [moment]}))
    simulation.set_driven("wrist", 0.3)
    simulation.advance(round(0.2e9 / simulation.step_ns))
    assert simulation.q[6] == pytest.approx(0.3)


def test_positions_that_come_in_a_stream_are_followed_late_by_0_6_of_the_time():
    """Replanned at every step it is a filter, s³ + 9 s²/T + 36 s/T² + 60/T³: late by 36 T/60."""
    within, rate = 0.05, 0.2
    simulation = Simulation(carried({"within": within}))
    for i in range(400):
        simulation.set_driven("rail", rate * 1e-3 * i)
        simulation.advance(1)
    late = simulation.time - simulation.q[0] / rate
    assert simulation.v[0] == pytest.approx(rate, rel=1e-3)
    assert late == pytest.approx(0.6 * within, abs=1.1e-3)  # and what is held for a step


def test_what_is_commanded_is_reached_within_no_less_than_a_step():
    with pytest.raises(SceneError, match=r"rail\.driven\.within = 0\.0005.*step of 0\.001 s"):
        Simulation(carried({"within": 5e-4}))


def test_a_scene_says_how_soon_a_command_is_reached():
    with pytest.raises(SceneError, match=r"driven\.within"):
        carried({"within": 0.0})
    with pytest.raises(SceneError, match="start"):
        carried({"within": 0.1, "start": 0.2}, kind="free")
    scene = carried({"x": {"within": 0.1, "start": 0.2}, "y": "0.1*t"}, kind="free")
    assert list(scene.commanded) == ["rail/x"] and scene.posed == ()
