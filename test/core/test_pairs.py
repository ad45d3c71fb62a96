"""Contact of bodies with one another: exact tangent, action and reaction, energy."""

import numpy as np
import pytest
from differences import central_difference
from meeting import LAW, free, rod, scene, solid
from scenes import scene_of

from soft_sim_ros.core.model.contact import CODE
from soft_sim_ros.core.settled import Dynamics


def crowd():
    """A tapered rod on which another one, a ball, a capsule, a box and a moving wall press."""
    law = dict(LAW)
    small = {"kind": "sphere", "radius": 0.03, "position": [0.01, 0, 0]}
    box = {"kind": "box", "size": [0.08, 0.06, 0.05], "position": [0.01, 0, 0], "rpy": [0.2, 0, 0]}
    capsule = {"kind": "capsule", "radius": 0.03, "from": [-0.05, 0.01, 0], "to": [0.05, 0, 0]}
    bodies = [
        free("a"), rod("a", [0.03, 0.015]),
        free("b"), rod("b", 0.02),
        free("ball"), solid("ball"),
        free("other"), solid("other", shape=small),
        free("capsule"), solid("capsule", shape=capsule),
        free("box"), solid("box", shape=box),
        {"joint": "slide", "kind": "prismatic", "axis": [0, 0, 1], "parent": "base"},
        {"joint": "swing", "kind": "revolute", "axis": [0, 1, 0]},
    ]  # fmt: skip
    at = {
        "a": [0, 0, 0, 0, 0, 0],
        "b": [0, 0, 1.3, 0.1, -0.15, 0.04],
        "ball": [0.1, 0.2, 0.3, 0.2, 0.06, 0],
        "other": [0.1, 0.2, 0.3, 0.225, 0.005, 0.03],
        "capsule": [0, 0.3, 0.4, 0.25, -0.045, 0.0],
        "box": [0.2, 0.1, 0.1, 0.18, 0.0, -0.04],
    }
    shapes = [
        {"plane": "wall", "on": "swing", "position": [0, 0, -0.05], "normal": [0.1, 0, 1]},
        {"sphere": "bump", "on": "swing", "position": [0.05, 0.02, -0.05], "radius": 0.04},
    ]
    for shape in shapes:
        shape["overlap"] = True
    pairs = [{"bodies": ["a", "b", "ball", "other", "capsule", "box"], "overlap": True}]
    numerics = {"basis": {"order": 1, "elements": 2, "nodes": 4}}
    return scene(bodies, pairs, at, contact=law, environment=shapes, numerics=numerics)


@pytest.fixture(scope="module")
def pressed():
    dynamics = Dynamics(scene_of(crowd()))
    q = np.zeros(dynamics.n)
    for name, x in dynamics.compiled.scene.initial.positions.items():
        q[dynamics.compiled.chain.columns(name)] = x
    rng = np.random.default_rng(2)
    q += 1e-3 * rng.normal(size=dynamics.n)
    return dynamics, [q, 0.1 * rng.normal(size=dynamics.n), np.zeros(dynamics.n)]


def kinds_that_touch(dynamics):
    meet, pairs = dynamics._data.meet, dynamics.model.pairs
    hits = meet.hit[: meet.counts[1]]
    return {(int(pairs.kind[pairs.cell[q]]), int(pairs.kind[e])) for q, e, _ in hits}


@pytest.mark.parametrize("span", [-1.0, 0.003, 0.5])
def test_the_tangent_of_bodies_that_touch_is_its_difference_quotient(pressed, span):
    """Without friction, mostly sticking, mostly slipping."""
    dynamics, state = pressed
    touch = dynamics._data.touch
    touch.mode[0] = span
    touch.start[:] = 0.0
    dynamics.residual(*state, dynamics.forcing())
    touch.start[..., :CODE] = 1e-3 * np.random.default_rng(1).normal(size=(*touch.kept.shape, 2, 3))
    touch.start[..., CODE] = touch.after[..., CODE]
    touch.kept[:] = 1
    assert len(kinds_that_touch(dynamics)) >= 7
    for which in (0, 1):
        exact = dynamics.tangents(*state)[which]

        def residual(x, which=which):
            moved = [*state]
            moved[which] = x
            return dynamics.inverse_dynamics(*moved)

        size = (1e-6, 1e-4)[which] / np.maximum(dynamics.model.weight, 1e-3)
        quotient = central_difference(residual, state[which], size)
        diagonal = np.abs(np.diag(exact))
        scale = np.sqrt(np.outer(*2 * [diagonal + 1e-6 * diagonal.max()]))
        assert np.max(np.abs(exact - quotient) / (scale + np.abs(exact))) < 1e-6
