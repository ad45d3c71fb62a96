"""Rods that touch rods: against elasticas with a point force, whatever the mesh; self-contact."""

import numpy as np
import pytest
from meeting import rod, scene
from scenes import scene_of
from scipy.integrate import quad, solve_bvp
from scipy.optimize import brentq

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics.contacts import ContactReader, resultants
from soft_sim_ros.core.settled import Dynamics

G, R, LENGTHS, CLEAR = 9.81, 0.01, (0.4, 0.6), 1e-4
YOUNG, STIFFNESS, ONSET = 2e7, 1e6, 1e-4


def crossing(elements):
    """Two ropes held at both ends; the longer one lies across the other, both sag."""
    strains = ["torsion", "bend_y", "bend_z", "stretch"]
    pose = {"position": [0.2, -0.3, 2 * R + CLEAR], "rpy": [0, 0, np.pi / 2]}
    bodies = [
        rod("a", R, LENGTHS[0], strains=strains),
        rod("b", R, LENGTHS[1], strains=strains, parent={"body": "base", "offset": pose}),
    ]
    law = {"friction": 0.0, "stiffness": STIFFNESS, "onset": ONSET}
    document = scene(
        bodies, [{"bodies": ["a", "b"], "contact": law}], {}, gravity=[0, 0, -G],
        numerics={"basis": {"order": 3, "elements": elements}},
    )  # fmt: skip
    document["materials"]["soft"] = document["materials"]["soft"] | {"young_modulus": YOUNG}
    document["initial"] = {}
    document["constraints"] = [
        {"name": f"{name}_end", "kind": "weld", "frames": [{"body": name}, {"world": "here"}]}
        for name in "ab"
    ]
    return Dynamics(scene_of(document))


def own_sag(length, force):
    """Height of the middle of a heavy elastica held at both ends, a force on its middle, in m."""
    area = np.pi * R**2
    ea, ei, weight = YOUNG * area, YOUNG * 0.25 * np.pi * R**4, 1100.0 * area * G

    def slopes(s, y):
        x, z, angle, bend, h, v = y
        c, d = np.cos(angle), np.sin(angle)
        stretch = 1.0 + (h * c + v * d) / ea
        along, up = stretch * c, stretch * d
        moment = -(along * v - up * h)
        return np.array([along, up, bend / ei, moment, 0.0 * h, weight + 0.0 * v])

    def ends(a, b):
        return np.array([a[0], a[1], a[2], b[0] - 0.5 * length, b[2], b[5] - 0.5 * force])

    s = np.linspace(0, 0.5 * length, 60)
    start = np.zeros((6, len(s)))
    start[0], start[4], start[5] = s, 0.1, weight * (s - 0.5 * length)
    start[1] = -0.01 * np.sin(np.pi * s / length) ** 2
    found = solve_bvp(slopes, ends, s, start, tol=1e-10, max_nodes=100000)
    assert found.success
    return found.y[1, -1]


def pressing(distance):
    """Force of two crossing cylinders whose axes are so far apart, of the law per length."""

    def per_length(s):
        depth = max(0.0, 2 * R - np.hypot(distance, s))
        return STIFFNESS * (0.5 * depth**2 / ONSET if depth < ONSET else depth - 0.5 * ONSET)

    return 2.0 * quad(per_length, 0, 0.5 * R, epsabs=1e-12, limit=200)[0]


@pytest.mark.parametrize("elements", [2, 4])
def test_ropes_that_cross_press_like_two_elasticas(elements):
    def off(force):
        apart = own_sag(LENGTHS[1], force) + 2 * R + CLEAR - own_sag(LENGTHS[0], -force)
        return pressing(apart) - force

    own = brentq(off, 0.3, 1.2, xtol=1e-9)
    dynamics = crossing(elements)
    q = equilibrium(dynamics)
    found = resultants(ContactReader(dynamics.compiled).near(q, np.zeros(dynamics.n)))
    assert found["b", "a"][5] == pytest.approx(own, rel=1e-3)
    assert np.abs(found["b", "a"] + found["a", "b"]).max() == 0.0
    assert np.abs(found["b", "a"][3:5]).max() < 1e-9
