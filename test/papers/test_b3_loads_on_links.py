"""B-3: loads at any place and along a floating-frame link, by virtual work over its mode shapes."""

import numpy as np
import pytest
from floating_links import LENGTH, STRIP, document, link
from scenes import scene_of
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.compile.link_modes import Modes
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.errors import SceneError

FORCE, MOMENT = np.array([0.5, -0.8, 1.1]), np.array([0.2, 0.3, -0.4])
KINDS = {"torsion": 1, "bend_y": 2, "bend_z": 2}
BODY = link(strains=list(KINDS), modes=KINDS)


def work(where, q, turn, follows):
    """Generalised forces (6 + m) of a load per length: on a free base that stands turned, and q.

    where: arc lengths and weights. To first order in q, as linear modes are.
    """
    s, weights = where
    body = scene_of(document([BODY])).bodies[0]
    tilt, shift = Modes(body).fields(s)
    at = np.stack([s, 0 * s, 0 * s], axis=1) + shift @ q
    force, moment = (turn.inv().apply(x) for x in (FORCE, MOMENT))
    force, moment = (np.tile(x, (len(s), 1)) for x in (force, moment))
    if follows:
        angle = tilt @ q
        force, moment = (x + np.cross(angle, x) for x in (FORCE, MOMENT))
    # a rotation vector w turns by δw + ½ δw × w in the turned axes
    axes = Rotation.from_rotvec(tilt @ q)
    own = axes.inv().apply(moment)
    turned = tilt - 0.5 * np.cross((tilt @ q)[:, :, None], tilt, axis=1)
    modal = np.einsum("sc,scm->sm", force, shift) + np.einsum("sc,scm->sm", own, turned)
    rows = np.concatenate([moment + np.cross(at, force), force, modal], axis=1)
    return weights @ rows


@pytest.mark.parametrize("frame", ["world", "body"])
@pytest.mark.parametrize("size", [0.0, 1e-4])
@pytest.mark.parametrize("span", [(0.0, 1.0), (0.25, 0.7), (0.4, 0.4), (1.0, 1.0)])
def test_generalised_forces_are_virtual_work(frame, size, span):
    start, end = (LENGTH * x for x in span)
    load = {"force": FORCE, "moment": MOMENT, "frame": frame, "body": "link"}
    if start == end:
        load |= {"point": "p", "s": start}
        where = np.array([start]), np.ones(1)
    else:
        load |= {"distributed": "d", "start": start, "end": end}
        x, w = np.polynomial.legendre.leggauss(40)
        where = start + 0.5 * (end - start) * (x + 1), 0.5 * (end - start) * w
    bodies = [{"joint": "base", "kind": "free"}, BODY]
    base = {"rpy": [0.4, -0.7, 1.3]}
    plain, loaded = (
        Dynamics(scene_of(document(bodies, base=base, loads=loads))) for loads in ([], [load])
    )
    q = np.zeros(plain.n)
    q[6:] = size * np.array([1.0, -2.0, 1.5, 1.0, -1.0])
    zero = np.zeros(plain.n)
    found = plain.inverse_dynamics(q, zero, zero) - loaded.inverse_dynamics(q, zero, zero)
    expected = work(where, q[6:], Rotation.from_euler("xyz", base["rpy"]), frame == "body")
    np.testing.assert_allclose(found, expected, atol=1e-9 + 100 * size**2)
    for flipped in (slice(0, 3), slice(3, 6), slice(6, None)):
        assert np.abs(expected[flipped]).max() > 0.1


def test_a_link_sags_under_a_line_load_as_a_cantilever():
    """w = f ℓ⁴/8EI at the tip of one clamped at its start; modes miss what lies beyond them."""
    load = {"distributed": "d", "body": "link", "force": [0.0, 0.0, -0.02]}
    body = link(strains=["bend_y"], modes=6)
    dynamics = Dynamics(scene_of(document([body], loads=[load])))
    tip = dynamics.node_poses(equilibrium(dynamics))[-1][:3, 3]
    radius = STRIP["cross_section"]["radius"]
    bend = 2e9 * np.pi * radius**4 / 4
    assert tip[2] == pytest.approx(-0.02 * LENGTH**4 / (8 * bend), rel=1e-4)


def test_tangents_know_loads_along_a_link():
    common = {"body": "link", "force": FORCE}
    loads = [
        common | {"distributed": "d", "moment": MOMENT, "frame": "body"},
        common | {"point": "p", "s": 0.3},
    ]
    dynamics = Dynamics(scene_of(document([BODY], loads=loads)))
    q, zero = np.array([0.02, -0.01, 0.03, 0.01, 0.02]), np.zeros(5)
    found = dynamics.tangents(q, zero, zero)[0]
    for j, step in enumerate(1e-5 * np.eye(5)):
        plus, minus = (dynamics.inverse_dynamics(q + x, zero, zero) for x in (step, -step))
        atol = 1e-7 * np.abs(found).max()
        np.testing.assert_allclose(found[:, j], (plus - minus) / 2e-5, atol=atol)


def test_places_beyond_a_link_are_refused():
    load = {"point": "p", "body": "link", "s": 1.5, "force": FORCE}
    with pytest.raises(SceneError, match=r"s = 1.5"):
        scene_of(document([BODY], loads=[load]))
