"""A-3: strings in motion against chains of rigid links, and what becomes of a slack one."""

import numpy as np
import pytest
from scenes import rod_document, scene_of
from scipy.integrate import solve_ivp

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import Diverged

LENGTH, LEAN, G = 2.0, 0.5, 9.81


def chain(count, lean, times, drag=0.0):
    """Angles (times, count) from the vertical of a pendulum of many links, released at rest.

    Point masses at the ends of rigid links without mass, half a mass at the tip: Lagrange's
    equations in the angles.
    """
    h, mass = LENGTH / count, np.ones(count)
    mass[-1] = 0.5
    below = np.cumsum(mass[::-1])[::-1]
    shared = below[np.maximum.outer(np.arange(count), np.arange(count))]

    def rate(t, y):
        angle, speed = np.split(y, 2)
        apart = angle[:, None] - angle[None, :]
        inertia = shared * np.cos(apart)
        push = (shared * np.sin(apart)) @ speed**2 + G / h * below * np.sin(angle)
        return np.concatenate([speed, np.linalg.solve(inertia, -push) - drag * speed])

    start = np.concatenate([np.full(count, 0.5 * np.pi - lean), np.zeros(count)])
    options = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-9}
    return solve_ivp(rate, (0.0, times[-1]), start, t_eval=times, **options).y[:count].T


def tip(angles):
    """Place (times, 2) of the end of a chain: to the side and up."""
    h = LENGTH / angles.shape[1]
    return h * np.stack([np.sin(angles).sum(axis=1), -np.cos(angles).sum(axis=1)], axis=1)


def string(lean, *, order=5, elements=4, drag=0.0, **numerics):
    document = rod_document(
        length=LENGTH, radius=0.002, gravity=(0, 0, -G), order=order, elements=elements,
        base={"rpy": [0.0, lean, 0.0]}, material={"rayleigh": {"mass": drag}},
    )  # fmt: skip
    document["bodies"][0]["model"] = "string"
    document["bodies"][0]["strains"] = ["bend_y"]
    document["numerics"]["basis"]["order"] = {"bend_y": order}
    return Simulation(scene_of(document | {"numerics": document["numerics"] | numerics}))


@pytest.mark.parametrize("drag", [0.0, 2.0])
def test_a_released_string_falls_as_a_chain_of_ever_more_links(drag):
    """Until it kinks: the tip of 40 and 80 links, extrapolated, at three instants."""
    times = np.array([0.2, 0.35, 0.5])
    few, many = (tip(chain(count, LEAN, times, drag)) for count in (40, 80))
    expected = (4 * many - few) / 3
    simulation = string(LEAN, order=3, elements=16, drag=drag, step=5e-4, integrator="sdirk4")
    for time, place in zip(times, expected, strict=True):
        simulation.advance(round((time - simulation.time) / 5e-4))
        found = simulation.dynamics.node_poses(simulation.q)[-1][[0, 2], 3]
        np.testing.assert_allclose(found, place, atol=2e-5 * LENGTH)
    assert np.abs(few - many).max() < 3e-3 * LENGTH
    assert np.linalg.norm(expected[-1] - expected[0]) > 0.5


def test_a_chain_of_links_kinks_however_many_they_are():
    """Why: from 0.7 s on two links in a row stand 1.2 rad apart, be they ten or forty.

    The curvature of the string has no bound, so no number of elements resolves it.
    """
    times = np.linspace(0.55, 0.9, 141)
    bends = [np.abs(np.diff(chain(n, LEAN, times), axis=1)).max() for n in (10, 20, 40)]
    assert min(bends) > 1.2
    assert bends[2] > 0.95 * bends[1] > 0.9 * bends[0]


def test_a_string_that_folds_is_refused_not_followed_blindly():
    simulation = string(0.0, order=3, step=1e-3)
    with pytest.raises(Diverged, match=r"half a turn within one segment|compressed"):
        simulation.advance(4000)
    assert 0.5 < simulation.time < 4.0
    damped = string(0.0, order=3, step=1e-3, drag=2.0)
    damped.advance(4000)
    assert damped.dynamics.node_poses(damped.q)[-1][2, 3] < 0.0
