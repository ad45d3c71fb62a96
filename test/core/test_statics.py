"""Equilibria against closed forms and an independent boundary value solver."""

import numpy as np
import pytest
from cosserat_bvp import solve_rod
from scenes import ALL, rod, rod_document, scene_of
from scipy.integrate import solve_bvp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.errors import StaticsFailed

LENGTH, RADIUS, E, G = 0.6, 0.03, 1e6, 1e6 / 3
INERTIA = np.pi * RADIUS**4 / 4
EI = E * INERTIA


def tip(dynamics, q):
    return dynamics.node_poses(q)[-1]


@pytest.mark.parametrize("turns", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("axis", [1, 2])
def test_a_tip_moment_rolls_the_rod_into_a_circle(turns, axis):
    dynamics = rod()
    wrench = np.zeros(6)
    wrench[axis] = 2 * np.pi * turns * EI / LENGTH
    pose = tip(dynamics, equilibrium(dynamics, tip=wrench, tip_follows=True))
    angle = 2 * np.pi * turns
    expected = np.zeros(3)
    expected[0] = LENGTH * np.sin(angle) / angle
    # a moment about +y turns x towards -z, about +z towards +y
    expected[{1: 2, 2: 1}[axis]] = {1: -1, 2: 1}[axis] * LENGTH * (1 - np.cos(angle)) / angle
    np.testing.assert_allclose(pose[:3, 3], expected, atol=1e-9)


def elastica_tip(force):
    """Tip (x, y) of an inextensible cantilever along x with a dead transverse tip force along y.

    With θ the slope and α its tip value, EI θ'² = 2 F (sin α − sin θ); elliptic integrals with
    k² = (1 + sin α)/2 and sin φ = sin((θ + π/2)/2)/k, see any text on the elastica.
    """
    load = np.sqrt(force / EI)

    def parts(alpha):
        k2 = 0.5 * (1 + np.sin(alpha))
        phi = np.arcsin(np.sqrt(0.5 / k2))
        return k2, phi

    def missing(alpha):
        k2, phi = parts(alpha)
        return (ellipk(k2) - ellipkinc(phi, k2)) / load - LENGTH

    alpha = brentq(missing, 1e-9, np.pi / 2 - 1e-12)
    k2, phi = parts(alpha)
    y = LENGTH - 2.0 / load * (ellipe(k2) - ellipeinc(phi, k2))
    x = np.sqrt(2 * EI * np.sin(alpha) / force)
    return np.array([x, y])


@pytest.mark.parametrize("force", [0.5, 5.0, 20.0])
def test_large_deflection_of_a_cantilever_is_the_elastica(force):
    dynamics = rod(strains=["bend_z"], order=12, nodes=60)
    q = equilibrium(dynamics, tip=np.array([0, 0, 0, 0, force, 0]))
    np.testing.assert_allclose(tip(dynamics, q)[:2, 3], elastica_tip(force), atol=1e-8)


def cosserat_stiffness(shear=1.0):
    area = np.pi * RADIUS**2
    return [2 * G * INERTIA, EI, EI, E * area, shear * G * area, shear * G * area]


def test_droop_under_own_weight_is_that_of_the_cosserat_equations():
    dynamics = rod(order=9, nodes=60, gravity=(0, 0, -9.81), section={"shear_correction": 1.0})
    pose = tip(dynamics, equilibrium(dynamics))
    weight = 1000.0 * np.pi * RADIUS**2 * 9.81
    position, turn = solve_rod(
        LENGTH,
        cosserat_stiffness(),
        lambda s: np.array([0, 0, 0, 1.0, 0, 0]),
        density_force=(0, 0, -weight),
    )
    np.testing.assert_allclose(pose[:3, 3], position, atol=1e-8)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=1e-7)
    # the published independent value of the task the peers are compared on, (0.404331, -0.414341)
    assert abs(pose[0, 3] - 0.404331) < 3e-4 and abs(pose[2, 3] + 0.414341) < 3e-4


def test_a_pre_curved_arc_under_a_load_in_space_is_that_of_the_cosserat_equations():
    curvature = [2.0, -1.0, 3.0]
    section = {"shear_correction": 0.9, "reference": {"curvature": curvature}}
    dynamics = rod(order=10, nodes=60, section=section)
    force, moment = np.array([1.0, -2.0, 1.5]), np.array([0.1, -0.05, 0.2])
    pose = tip(dynamics, equilibrium(dynamics, tip=np.concatenate([moment, force])))
    rest = np.array([*curvature, 1.0, 0.0, 0.0])
    position, turn = solve_rod(
        LENGTH, cosserat_stiffness(0.9), lambda s: rest, tip_force=force, tip_moment=moment
    )
    np.testing.assert_allclose(pose[:3, 3], position, atol=1e-7)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=1e-6)


@pytest.mark.parametrize(("offset", "sign"), [([0.02, 0.0], 1), ([-0.02, 0.0], -1)])
def test_a_tendon_beside_the_axis_bends_the_rod_into_an_arc_towards_itself(offset, sign):
    """With bending only, ℓ = ∫ (1 − d κ) ds, so κ = T d / EI; a tendon at +y bends towards +y."""
    document = rod_document(strains=["bend_y", "bend_z"])
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": offset}]
    dynamics = Dynamics(scene_of(document))
    tension = 20.0
    q = equilibrium(dynamics, efforts=np.array([tension]))
    angle = tension * 0.02 / EI * LENGTH
    expected = [np.sin(angle) / angle * LENGTH, sign * (1 - np.cos(angle)) / angle * LENGTH, 0]
    np.testing.assert_allclose(tip(dynamics, q)[:3, 3], expected, atol=1e-9)
    assert dynamics.ports(q, 0 * q)[0][0] == pytest.approx(0.02 * angle, rel=1e-9)


def test_a_tendon_also_shortens_an_extensible_rod():
    """An axial tendon compresses: T = −EA (Γ − 1), exactly, and its port has moved by that."""
    document = rod_document()
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.0, 0.0]}]
    dynamics = Dynamics(scene_of(document))
    q = equilibrium(dynamics, efforts=np.array([50.0]))
    shortening = 50.0 / (E * np.pi * RADIUS**2) * LENGTH
    assert tip(dynamics, q)[0, 3] == pytest.approx(LENGTH - shortening, abs=1e-10)
    assert dynamics.ports(q, 0 * q)[0][0] == pytest.approx(shortening, rel=1e-9)


def test_a_moment_actuator_bends_its_section_by_tau_over_ei():
    document = rod_document(strains=ALL[:4])
    document["actuators"] = [{"moment": "m", "rod": "rod", "section": "s", "strain": "bend_y"}]
    dynamics = Dynamics(scene_of(document))
    q = equilibrium(dynamics, efforts=np.array([0.7]))
    assert dynamics.ports(q, 0 * q)[0][0] == pytest.approx(0.7 / EI * LENGTH, rel=1e-12)
    angle = 0.7 / EI * LENGTH
    assert tip(dynamics, q)[2, 3] == pytest.approx(-(1 - np.cos(angle)) / angle * LENGTH, abs=1e-9)


def test_scheduled_point_load_inside_the_rod_leaves_the_rest_straight():
    document = rod_document(
        strains=["bend_z"],
        order=10,
        loads=[{"point": "p", "body": "rod", "s": 0.2, "force": [0, 3.0, 0]}],
    )
    dynamics = Dynamics(scene_of(document))
    poses = dynamics.node_poses(equilibrium(dynamics))
    # beyond the load the rod carries nothing: its end is straight ahead of the loaded section
    loaded = next(p for p in poses if np.isclose(np.linalg.norm(poses[-1] - p), 0.4))
    np.testing.assert_allclose(poses[-1][:3, 3], loaded[:3, 3] + 0.4 * loaded[:3, 0], atol=1e-10)
    assert loaded[1, 3] > 0.001


def test_a_load_path_that_ends_says_how_far_it_got():
    """Pulling a rod apart with a linear section law has no limit, pushing tendons through has."""
    document = rod_document(strains=["stretch"], order=1)
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.0, 0.0]}]
    dynamics = Dynamics(scene_of(document))
    crushing = 3.0 * E * np.pi * RADIUS**2
    with pytest.raises(StaticsFailed) as failure:
        equilibrium(dynamics, efforts=np.array([crushing]))
    assert 0.2 < failure.value.load_factor < 0.4


def buckling_column(side):
    """Return a column under 3 EI/L² (beyond Euler's π²/4) with a small force to one side."""
    dynamics = rod(strains=["bend_y", "bend_z"], order=4, nodes=20)
    load = np.zeros(6)
    load[3], load[5] = -3.0 * EI / LENGTH**2, side * EI / LENGTH**2
    return dynamics, load


@pytest.mark.parametrize("side", [0.01, -0.01, 0.1])
def test_a_column_buckles_to_the_side_it_is_pushed_to(side):
    dynamics, load = buckling_column(side)
    q = equilibrium(dynamics, tip=load)
    assert tip(dynamics, q)[2, 3] * side > 0.1 * abs(side)
    zero = np.zeros(dynamics.n)
    dynamics.residual(q, zero, zero, dynamics.forcing(tip=load))
    stiffness = dynamics.last_tangent((1.0, 0.0, 0.0))
    assert np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T)).min() > 0.0


def test_a_perfect_column_buckles_at_eulers_load_and_says_so():
    dynamics, load = buckling_column(0.0)
    with pytest.raises(StaticsFailed, match="buckles") as failure:
        equilibrium(dynamics, tip=load)
    assert "basis" not in str(failure.value)
    euler = np.pi**2 / 4 / 3.0
    assert failure.value.load_factor == pytest.approx(euler, abs=1e-3)
    # asked for, the unstable straight column is an equilibrium, too
    straight = equilibrium(dynamics, tip=load, stable=False)
    assert np.abs(straight).max() < 1e-9


def thin(**options):
    """Return a heavy rod of slenderness 5000: it bends within a millimetre of its clamp."""
    return rod_document(radius=LENGTH / 1e4, gravity=(0, 0, -9.81), **options)


def test_a_very_thin_rod_hangs_like_a_string_with_a_stiff_start():
    """Its tip is where the boundary value problem of a heavy elastica has it.

    EI θ″ = −w (L − s) cos θ, θ the slope downwards, θ(0) = θ′(L) = 0: a layer at the clamp, by
    collocation; the weight stretches it by w s/EA (1 − s/2L) where it hangs.
    """
    radius = LENGTH / 1e4
    area, inertia = np.pi * radius**2, np.pi * radius**4 / 4
    weight, bending, axial = 1000.0 * area * 9.81, E * inertia, E * area

    def rates(s, y):
        pull = weight * (LENGTH - s)
        stretch = 1.0 + pull * np.sin(y[0]) / axial
        turned = -pull * np.cos(y[0]) / bending * stretch
        return np.vstack([y[1], turned, stretch * np.cos(y[0]), stretch * np.sin(y[0])])

    layer = (bending / (weight * LENGTH)) ** 0.5
    s = np.unique(np.concatenate([np.linspace(0, 20 * layer, 400), np.linspace(0, LENGTH, 400)]))
    theta = np.pi / 2 * (1 - np.exp(-s / layer))
    guess = np.vstack([theta, np.pi / 2 / layer * np.exp(-s / layer), np.zeros_like(s), s])
    answer = solve_bvp(
        rates,
        lambda a, b: np.array([a[0], a[2], a[3], b[1]]),
        s, guess, tol=1e-8, max_nodes=200000,
    )  # fmt: skip
    assert answer.success
    expected = [answer.y[2, -1], -answer.y[3, -1]]
    document = thin(strains=ALL[:4], order=3, elements=12)
    (whole,) = document["bodies"][0]["sections"]
    document["bodies"][0]["sections"] = [
        whole | {"name": "start", "length": 0.02 * LENGTH},
        whole | {"name": "rest", "length": 0.98 * LENGTH},
    ]
    dynamics = Dynamics(scene_of(document))
    pose = tip(dynamics, equilibrium(dynamics))
    np.testing.assert_allclose(pose[[0, 2], 3], expected, atol=1e-6 * LENGTH)
    assert expected[0] > 5e-4  # where a string has 0


def test_what_a_basis_cannot_show_is_told_apart_from_buckling():
    with pytest.raises(StaticsFailed, match=r"basis does not show.*rod/s/bend_y") as failed:
        equilibrium(Dynamics(scene_of(thin(order=6, nodes=60))))
    assert "numerics.basis.elements" in str(failed.value)


def test_a_dead_tip_wrench_is_along_world_axes_whatever_the_base():
    document = rod_document(
        strains=["bend_y", "bend_z"], base={"position": [0, 0, 1], "rpy": [0, -np.pi / 2, 0]}
    )
    dynamics = Dynamics(scene_of(document))  # the rod points up
    q = equilibrium(dynamics, tip=np.array([0, 0, 0, 0.5, 0, 0]))
    assert tip(dynamics, q)[0, 3] > 0.01
    pulled = equilibrium(dynamics, tip=np.array([0, 0, 0, 0, 0, 5.0]))
    np.testing.assert_allclose(tip(dynamics, pulled)[:3, 3], [0, 0, 1 + LENGTH], atol=1e-9)
