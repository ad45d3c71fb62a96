"""Rods held at both ends, and a parallel robot, against solutions in other unknowns."""

import numpy as np
import pytest
from closed import SLACK, at, held_rod
from parallel_robot import (
    AREA,
    DENSITY,
    FORCES,
    GRAVITY,
    HEIGHT,
    LENGTHS,
    PLATFORM,
    TILT,
    hand,
    hinged,
    published_axes,
    robot_document,
)
from scenes import scene_of
from scipy.integrate import solve_bvp

from soft_sim_ros.core.analysis.modes import frequencies, modes
from soft_sim_ros.core.analysis.stability import verdict
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.errors import StaticsFailed
from soft_sim_ros.scene import load_scene

LENGTH, RADIUS, YOUNG = 0.5, 0.01, 1e6
SECTION, SECOND = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4.0


def arch_bvp(ends, weight):
    """Return sag at the middle and force (2,) on the far end of a planar extensible, shearable rod.

    Unknowns x, z, angle (z' = −sin), moment, force along x and z; clamped at the origin along x.
    ends: what is to vanish at the far end.
    """
    shear = YOUNG / 3.0 * SECTION * cowper()

    def rates(s, y):
        _, _, turn, moment, fx, fz = y
        along = fx * np.cos(turn) - fz * np.sin(turn)
        across = fx * np.sin(turn) + fz * np.cos(turn)
        stretch, slide = 1.0 + along / (YOUNG * SECTION), across / shear
        dx = stretch * np.cos(turn) + slide * np.sin(turn)
        dz = -stretch * np.sin(turn) + slide * np.cos(turn)
        # moments about y: m' = −(r' × n)_y
        return np.array(
            [dx, dz, moment / (YOUNG * SECOND), dx * fz - dz * fx, 0.0 * s, weight + 0.0 * s]
        )

    s = np.linspace(0.0, LENGTH, 101)
    guess = np.zeros((6, len(s)))
    guess[0], guess[1] = 0.7 * s, -0.15 * np.sin(np.pi * s / LENGTH)
    guess[2] = 1.2 * np.cos(np.pi * s / LENGTH)

    def both(a, b):
        return np.array([a[0], a[1], a[2], *ends(b)])

    found = solve_bvp(rates, both, s, guess, tol=1e-9, max_nodes=20000)
    assert found.success
    middle = found.sol(LENGTH / 2.0)
    return middle[:2], found.sol(LENGTH)


def cowper():
    """Return Cowper's shear factor of a circle for ν = 1/2."""
    return 6.0 * 1.5 / (7.0 + 3.0)


@pytest.mark.parametrize("kind", ["weld", "ball"])
def test_a_rope_held_at_both_ends_hangs_as_its_boundary_value_problem(kind):
    weight = SLACK["density"] * SECTION * 9.81
    scene = scene_of(
        held_rod(
            [at(kind, [0.35, 0.0, 0.0])],
            gravity=[0, 0, -9.81],
            initial={"state": "equilibrium", "strains": {"rod/s": {"bend_y": -1.0}}},
            numerics={"step": 1e-3, "basis": {"order": 6, "elements": 2}},
        )
    )
    simulation = Simulation(scene)
    dynamics, q = simulation.dynamics, simulation.q
    last = (lambda b: b[2]) if kind == "weld" else (lambda b: b[3])
    middle, far = arch_bvp(lambda b: (b[0] - 0.35, b[1], last(b)), weight)
    poses = dynamics.node_poses(q)
    found = simulation.sampler(3).poses()[1]
    np.testing.assert_allclose(found[[0, 2]], middle, atol=1e-6 * LENGTH)
    np.testing.assert_allclose(poses[-1, :3, 3], [0.35, 0.0, 0.0], atol=1e-12)
    reaction = simulation.reactions()["far"]
    np.testing.assert_allclose(reaction.force[[0, 2]], far[4:6], atol=1e-6 * weight)
    np.testing.assert_allclose(reaction.moment[1], far[3], atol=1e-6 * weight * LENGTH)
    # and it stays there
    simulation.advance(50)
    np.testing.assert_allclose(simulation.q, q, atol=1e-9)


@pytest.mark.parametrize(
    ("kind", "root"), [("weld", 4.730040744862704), ("ball", 3.926602312047919)]
)
def test_a_beam_held_at_both_ends_swings_as_the_closed_form(kind, root):
    """Clamped–clamped and clamped–pinned, without rotary inertia: Euler and Bernoulli."""
    scene = scene_of(
        held_rod(
            [at(kind, [LENGTH, 0.0, 0.0])],
            rod={"model": "euler_bernoulli", "strains": ["bend_z"]},
            numerics={"step": 1e-3, "basis": {"order": 8}},
        )
    )
    dynamics = Dynamics(scene)
    expected = root**2 * np.sqrt(YOUNG * SECOND / (SLACK["density"] * SECTION * LENGTH**4))
    assert frequencies(dynamics)[0] * 2.0 * np.pi == pytest.approx(expected, rel=1e-6)
    # shapes keep the far end where it is
    shapes = modes(dynamics, np.zeros(dynamics.n))[1]
    far = dynamics.jacobians(np.zeros(dynamics.n), np.zeros(dynamics.n))[0][-1][3:]
    assert np.abs(far @ shapes).max() < 1e-9 * np.abs(shapes).max()


def test_a_straight_rod_twisted_at_a_held_end_buckles_where_its_determinant_vanishes():
    """Both ends clamped and not to be moved: EI w'''' − i M w''' − T w'' = 0 of w = y + i z.

    Without pull, four clamped conditions ask that the determinant vanishes: M L / EI = 8.9868 =
    2 · 4.4934, tan x = x. The rod's own shear, extension and torsion change that by less.
    """
    rod = {"model": "kirchhoff", "strains": ["torsion", "bend_y", "bend_z"]}
    torsion = YOUNG / 3.0 * 2.0 * SECOND

    def unstable(moment):
        turn = moment * LENGTH / torsion
        end = at("slider", [LENGTH, 0.0, 0.0], axis=[1, 0, 0])
        end["frames"][1]["world"]["rpy"] = [float((turn + np.pi) % (2.0 * np.pi) - np.pi), 0.0, 0.0]
        dynamics = Dynamics(
            scene_of(held_rod([end], rod=rod, numerics={"step": 1e-3, "basis": {"order": 8}}))
        )
        q = np.zeros(dynamics.n)
        q[0] = turn / LENGTH
        found = equilibrium(dynamics, q, stable=False, check=False)
        assert found[0] == pytest.approx(q[0])
        dynamics.reactions_of_constraints(found)
        still = np.zeros(dynamics.n)
        data = dynamics.scratch
        dynamics.residual(found, still, still, data)
        return verdict(dynamics).unstable

    critical = 2.0 * 4.493409457909064 * YOUNG * SECOND / LENGTH
    assert unstable(0.999 * critical) == 0
    assert unstable(1.001 * critical) > 0


def test_a_gap_that_closes_past_what_the_rod_carries_is_refused():
    """A straight rod pushed at its end buckles; a bent one gives way."""
    far = [at("weld", [0.45, 0.0, 0.0])]
    with pytest.raises(StaticsFailed, match="loses stability"):
        Simulation(scene_of(held_rod(far, initial={"state": "equilibrium"})))


def test_a_platform_on_six_rods_stands_where_its_lengths_say():
    """Forces are those of an own shooting solution, and the platform is in balance."""
    weight = DENSITY * AREA * GRAVITY

    def forces(axes):
        document = robot_document(axes, order=8)
        document["constraints"].append(hand())
        dynamics = Dynamics(scene_of(document))
        q = np.zeros(dynamics.n)
        q[dynamics.compiled.chain.columns("float")] = [0.0, TILT, 0.0, *HEIGHT]
        q = equilibrium(dynamics, q, stable=False, check=False)
        found = dynamics.reactions_of_constraints(q)
        base = [
            found[f"hole_{i + 1}"].force - [0.0, 0.0, weight * length]
            for i, length in enumerate(LENGTHS)
        ]
        return np.array(base), found["hand"]

    scale = np.abs(FORCES).max()
    base, _ = forces(None)
    expected = np.array([hinged(i)[:3] for i in range(6)])
    np.testing.assert_allclose(base, expected, atol=1e-6 * scale)
    # the published ones are of ends that are turned a little: see parallel_robot.py; their eight
    # digits of the lengths leave 1e-8 m, some 1e-4 N of a rod that is nearly straight
    base, left = forces(published_axes())
    np.testing.assert_allclose(base, FORCES, atol=1e-4 * scale)
    assert np.abs(left.force).max() < 1e-4 * scale


def test_a_parallel_robot_that_is_let_go_keeps_its_energy():
    document = robot_document(None, order=8)
    document["constraints"].append(hand() | {"end": 0.002})
    document["numerics"] |= {"integrator": "implicit_midpoint", "step": 2e-4}
    simulation = Simulation(scene_of(document))
    simulation.advance(60)
    kinetic, elastic, _, _, work, lost, residual = simulation.ledger()
    assert kinetic > 1e-7
    assert (work, lost) == (0.0, 0.0)
    assert abs(residual) < 1e-9 * elastic


def test_the_packaged_robot_carries_its_platform_where_its_lengths_say():
    """By itself, with nobody's hand at the platform; its rods neither stretch nor shear."""
    simulation = Simulation(load_scene("parallel_robot"))
    found = simulation.reactions()
    pose = simulation.dynamics.node_poses(simulation.q)[-1]
    np.testing.assert_allclose(pose[:3, 3], HEIGHT, atol=2e-4)
    np.testing.assert_allclose(pose[:3, :3], PLATFORM, atol=2e-3)
    forces = np.array([found[f"hole_{i + 1}"].force for i in range(6)])
    np.testing.assert_allclose(forces.sum(axis=0), [0.0, 0.0, -0.1 * GRAVITY], atol=1e-9)
    for i in (0, 2):
        weight = [0.0, 0.0, DENSITY * AREA * GRAVITY * LENGTHS[i]]
        # straight rods push much harder for some 1e-5 m
        np.testing.assert_allclose(
            forces[i] - weight, hinged(i)[:3], atol=0.05 * np.abs(FORCES).max()
        )
