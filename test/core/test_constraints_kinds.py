"""Each kind of constraint against closed forms that know nothing of rows and multipliers."""

import numpy as np
import pytest
from closed import held_rod
from forests import rod
from scenes import scene_of

from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.scene.constraint import CONSTRAINT_KINDS, WITH_AXIS

G = 9.81


def slope_document(kind, turn, **rest):
    """Return a free body whose origin is held on a line or plane through the origin."""
    axis = [1.0, 0.0, 0.0] if kind == "line" else [0.0, 0.0, 1.0]
    world = {"position": [0.0, 0.0, 0.0], "rpy": [0.0, turn, 0.0]}
    frames = [{"body": "box"}, {"world": world}]
    return {
        "name": "slope",
        "gravity": [0.0, 0.0, -G],
        "bodies": [
            {"joint": "free", "kind": "free"},
            {"rigid_body": "box", "mass": 0.4, "inertia": [1e-3, 2e-3, 3e-3]},
        ],
        "constraints": [{"name": "rail", "kind": kind, "axis": axis, "frames": frames}],
        "numerics": {"step": 1e-3},
    } | rest


@pytest.mark.parametrize("kind", ["line", "plane"])
def test_a_body_slides_down_a_rail_as_galileo_says(kind):
    """And is held by m g cos of the slope across it; on a plane it also goes on sideways."""
    turn, time, mass = 0.4, 0.3, 0.4
    across = 0.7 if kind == "plane" else 0.0
    start = {"velocities": {"free": [0.0, 0.0, 0.0, 0.0, across, 0.0]}}
    simulation = Simulation(scene_of(slope_document(kind, turn, initial=start)))
    simulation.advance(300)
    node = simulation.compiled.node_of("box")
    found = simulation.dynamics.node_poses(simulation.q)[node, :3, 3]
    way = 0.5 * G * np.sin(turn) * time**2
    down = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    np.testing.assert_allclose(found, way * down + [0.0, across * time, 0.0], atol=1e-9)
    normal = np.array([np.sin(turn), 0.0, np.cos(turn)])
    reaction = simulation.reactions()["rail"]
    np.testing.assert_allclose(reaction.force, mass * G * np.cos(turn) * normal, atol=1e-8)
    np.testing.assert_allclose(reaction.moment, 0.0, atol=1e-10)


def test_a_pendulum_on_a_line_swings_at_its_own_frequency():
    """A pin that glides without friction: nothing pushes the centre of mass along the rail."""
    mass, arm, inertia = 0.4, 0.2, 1.5e-3
    document = slope_document("line", 0.0)
    document["bodies"][1] |= {
        "mass": mass, "inertia": [1e-3, inertia, inertia],
        "com": {"position": [0.0, 0.0, -arm]},
    }  # fmt: skip
    document["initial"] = {"positions": {"free": [0.0, 1e-4, 0.0, 0.0, 0.0, 0.0]}}
    document["numerics"] = {"step": 5e-4, "integrator": "sdirk4"}
    simulation = Simulation(scene_of(document))
    # so it stays where it is, and the body turns about it: J θ̈ = −m g l θ
    omega = np.sqrt(mass * G * arm / inertia)
    steps = 150
    simulation.advance(steps)
    angle = simulation.q[1]
    assert angle == pytest.approx(1e-4 * np.cos(omega * steps * 5e-4), abs=1e-9)


def test_held_orientation_turns_a_beams_end_with_the_moment_of_a_guided_one():
    """F at the end of a clamped–guided beam: F L³ / 12 EI, and the moment F L / 2 holds it."""
    length, radius, young = 0.5, 0.01, 1e6
    bending = young * np.pi * radius**4 / 4.0
    push = 1e-5
    load = {"point": "push", "body": "rod", "force": [0.0, 0.0, push]}
    document = held_rod(
        [{"name": "guide", "kind": "orientation", "frames": [{"body": "rod"}]}],
        rod={"model": "euler_bernoulli", "strains": ["bend_y"]},
        loads=[load],
        initial={"state": "equilibrium"},
        numerics={"step": 1e-3, "basis": {"order": 4}},
    )
    simulation = Simulation(scene_of(document))
    pose = simulation.dynamics.node_poses(simulation.q)[-1]
    assert pose[2, 3] == pytest.approx(push * length**3 / (12.0 * bending), rel=1e-6)
    np.testing.assert_allclose(pose[:3, :3], np.eye(3), atol=1e-12)
    reaction = simulation.reactions()["guide"]
    np.testing.assert_allclose(reaction.force, 0.0, atol=1e-12 * push)
    assert reaction.moment[1] == pytest.approx(push * length / 2.0, rel=1e-6)


def test_held_orientation_carries_a_spinning_body_without_turning_it():
    """Two bodies one behind the other: the second goes as a point, whatever pulls at its side."""
    document = {
        "name": "carried",
        "gravity": [0.0, 0.0, 0.0],
        "bodies": [
            {"joint": "free", "kind": "free"},
            {"rigid_body": "box", "mass": 0.4, "inertia": [1e-3, 2e-3, 3e-3]},
        ],
        "loads": [{"point": "pull", "body": "box", "force": [0.0, 0.3, 0.0],
                   "moment": [0.01, 0.02, -0.03]}],
        "constraints": [{"name": "gyro", "kind": "orientation", "frames": [{"body": "box"}]}],
        "numerics": {"step": 1e-3},
    }  # fmt: skip
    simulation = Simulation(scene_of(document))
    simulation.advance(200)
    pose = simulation.dynamics.node_poses(simulation.q)[-1]
    np.testing.assert_allclose(pose[:3, :3], np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose[:3, 3], [0.0, 0.5 * 0.3 / 0.4 * 0.04, 0.0], atol=1e-9)
    reaction = simulation.reactions()["gyro"]
    np.testing.assert_allclose(reaction.moment, [-0.01, -0.02, 0.03], atol=1e-10)


@pytest.mark.parametrize("kind", CONSTRAINT_KINDS)
def test_rows_follow_coordinates_as_their_difference_quotients_say(kind):
    """Of two bodies on branches of their own, in any state."""
    one = {
        "name": "one",
        "kind": kind,
        "frames": [
            {"body": "left", "s": 0.1},
            {"body": "right", "offset": {"position": [0.01, 0.02, 0.03], "rpy": [0.3, 0.2, 0.1]}},
        ],
    }
    if kind in WITH_AXIS:
        one["axis"] = [0.3, -0.5, 0.8]
    if kind == "distance":
        one["length"] = 0.2
    branch = {"body": "hub", "offset": {"position": [0.0, 0.1, 0.0], "rpy": [0.1, 0.2, 0.3]}}
    bodies = [
        {"joint": "free", "kind": "free"},
        {"rigid_body": "hub", "mass": 0.2, "inertia": [1e-4] * 3},
        rod("left", 0.3, {"body": "hub"}),
        rod("right", 0.2, branch),
    ]
    dynamics = Dynamics(scene_of(held_rod([one], bodies=bodies, numerics={"basis": {"order": 2}})))
    rng, still = np.random.default_rng(4), np.zeros(dynamics.n)
    q, step = 0.3 * rng.normal(size=dynamics.n) / dynamics.model.weight, 1e-6

    def value(at):
        dynamics.residual(at, still, still, dynamics.forcing())
        return dynamics.constraints.value

    for _ in range(3):
        way = rng.normal(size=dynamics.n) / dynamics.model.weight
        quotient = (value(q + step * way) - value(q - step * way)) / (2.0 * step)
        value(q)
        told = dynamics.constraints.jacobian() @ way
        np.testing.assert_allclose(told, quotient, atol=1e-8)
        assert np.abs(told).max() > 1e-3
