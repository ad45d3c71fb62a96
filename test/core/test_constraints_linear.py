"""Linear systems, inverse kinematics and verdicts of closed arms, against difference quotients."""

import copy

import numpy as np
import pytest
from closed import SLACK, held_rod
from scenes import scene_of

from soft_sim_ros.core.analysis.inverse_kinematics import inverse_kinematics, tip_sensitivity
from soft_sim_ros.core.analysis.linearisation import linearise
from soft_sim_ros.core.analysis.modes import complex_modes
from soft_sim_ros.core.analysis.statics import equilibrium, unstable_directions
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import TargetUnreachable


def pushed_arm(constraints, **rest):
    """Return a damped rod under its weight, bent by moments in two halves."""
    parts = [{"moment": f"bend_{half}", "rod": "rod", "section": half, "strain": "bend_y",
              "limits": [-0.02, 0.02]} for half in ("near", "far")]  # fmt: skip
    section = {"material": "soft", "cross_section": {"shape": "circle", "radius": 0.01}}
    sections = [{"name": name, "length": 0.25} | section for name in ("near", "far")]
    return (
        held_rod(
            constraints,
            rod={"sections": sections, "strains": ["bend_y", "bend_z", "stretch"]},
            gravity=[0.0, 0.0, -1.0],
            materials={"soft": SLACK | {"viscosity": 2e3}},
            actuators=parts,
            initial={"state": "equilibrium"},
            numerics={"step": 1e-3, "basis": {"order": 3}},
        )
        | rest
    )


RAIL = {"name": "rail", "kind": "line", "axis": [1.0, 0.0, 0.0],
        "frames": [{"body": "rod"}, {"world": {"position": [0.4, 0.0, 0.0]}}]}  # fmt: skip


@pytest.fixture(scope="module")
def railed():
    """Return a rod whose end glides along a rail, at rest."""
    simulation = Simulation(scene_of(pushed_arm([RAIL])))
    return simulation.dynamics, simulation.q.copy()


def test_a_linear_system_moves_as_the_arm_does_along_what_constraints_leave_free(railed):
    """Against accelerations of states that are put back onto the constraints."""
    dynamics, q = railed
    efforts = np.array([2e-3, -1e-3])
    q = equilibrium(dynamics, q, efforts=efforts, check=False)
    system = linearise(dynamics, q, efforts)
    free = system.ways.shape[1]
    assert free == dynamics.n - 2
    assert np.abs(system.drift).max() < 1e-6 * np.abs(system.A).max()
    rng, step = np.random.default_rng(3), 1e-6
    inverse = np.linalg.pinv(system.ways)
    for _ in range(3):
        x = rng.normal(size=2 * free)
        u = np.concatenate([rng.normal(size=2) * 1e-2, np.zeros(6)])
        found = []
        for sign in (1.0, -1.0):
            moved = dynamics.met(
                q + sign * step * (system.ways @ x[:free]), sign * step * (system.ways @ x[free:])
            )
            found.append(inverse @ dynamics.forward_dynamics(*moved, efforts + sign * step * u[:2]))
        quotient = (found[0] - found[1]) / (2.0 * step)
        told = (system.A @ x + system.B @ u)[free:]
        np.testing.assert_allclose(quotient, told, atol=2e-6 * np.abs(told).max())


def test_a_damped_beam_held_at_both_ends_decays_as_the_closed_form():
    """Kelvin and Voigt: s² + (3η/E) ω² s + ω² = 0 of every mode, clamped and clamped.

    Bending stretches fibres, whose viscosity is Trouton's, 3η of the shear viscosity η.
    """
    length, radius, viscosity = 0.5, 0.01, 3e3
    end = {"name": "far", "kind": "weld", "frames": [{"body": "rod"}]}
    document = held_rod(
        [end],
        rod={"model": "euler_bernoulli", "strains": ["bend_z"]},
        materials={"soft": SLACK | {"viscosity": viscosity}},
        numerics={"step": 1e-3, "basis": {"order": 8}},
    )
    dynamics = Dynamics(scene_of(document))
    found = complex_modes(dynamics, np.zeros(dynamics.n)).values
    for root in (4.730040744862704, 7.853204624095838):
        bending = 1e6 * np.pi * radius**4 / 4.0 / (1000.0 * np.pi * radius**2)
        square = bending * (root / length) ** 4
        damping = 0.5 * 3.0 * viscosity / 1e6 * square
        expected = -damping + 1j * np.sqrt(square - damping**2)
        assert np.abs(found - expected).min() < 2e-4 * abs(expected)


def test_a_constant_push_ends_where_the_linear_system_says(railed):
    dynamics, q = railed
    system, push = linearise(dynamics, q), np.array([1e-5, -2e-5])
    ends = [equilibrium(dynamics, q, efforts=s * push, check=False) for s in (1.0, -1.0)]
    tips = [dynamics.node_poses(x)[-1, :3, 3] for x in ends]
    told = system.static_gain()[:3, :2] @ push
    np.testing.assert_allclose(0.5 * (tips[0] - tips[1]), told, atol=1e-6 * np.abs(told).max())
    np.testing.assert_allclose(told[1:], 0.0, atol=1e-12)  # the rail is along x


def test_the_slope_of_an_equilibrium_is_its_difference_quotient(railed):
    dynamics, q = railed
    efforts, step = np.array([1e-3, 1e-3]), 1e-6
    q = equilibrium(dynamics, q, efforts=efforts, check=False)
    slope = tip_sensitivity(dynamics, q, efforts).q
    for i in range(2):
        shift = step * np.eye(2)[i]
        ends = [
            equilibrium(dynamics, q, efforts=efforts + sign * shift, check=False)
            for sign in (1.0, -1.0)
        ]
        quotient = (ends[0] - ends[1]) / (2.0 * step)
        np.testing.assert_allclose(slope[:, i], quotient, atol=1e-5 * np.abs(quotient).max())


def test_inverse_kinematics_moves_a_carriage_along_its_rail(railed):
    dynamics, q = railed
    goal = dynamics.node_poses(q)[-1, :3, 3] + [-0.01, 0.0, 0.0]
    reach = inverse_kinematics(dynamics, goal, check=False)
    assert reach.reached
    found = equilibrium(dynamics, q, efforts=reach.efforts, check=False)
    np.testing.assert_allclose(dynamics.node_poses(found)[-1, :3, 3], goal, atol=1e-8)
    with pytest.raises(TargetUnreachable) as caught:  # beside the rail
        inverse_kinematics(dynamics, goal + np.array([0.0, 0.02, 0.0]), check=False, tries=1)
    assert caught.value.distance == pytest.approx(0.02, rel=1e-3)


def test_an_arm_stands_while_it_is_held_and_falls_when_it_is_let_go():
    """A rod too heavy to stand by itself, held at its top: the verdict asks what is held now."""
    upright = {"position": [0.0, 0.0, 0.0], "rpy": [0.0, -np.pi / 2.0, 0.0]}
    # Greenhill: a rod falls beyond q L³ / EI = 7.837
    heavy = {"young_modulus": 1e5, "poisson_ratio": 0.5, "density": 1000.0}
    area, second = np.pi * 1e-4, np.pi * 1e-8 / 4.0
    weight = 12.0 * 1e5 * second / 0.5**3 / (1000.0 * area)
    document = held_rod(
        [{"name": "top", "kind": "line", "axis": [1.0, 0.0, 0.0], "frames": [{"body": "rod"}]}],
        base=upright,
        gravity=[0.0, 0.0, -weight],
        materials={"soft": heavy},
        rod={"strains": ["bend_y", "bend_z"]},
        numerics={"step": 1e-3, "basis": {"order": 4}},
    )
    simulation = Simulation(scene_of(document))
    dynamics, still = simulation.dynamics, np.zeros(simulation.n_coordinates)

    def leaves(time=0.0):
        dynamics.reactions_of_constraints(still, time=time)
        dynamics.residual(still, still, still, dynamics.scratch)
        return unstable_directions(dynamics, time=time)

    assert leaves() == 0
    held = simulation.state()
    simulation.release("top")
    assert leaves() == 2
    simulation.restore(held)
    assert leaves() == 0
    simulation.release("top")
    simulation.hold("top", here=True)
    assert leaves() == 0


def test_an_equilibrium_is_that_of_where_an_end_was_caught():
    document = pushed_arm([RAIL | {"kind": "ball"}])
    document["constraints"][0].pop("axis")
    simulation = Simulation(scene_of(document))
    dynamics = simulation.dynamics
    simulation.release("rail")
    simulation.advance(30)
    simulation.hold("rail", here=True)
    caught = dynamics.node_poses(simulation.q)[-1, :3, 3]
    assert abs(caught[2]) > 1e-4
    q = equilibrium(dynamics, simulation.q, check=False)
    np.testing.assert_allclose(dynamics.node_poses(q)[-1, :3, 3], caught, atol=1e-10)
    simulation.advance(20)  # and it is held there still
    np.testing.assert_allclose(dynamics.node_poses(simulation.q)[-1, :3, 3], caught, atol=1e-10)


def test_a_twin_of_the_equations_holds_what_they_hold():
    dynamics = Dynamics(scene_of(pushed_arm([RAIL])))
    dynamics.scratch.closed.held[0, 0] = 0.0
    assert not copy.deepcopy(dynamics).constraints.acting(0.0).any()
