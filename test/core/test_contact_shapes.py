"""Signed distances of shapes: against points on their surfaces, and difference quotients."""

import numpy as np
import pytest
from differences import central_difference
from scenes import scene_of
from touching import body_document

from soft_sim_ros.core.compile.scene import compile_scene
from soft_sim_ros.core.contact.shapes import distances

SHAPES = {
    "plane": {"position": [0.1, 0.2, 0.3], "normal": [0.3, -0.5, 1.0]},
    "sphere": {"position": [0.1, -0.2, 0.3], "radius": 0.4},
    "capsule": {"from": [0.1, 0.0, -0.3], "to": [0.3, 0.4, 0.2], "radius": 0.25},
    "cylinder": {"from": [0.1, 0.0, -0.3], "to": [0.3, 0.4, 0.2], "radius": 0.25},
    "box": {"position": [0.1, 0.2, 0.3], "size": [0.4, 0.6, 0.9], "rpy": [0.3, -0.4, 0.9]},
    "ellipsoid": {"position": [0.1, 0.2, 0.3], "semi_axes": [0.3, 0.5, 0.9], "rpy": [0.3, 0.4, 1]},
}


def shaped(kind, **more):
    more = {key: value for key, value in more.items() if value}
    document = body_document(
        at=[0, 0, 0, 5, 5, 5],
        environment=[{kind: "it"} | SHAPES[kind] | more],
        contact={"stiffness": 1e5},
    )
    return compile_scene(scene_of(document)).model.contact


def measured(contact, points):
    out = np.zeros((len(points), 13))
    distances(contact, 0, np.ascontiguousarray(points), out)
    return out[:, 0], out[:, 1:4], out[:, 4:].reshape(-1, 3, 3)


def surface(kind):
    """Return many points on the surface of a shape, in the world, from its definition."""
    a, b = np.meshgrid(np.linspace(0, np.pi, 400), np.linspace(0, 2 * np.pi, 400))
    ball = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], -1).reshape(-1, 3)
    data, contact = SHAPES[kind], shaped(kind)
    axes, centre = contact.rotation[0].reshape(3, 3), contact.centre[0]
    if kind == "sphere":
        local = data["radius"] * ball
    elif kind == "ellipsoid":
        local = np.array(data["semi_axes"]) * ball
    elif kind == "box":
        u, v = np.meshgrid(*[np.linspace(-1, 1, 200)] * 2)
        face = np.stack([u.ravel(), v.ravel(), np.ones(u.size)], axis=-1)
        turned = [np.roll(sign * face, k, axis=1) for k in range(3) for sign in (1, -1)]
        local = np.concatenate(turned)
        local = local * 0.5 * np.array(data["size"])
    else:
        r, half = data["radius"], 0.5 * np.linalg.norm(np.subtract(data["to"], data["from"]))
        z, angle = np.meshgrid(np.linspace(-half, half, 400), np.linspace(0, 2 * np.pi, 400))
        side = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1).reshape(-1, 3)
        if kind == "capsule":
            ends = r * ball + np.sign(ball[:, 2:]) * [0, 0, half]
        else:
            part, angle = np.meshgrid(np.linspace(0, r, 200), np.linspace(0, 2 * np.pi, 400))
            top = np.stack([part * np.cos(angle), part * np.sin(angle), half + 0 * part], axis=-1)
            ends = np.concatenate([top.reshape(-1, 3), top.reshape(-1, 3) * [1, 1, -1]])
        local = np.concatenate([side, ends])
    return centre + local @ axes.T


@pytest.mark.parametrize("kind", [kind for kind in SHAPES if kind != "plane"])
def test_the_distance_is_that_to_the_nearest_point_of_the_surface(kind):
    rng = np.random.default_rng(1)
    points = np.concatenate([rng.uniform(-1.2, 1.5, size=(80, 3)), rng.normal(size=(60, 3)) * 0.15])
    points[80:] += shaped(kind).centre[0]
    d, n, _ = measured(shaped(kind), points)
    cloud = surface(kind)
    brute = np.array([np.linalg.norm(cloud - point, axis=1).min() for point in points])
    coarse = brute - np.abs(d)  # the points are a few mm apart
    assert coarse.min() > -1e-9 and (coarse[np.abs(d) > 0.05] < 4e-4).all() and coarse.max() < 5e-3
    # the nearest point is on the surface: no distance is left there
    assert np.abs(measured(shaped(kind), points - d[:, None] * n)[0]).max() < 1e-12
    assert (d < 0).sum() > 20
    # beyond the surface it grows with the way
    assert np.allclose(measured(shaped(kind), points + 0.1 * n)[0][d > 0], d[d > 0] + 0.1)


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("inside", [False, True])
def test_normal_and_curvature_are_derivatives_of_the_distance(kind, inside):
    if inside and kind in ("plane", "box"):
        with pytest.raises(Exception, match="inside"):
            shaped(kind, inside=True)
        return
    contact = shaped(kind, inside=inside)
    rng = np.random.default_rng(2)
    sign = -1.0 if inside else 1.0
    plain = shaped(kind)
    checked = 0
    for point in rng.uniform(-1.0, 1.2, size=(60, 3)):
        d, n, curved = (part[0] for part in measured(contact, point[None]))
        assert d == sign * measured(plain, point[None])[0][0]
        step = np.full(3, 1e-5)
        slope = central_difference(lambda x: measured(contact, x[None])[0], point, step)[0]
        bend = central_difference(lambda x: measured(contact, x[None])[1][0], point, step)
        if sign * d < 0.0 and not np.allclose(slope, n, atol=1e-4):
            continue  # where two points of the surface are nearest
        assert np.allclose(slope, n, atol=1e-8) and np.allclose(np.linalg.norm(n), 1.0)
        assert np.allclose(bend, curved, atol=1e-5 * (1.0 + np.abs(curved).max()))
        assert np.allclose(curved, curved.T, atol=1e-12 * (1.0 + np.abs(curved).max()))
        checked += 1
    assert checked > 50
