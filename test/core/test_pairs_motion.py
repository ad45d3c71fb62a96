"""Bodies that touch one another in motion: against closed forms and solutions of their own."""

import numpy as np
import pytest
from meeting import free, momentum, scene, solid
from scenes import scene_of
from scipy.integrate import solve_ivp

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.mechanics.contacts import resultants
from soft_sim_ros.core.settled import Simulation

G = 9.81
FIRM = {"stiffness": 1e6, "dissipation": 0.5}
DOWN = [0.0, 0.0, -G]


def test_balls_collide_as_the_law_says_and_keep_their_momentum():
    """Hunt and Crossley's loss in a central impact, the same law by scipy."""
    law = {"stiffness": 1e5, "dissipation": 0.4}
    masses, speed = (0.3, 0.5), 1.2
    document = scene(
        [free("a"), solid("a", masses[0]), free("b"), solid("b", masses[1])],
        [{"bodies": ["a", "b"], "contact": law}],
        {"a": [0] * 6, "b": [0, 0, 0, 0.11, 0, 0]},
        {"a": [0, 0, 0, speed, 0, 0]},
        numerics={"step": 2e-5},
    )
    sim = Simulation(scene_of(document))
    before = momentum(sim)
    sim.advance(1500)
    after = momentum(sim)
    reduced, c, onset = masses[0] * masses[1] / sum(masses), 1e5 * 0.05, 0.01 * 0.05

    def law_of(t, x):
        depth = max(x[0], 0.0)
        push = 0.5 * c * depth**2 / onset if depth < onset else c * (depth - 0.5 * onset)
        return [x[1], -push * max(0.0, 1.0 + 0.4 * x[1]) / reduced]

    found = solve_ivp(law_of, (0, 0.03), [-0.01, speed], "DOP853", rtol=1e-11, atol=1e-13,
                      max_step=1e-5)  # fmt: skip
    apart = sim.v[9] - sim.v[3]
    assert apart == pytest.approx(-found.y[1, -1], rel=1e-5)
    assert 0.5 * speed < apart < 0.9 * speed
    assert np.abs(after - before).max() < 1e-14
    lost = 0.5 * reduced * (speed**2 - apart**2)
    ledger = sim.ledger()
    assert ledger[5] == pytest.approx(lost, rel=1e-5)


def test_an_oblique_impact_with_friction_keeps_momentum():
    document = scene(
        [free("a"), solid("a"), free("b"), solid("b", 0.5)],
        [{"bodies": ["a", "b"], "contact": {"stiffness": 1e5, "friction": 0.4}}],
        {"a": [0] * 6, "b": [0, 0, 0, 0.12, 0.02, 0.01]},
        {"a": [3, -2, 1, 1, 0, 0], "b": [0, 4, 2, -0.5, 0, 0.1]},
        numerics={"step": 2e-4},
    )
    sim = Simulation(scene_of(document))
    before = momentum(sim)
    sim.advance(200)
    change = momentum(sim) - before
    assert np.abs(change[3:]).max() < 1e-14
    assert np.abs(change[:3]).max() < 2e-8  # of the steps: it falls with their square
    assert sim.ledger()[5] / sim.ledger()[0] > 0.05
    assert np.abs(sim.v[:3] - [3, -2, 1]).max() > 0.1


def test_an_impact_is_the_same_in_a_turned_frame():
    """Friction, its bristles and all: they turn with what they are on."""
    ends = []
    turn = se3.exp(np.array([0.4, -0.7, 1.1, 0, 0, 0]))[:3, :3]
    for rotation in (np.eye(3), turn):
        vector = se3.log(np.block([[rotation, np.zeros((3, 1))], [np.zeros((1, 3)), 1.0]]))[:3]
        at = {
            name: [*vector, *(rotation @ x)]
            for name, x in {"a": [0.0, 0, 0], "b": [0.11, 0.02, 0.01]}.items()
        }
        document = scene(
            [free("a"), solid("a"), free("b"), solid("b", 0.5)],
            [{"bodies": ["a", "b"], "contact": {"stiffness": 1e5, "friction": 0.4}}],
            at, {"a": [3, -2, 1, 1, 0, 0], "b": [0, 4, 2, -0.5, 0, 0.1]},
            numerics={"step": 2e-4},
        )  # fmt: skip
        sim = Simulation(scene_of(document))
        sim.advance(120)
        ends.append(rotation.T @ sim.v.reshape(4, 3)[[1, 3]].T)
    assert np.abs(ends[0] - ends[1]).max() < 1e-7
    assert np.abs(ends[0][:, 0] - [1, 0, 0]).max() > 0.1


def test_a_stack_of_balls_weighs_what_it_weighs():
    law = {"stiffness": 1e5, "dissipation": 20.0, "friction": 0.4}
    document = scene(
        [free("a"), solid("a"), free("b"), solid("b", 0.5)],
        [{"bodies": ["a", "b"]}],
        {"a": [0, 0, 0, 0, 0, 0.05], "b": [0, 0, 0, 0, 0, 0.15]},
        contact=law, gravity=DOWN, environment=[{"plane": "floor"}],
    )  # fmt: skip
    sim = Simulation(scene_of(document))
    sim.advance(1500)
    found = resultants(sim.contacts())
    assert found["b", "a"][5] == pytest.approx(0.5 * G, rel=1e-6)
    assert found["a", "b"] == pytest.approx(-found["b", "a"])
    assert found["a", "floor"][5] == pytest.approx(0.8 * G, rel=1e-6)


def belt(speed):
    """A driven joint that carries a plane."""
    course = {"formula": f"{speed} * t"}
    return {"joint": "belt", "kind": "prismatic", "axis": [1, 0, 0], "driven": course}


@pytest.mark.parametrize("wall", [{"plane": "top"}, {"box": "top", "size": [9, 1, 0.2],
                                                    "position": [0, 0, -0.1]}])  # fmt: skip
def test_a_ball_laid_on_a_belt_slides_until_it_rolls(wall):
    """It gains μ g t and turns with 5/2 μ g t / R until both make up for the belt: 2/7 of it."""
    ball = solid("a", 0.5)
    ball["inertia"] = [0.4 * 0.5 * 0.05**2] * 3
    law = FIRM | {"friction": 0.3, "dissipation": 5.0}
    depth = np.sqrt(2.0 * 5e-4 * 0.5 * G / (1e6 * 0.05))
    document = scene(
        [belt(0.7), free("a"), ball], [], {"a": [0, 0, 0, 0, 0, 0.05 - depth]},
        contact=law, gravity=DOWN, environment=[wall | {"on": "belt"}],
    )  # fmt: skip
    del document["pairs"]
    sim = Simulation(scene_of(document))
    until = 0.7 / (3.5 * 0.3 * G)
    sim.advance(round(0.8 * until * 1000))
    assert sim.v[4] == pytest.approx(0.3 * G * sim.time, rel=1e-4)
    sim.advance(round(1.0 * until * 1000))
    assert sim.v[4] == pytest.approx(0.2, rel=1e-5)
    way = 0.5 * 0.3 * G * until**2 + 0.2 * (sim.time - until)
    assert sim.q[4] == pytest.approx(way, rel=1e-3)  # bristles bend before it rolls
    # the belt does the work that slides away and that moves the ball
    kinetic = 0.5 * 0.5 * 0.2**2 + 0.2 * 0.5 * 0.5**2
    assert sim.ledger()[4] + sim.ledger()[3] == pytest.approx(kinetic + sim.ledger()[5], rel=1e-3)


def own_stick_slip(mass, k, speed, most, least, time):
    """Return times at which slipping begins and the ways there: a mass on a spring on a belt."""
    t, x, begins, rate = 0.0, 0.0, [], np.sqrt(k / mass)
    while t < time:
        t += (most / k - x) / speed
        begins.append(t)
        # slips: x = least / k + a cos + b sin until it is as fast as the belt again
        a, b = most / k - least / k, speed / rate
        later = 2.0 * (np.pi - np.arctan2(a, b)) / rate
        x = least / k + a * np.cos(rate * later) + b * np.sin(rate * later)
        t += later
    return np.array(begins)


def test_a_mass_on_a_spring_sticks_and_slips_on_a_belt():
    mass, k, speed = 0.5, 60.0, 0.1
    joints = [
        belt(speed),
        {"joint": "along", "kind": "prismatic", "axis": [1, 0, 0], "stiffness": k,
         "parent": "base"},
        {"joint": "up", "kind": "prismatic", "axis": [0, 0, 1]},
    ]  # fmt: skip
    depth = np.sqrt(2.0 * 5e-4 * mass * G / (1e6 * 0.05))
    law = FIRM | {"friction": {"static": 0.5, "kinetic": 0.3}, "tangential_stiffness": 1e7}
    document = scene(
        [*joints, solid("a", mass)], [], {}, gravity=DOWN, numerics={"step": 5e-4},
        environment=[{"plane": "top", "on": "belt", "contact": law}],
    )  # fmt: skip
    del document["pairs"]
    document["initial"] = {"positions": {"up": 0.05 - depth}, "velocities": {"along": speed}}
    sim = Simulation(scene_of(document))
    begins, held = [], True
    most = 0.0
    for _ in range(4000):
        sim.advance(1)
        sticks = sim.contacts()[0].sticks
        if held and not sticks:
            begins.append(sim.time)
        held, most = sticks, max(most, sim.q[1])
    own = own_stick_slip(mass, k, speed, 0.5 * mass * G, 0.3 * mass * G, 2.0)
    own = own[own < 2.0]
    assert len(begins) == len(own) >= 3
    assert np.abs(np.array(begins) - own).max() < 2e-3
    assert most == pytest.approx(0.3 * mass * G / k + np.hypot(
        0.2 * mass * G / k, speed / np.sqrt(k / mass)), rel=2e-3)  # fmt: skip


def test_a_wall_pushes_a_ball():
    """A driven wall that speeds up gives the ball its acceleration, by the law's force."""
    wall = {"joint": "press", "kind": "prismatic", "axis": [1, 0, 0],
            "driven": {"formula": "0.5 * 2.0 * t**2"}}  # fmt: skip
    document = scene(
        [wall, free("a"), solid("a", 0.5)], [], {"a": [0, 0, 0, 0.05, 0, 0]},
        contact={"stiffness": 1e5, "dissipation": 20.0, "friction": 0.0},
        environment=[{"plane": "wall", "on": "press", "normal": [1, 0, 0]}],
        numerics={"step": 2.5e-4},
    )  # fmt: skip
    del document["pairs"]
    sim = Simulation(scene_of(document))
    sim.advance(4000)
    (contact,) = sim.contacts()
    assert contact.normal_force == pytest.approx(0.5 * 2.0, rel=1e-4)
    assert contact.shape == "wall"
    assert sim.v[4] == pytest.approx(2.0, rel=1e-4)
    # work of the wall is the kinetic energy, what the contact stores and what it lost at first
    ledger = sim.ledger()
    assert abs(ledger[6]) < 1e-4 * ledger[0]
