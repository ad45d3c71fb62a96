"""Physics does not know where the base stands."""

import numpy as np
import pytest
from scenes import scene_of, zoo_document
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.settled import Simulation


def moved(document, turn, shift):
    """Return the document with base, gravity and world loads turned together, the base shifted."""
    base = document["base"]
    quaternion = turn * Rotation.from_euler("xyz", base["rpy"])
    document["base"] = {
        "position": turn.apply(base["position"]) + shift,
        "quaternion": quaternion.as_quat(),
    }
    document["gravity"] = turn.apply(document["gravity"])
    for load in document["loads"]:
        if load.get("frame", "world") == "world":
            for key in ("force", "moment"):
                if key in load:
                    load[key] = turn.apply(load[key])
    return document


def run(document):
    document["numerics"] |= {"step": 0.005, "newton_tolerance": 1e-12}
    simulation = Simulation(scene_of(document))
    simulation.set_efforts([0.1, 0.2, 5.0, 3.0])
    simulation.advance(40)
    return simulation


@pytest.mark.parametrize("seed", range(2))
def test_turning_base_gravity_and_loads_together_changes_nothing_in_the_arm(seed):
    turn = Rotation.random(random_state=seed)
    shift = np.array([3.0, -1.0, 0.5])
    one, two = run(zoo_document()), run(moved(zoo_document(), turn, shift))
    np.testing.assert_allclose(two.q, one.q, atol=1e-8)
    # gravity energy is counted from the base
    np.testing.assert_allclose(two.ledger(), one.ledger(), atol=1e-8)
    a, b = one.sampler(7).poses(), two.sampler(7).poses()
    np.testing.assert_allclose(b[:, :3], turn.apply(a[:, :3]) + shift, atol=1e-8)
    for p, q in zip(a[:, 3:], b[:, 3:], strict=True):
        difference = (turn * Rotation.from_quat(p)).inv() * Rotation.from_quat(q)
        assert difference.magnitude() < 1e-7


def test_a_tip_wrench_along_world_axes_is_turned_into_the_base():
    document = zoo_document()
    turn = Rotation.from_euler("xyz", [0.3, 1.0, -2.0])
    wrench = np.array([0.01, 0.02, -0.03, 0.4, -0.2, 0.3])
    one, two = (Simulation(scene_of(d)) for d in (document, moved(zoo_document(), turn, 0.0)))
    one.set_tip_wrench(wrench)
    two.set_tip_wrench(np.concatenate([turn.apply(wrench[:3]), turn.apply(wrench[3:])]))
    one.advance(50)
    two.advance(50)
    np.testing.assert_allclose(two.q, one.q, atol=1e-7)
    without = Simulation(scene_of(zoo_document()))
    without.advance(50)
    assert np.abs(without.q - one.q).max() > 1e-3
