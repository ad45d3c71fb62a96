"""Planar chains run the same kernels without what vanishes in a plane, and lose nothing by it."""

import numpy as np
import pytest
from planes import in_both
from scenes import rod_document, scene_of

from soft_sim_ros.core.algebra.motion_space import PlaneXY, PlaneXZ, Spatial
from soft_sim_ros.core.model.model import in_its_plane
from soft_sim_ros.core.settled import Dynamics, Simulation

PLANES = {
    PlaneXZ: (["bend_y", "stretch", "shear_z"], "y"),
    PlaneXY: (["bend_z", "stretch", "shear_y"], "z"),
}


def document(plane, **changes):
    """Return a rod on a hinge with a mid-rod load and an oblique follower, all in space."""
    strains, axis = PLANES[plane]
    scene = rod_document(strains=strains, order=2, numerics={"step": 0.002})
    scene["materials"]["soft"]["viscosity"] = 500.0
    scene["numerics"]["basis"]["elements"] = 2
    scene["bodies"].insert(
        0,
        {
            "joint": "hinge",
            "kind": "revolute",
            "axis": [float(axis == name) for name in "xyz"],
            "stiffness": 0.3,
            "damping": 0.01,
        },
    )
    rod = scene["bodies"][1]["rod"]
    scene["gravity"] = [1.0, -3.0, -9.0]
    scene["loads"] = [
        {"point": "dead", "body": rod, "s": 0.2, "force": [0.1, 0.05, -0.1], "moment": [0.01] * 3},
        {"point": "tip", "body": rod, "s": 0.4, "force": [-0.1, 0.1, 0.1], "frame": "body"},
    ]
    return scene | changes


@pytest.mark.parametrize("plane", PLANES)
def test_residual_and_tangent_in_the_plane_are_those_in_space(plane):
    dynamics = Dynamics(scene_of(document(plane)))
    flat = in_its_plane(dynamics.model)
    assert isinstance(flat.space, plane)
    rng = np.random.default_rng(7)
    q, v, a = rng.standard_normal((3, dynamics.n))
    for full, pruned in in_both(dynamics, flat, q, v, a):
        assert np.linalg.norm(full) > 0.0
        np.testing.assert_allclose(pruned, full, rtol=0.0, atol=1e-12 * np.abs(full).max())


@pytest.mark.parametrize("plane", PLANES)
def test_a_motion_in_the_plane_is_that_motion_in_space(plane):
    flat = Simulation(scene_of(document(plane)))
    full = Simulation(scene_of(document(plane)), prune=False)
    for simulation in (flat, full):
        simulation.advance(200)
    np.testing.assert_allclose(flat.q, full.q, rtol=0.0, atol=1e-12 * np.abs(full.q).max())
    assert np.abs(full.q).max() > 0.1


def test_what_can_leave_the_plane_is_simulated_in_space():
    """A strain, a hinge or a reference curvature out of the plane each makes the chain spatial."""
    base = document(PlaneXZ)
    twisted = document(PlaneXZ)
    twisted["bodies"][1]["strains"] = ["torsion", "bend_y"]
    twisted["numerics"]["basis"]["order"] = 1
    leaning = document(PlaneXZ)
    leaning["bodies"][0]["axis"] = [0.0, 1.0, 1e-9]
    curved = document(PlaneXZ)
    curved["bodies"][1]["sections"][0]["reference"] = {"curvature": [0.0, 0.0, 1e-9]}
    assert isinstance(in_its_plane(Dynamics(scene_of(base)).model).space, PlaneXZ)
    for scene in (twisted, leaning, curved):
        assert isinstance(in_its_plane(Dynamics(scene_of(scene)).model).space, Spatial)
