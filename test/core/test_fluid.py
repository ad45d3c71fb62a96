"""The surrounding fluid in the equations of motion: its wrench, its tangent, its energy."""

import numpy as np
import pytest
from differences import central_difference
from forests import tree_document
from planes import in_both
from scenes import random_state, rod_document, scene_of
from waters import CURRENT, HULL, WATER, places, velocities, wet_zoo, without_fluid, work_of

from soft_sim_ros.core.accuracy.unwritten import is_unwritten
from soft_sim_ros.core.algebra.motion_space import PlaneXZ
from soft_sim_ros.core.analysis.port_hamiltonian import PortHamiltonian
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics import field, spatial
from soft_sim_ros.core.model.model import in_its_plane
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import SceneError

TIME = 0.7


@pytest.fixture(scope="module", params=["split", "whole"])
def zoo(request):
    return Dynamics(scene_of(wet_zoo(drag_law=request.param)))


def wet_tree():
    """Rods on rods, a ring along one of them, a second root, all in the current."""
    document = tree_document(base={"position": [0.1, 0.2, -0.3], "rpy": [0.4, -0.7, 1.1]})
    document["fluid"] = WATER | {"current": CURRENT, "lift": 0.2}
    for body in document["bodies"]:
        if body.get("rigid_body") in ("palm", "ring"):
            body["fluid"] = HULL
    return document


def current(t):
    return np.array([0.3 + 0.5 * t, 0.2 * np.sin(t + 1), -0.4 + 0.1 * t**2])


def current_rate(t):
    return np.array([0.5, 0.2 * np.cos(t + 1), 0.2 * t])


def off_by(dynamics, which, seed):
    """Return how far the tangent is off its difference quotient, relative to its entries."""
    state = list(random_state(dynamics, seed))
    exact = dynamics.tangents(*state, time=TIME)[which]

    def residual(x):
        moved = [*state]
        moved[which] = x
        return dynamics.inverse_dynamics(*moved, time=TIME)

    # the residual is linear in the accelerations: a large step has the least round-off
    size = np.full(dynamics.n, 1.0 if which == 2 else 1e-4)
    quotient = central_difference(
        residual, state[which], size / np.maximum(dynamics.model.weight, 1e-3)
    )
    scale = np.sqrt(np.outer(*2 * [np.abs(np.diag(exact)) + 1e-12]))
    return np.max(np.abs(exact - quotient) / (scale + np.abs(exact)))


@pytest.mark.parametrize("which", [0, 1, 2])
def test_the_tangent_of_a_forest_in_a_fluid_is_its_difference_quotient(which):
    assert off_by(Dynamics(scene_of(wet_tree())), which, 2) < 1e-7


@pytest.mark.parametrize("which", [0, 1, 2])
def test_the_tangent_in_a_fluid_is_its_difference_quotient(zoo, which):
    assert off_by(zoo, which, 3) < 1e-7
    state = random_state(zoo, 3)
    exact = zoo.tangents(*state, time=TIME)[which]
    dry = Dynamics(scene_of(without_fluid(wet_zoo()))).tangents(*state)[which]
    assert np.abs(exact - dry).max() > 1e-3 * np.abs(dry).max()


def test_where_nothing_flows_past_drag_has_no_slope():
    """|v| v is differentiable at v = 0, and no more than that."""
    still = wet_zoo(current=[0, 0, 0], viscous_normal=0.0, viscous_tangential=0.0)
    dynamics = Dynamics(scene_of(still))
    q, v, a = random_state(dynamics, 5)
    at_rest = dynamics.tangents(q, 0 * v, a)[1]
    smooth = wet_zoo(
        current=[0, 0, 0], drag_normal=0.0, drag_tangential=0.0, lift=0.0, viscous_normal=0.0,
        viscous_tangential=0.0,
    )  # fmt: skip
    without = Dynamics(scene_of(smooth)).tangents(q, 0 * v, a)[1]
    np.testing.assert_allclose(at_rest[6:20], without[6:20], atol=1e-12 * np.abs(without).max())
    still_there = dynamics.inverse_dynamics(q, 0 * v, a)
    off = [
        (dynamics.inverse_dynamics(q, h * v, a) - still_there) / h - at_rest @ v
        for h in (1e-3, 1e-4)
    ]
    assert np.linalg.norm(off[1]) == pytest.approx(0.1 * np.linalg.norm(off[0]), rel=1e-2)


def pushed(dynamics, q, v, a):
    """Return the force (n,) of the fluid from world axes: what its momentum changes by, drag …"""
    fluid, h = dynamics.model.fluid, 1e-5

    def impulse(s):
        """Momentum that bodies gave to the fluid, along fixed axes: it turns with them."""
        at, rates = q + s * v + 0.5 * s * s * a, v + s * a
        turn = places(dynamics, at)[:, :3, :3]
        flow = velocities(dynamics, at, rates)
        own = np.einsum("kji,kj->ki", turn, flow[:, 3:] - current(TIME + s))
        spin = np.einsum("kji,kj->ki", turn, flow[:, :3])
        linear = np.einsum("kij,kj->ki", turn, fluid.added[:, 3:] * own)
        return np.einsum("kij,kj->ki", turn, fluid.added[:, :3] * spin), linear

    late, early = impulse(h), impulse(-h)
    moments = -(late[0] - early[0]) / (2 * h)
    forces = -(late[1] - early[1]) / (2 * h)
    poses, flow = places(dynamics, q), velocities(dynamics, q, v)
    past = flow[:, 3:] - current(TIME)
    moments -= np.cross(past, impulse(0.0)[1])
    gravity = np.array([0.7, -1.3, -9.0])
    forces -= fluid.displaced[:, None] * (gravity - current_rate(TIME))
    for k, pose in enumerate(poses):
        turn = pose[:3, :3]
        v_r, w = turn.T @ past[k], turn.T @ flow[k, :3]
        drag = (fluid.quadratic[k, 3:] * np.linalg.norm(v_r) + fluid.viscous[k, 3:]) * v_r
        if fluid.law[k] == 0:  # Taylor: friction against the flow, pressure across it
            friction, across = fluid.quadratic[k, 3], v_r * [0.0, 1.0, 1.0]
            pressure = fluid.quadratic[k, 3:] - friction
            drag = friction * np.linalg.norm(v_r) * v_r + fluid.viscous[k, 3:] * v_r
            drag += pressure * np.linalg.norm(across) * across
        brake = (fluid.quadratic[k, :3] * np.linalg.norm(w) + fluid.viscous[k, :3]) * w
        lift = -fluid.lift[k] * np.linalg.norm(v_r)
        lift = np.cross(lift, v_r)
        depth = gravity @ pose[:3, 3] + 2.0 * np.linalg.norm(gravity)
        end = np.array([fluid.end[k] * depth, 0.0, 0.0])
        forces[k] += turn @ (lift - drag + end)
        moments[k] -= turn @ brake
    return work_of(dynamics, q, moments, forces)


@pytest.mark.parametrize("seed", [1, 2])
def test_the_wrench_of_the_fluid_is_what_its_momentum_says_in_fixed_axes(zoo, seed):
    q, v, a = random_state(zoo, seed)
    dry = Dynamics(scene_of(without_fluid(wet_zoo())))
    found = dry.inverse_dynamics(q, v, a) - zoo.inverse_dynamics(q, v, a, time=TIME)
    expected = pushed(zoo, q, v, a)
    np.testing.assert_allclose(found, expected, atol=2e-8 * np.abs(expected).max())
    assert np.abs(expected).max() > 1.0


def test_mass_coriolis_gravity_damping_and_the_rest_add_up_to_the_residual(zoo):
    q, v, a = random_state(zoo, 4)
    whole = zoo.inverse_dynamics(q, v, a, time=TIME)
    dry = Dynamics(scene_of(without_fluid(wet_zoo())))
    loads = dry.inverse_dynamics(q, v, a) - (
        dry.mass_matrix(q) @ a + dry.coriolis_matrix(q, v) @ v + dry.gravity_force(q)
        + dry.elastic_force(q) + dry.damping_matrix(q) @ v
    )  # fmt: skip
    parts = (
        zoo.mass_matrix(q) @ a + zoo.coriolis_matrix(q, v) @ v + zoo.gravity_force(q)
        + zoo.elastic_force(q) + zoo.damping_matrix(q) @ v - zoo.fluid_force(q, v, TIME)
    )  # fmt: skip
    np.testing.assert_allclose(parts + loads, whole, atol=1e-9 * np.abs(whole).max())
    for name in ("mass_matrix", "gravity_force", "damping_matrix"):
        one, other = getattr(zoo, name)(q), getattr(dry, name)(q)
        assert np.abs(one - other).max() > 1e-3 * np.abs(other).max()


def test_added_mass_keeps_the_rate_of_m_less_twice_c_skew(zoo):
    q, v, _ = random_state(zoo, 6)
    rate = zoo.mass_matrix_derivative(q) @ v
    skew = rate - 2.0 * zoo.coriolis_matrix(q, v)
    assert np.abs(skew + skew.T).max() < 1e-10 * np.abs(rate).max()


def test_gravity_force_is_the_gradient_of_the_energy_of_weight_and_buoyancy(zoo):
    q, v, _ = random_state(zoo, 7)
    size = np.full(zoo.n, 1e-4) / zoo.model.weight
    slope = central_difference(lambda x: np.array([zoo.energies(x, 0 * v)[2]]), q, size)[0]
    np.testing.assert_allclose(zoo.gravity_force(q), slope, atol=1e-8 * np.abs(slope).max())
    kinetic = zoo.energies(q, v)[0]
    assert kinetic == pytest.approx(0.5 * v @ zoo.mass_matrix(q) @ v, rel=1e-12)


def flat(fluid):
    document = rod_document(strains=["bend_y", "stretch", "shear_z"], order=2)
    document["bodies"].insert(0, {"joint": "hinge", "kind": "revolute", "axis": [0, 1, 0]})
    document["bodies"].append(
        {"rigid_body": "fin", "mass": 0.2, "fluid": {
            "semi_axes": [0.1, 0.05, 0.02], "drag": 1.0, "lift": [0.4, -0.2, 0.3],
            "center": {"position": [0.02, 0.01, 0.0], "rpy": [0.3, 0.2, 0.1]}}}
    )  # fmt: skip
    return document | {"gravity": [1.0, -3.0, -9.0], "fluid": WATER | fluid}


def test_in_a_plane_the_fluid_does_what_it_does_in_space():
    """A current out of the plane as well: what it pushes out there, the sections bear."""
    document = flat({"current": [0.4, -0.7, 0.3], "lift": 0.2, "surface": 1.0})
    document["bodies"][1]["fluid"] = {"dry_ends": ["end"]}
    dynamics = Dynamics(scene_of(document))
    pruned = in_its_plane(dynamics.model)
    assert isinstance(pruned.space, PlaneXZ)
    rng = np.random.default_rng(7)
    q, v, a = rng.standard_normal((3, dynamics.n))
    for full, planar in in_both(dynamics, pruned, q, v, a):
        np.testing.assert_allclose(planar, full, rtol=0.0, atol=1e-12 * np.abs(full).max())


def test_the_internal_wrench_in_a_current_is_that_of_the_section_law():
    """At rest, where the continuum's balance holds: the better, the higher the order."""
    norms = []
    for order in (2, 4, 6):
        document = rod_document(
            order=order, gravity=(0, 0, -9.81), material={"density": 1500.0, "viscosity": 1e3}
        )
        document["fluid"] = WATER | {"current": [0.1, 0.3, 0.2], "lift": [0.2, 0.1, -0.1]}
        dynamics = Dynamics(scene_of(document))
        q = equilibrium(dynamics, check=False)
        norms.append(field.norms(field.fields(dynamics, q)).balance)
        wrench = dynamics.internal_wrench(q)
        assert np.abs(wrench.before[-1]).max() < 1e-10 * np.abs(wrench.after).max()
    assert norms[2][3:].max() < 1e-2 * norms[0][3:].max()
    assert norms[2][3:].max() < 2e-3 * 500.0 * np.pi * 0.03**2 * 9.81


def test_the_port_hamiltonian_form_refuses_a_fluid_by_name():
    dynamics = Dynamics(scene_of(rod_document(order=1) | {"fluid": WATER}))
    with pytest.raises(SceneError, match=r"fluid.density = 1000.*no fluid in the port-Hamil"):
        PortHamiltonian(dynamics)


def test_the_spatial_formulation_has_the_same_fluid_by_its_momentum_in_the_fixed_frame(zoo):
    for seed in range(3):
        q, v, a = random_state(zoo, seed)
        material = zoo.inverse_dynamics(q, v, a, time=TIME)
        fixed = spatial.inverse_dynamics(zoo, q, v, a, time=TIME)
        np.testing.assert_allclose(fixed, material, atol=1e-13 * np.abs(material).max())


def test_numerics_that_nobody_wrote_are_chosen_with_the_fluid():
    document = rod_document(strains=["bend_y"], gravity=(0, 0, -9.81), material={"density": 1300.0})
    del document["numerics"]
    scene = scene_of(document | {"fluid": WATER | {"current": [0.0, 0.0, 0.4]}})
    assert is_unwritten(scene)
    chosen = Simulation(scene)
    assert chosen.scene.fluid is not None
    chosen.advance(5)
    assert np.isfinite(chosen.q).all()
