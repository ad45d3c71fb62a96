"""Packaged scenes of contact do what they are for: a hand that lifts, a snake that moves."""

import numpy as np

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.scene import load_scene, parse_scene


def test_a_hand_lifts_a_ball_by_friction_and_drops_it():
    hand = Simulation(load_scene("grasp"))
    along = hand.compiled.coordinate_names.index("fly/x")

    def height():
        return hand.compiled.scene.base.position[2] - hand.q[along] - 0.03

    for tension in np.linspace(1.0, 5.0, 5):
        hand.set_efforts(np.full(3, tension))
        hand.advance(100)
    hand.advance(1700)
    held = hand.contacts()
    assert {contact.body for contact in held} == {"first", "second", "third"}
    assert height() > 0.06  # of the 0.08 m that the lift has risen by
    carried = -sum(contact.force[2] for contact in held)  # on the fingers
    assert abs(carried - 0.06 * 9.81) < 0.02 * 0.06 * 9.81
    hand.set_efforts(np.zeros(3))
    hand.advance(400)
    assert height() < 0.005
    assert {contact.shape for contact in hand.contacts()} <= {"table"}


def way(across):
    """How far a snake has come along x in two periods of its wave, in m."""
    text = load_scene("snake").source.replace("across: 1.0", f"across: {across}")
    snake = Simulation(parse_scene(text))
    places = (np.arange(6) + 0.5) / 6

    def middle():
        return snake.dynamics.node_poses(snake.q)[1:, 0, 3].mean()

    begin = middle()
    for _ in range(200):
        wave = np.sin(2.0 * np.pi * (snake.time - places))
        snake.set_efforts(min(1.0, 2.0 * snake.time) * 0.15 * wave)
        snake.advance(5)
    return middle() - begin


def test_a_snake_moves_by_its_friction_and_turns_round_with_its_ratio():
    forward, backward = way(1.0), way(0.05)
    assert forward < -0.2
    assert backward > 0.1
