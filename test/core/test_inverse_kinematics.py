"""Efforts for a tip pose, against arcs in closed form, random round trips and another optimiser."""

import sys
import warnings

import numpy as np
import pytest
from scenes import rod_document, scene_of
from scipy.optimize import minimize, minimize_scalar
from scipy.spatial.transform import Rotation

from soft_sim_ros.core.analysis.inverse_kinematics import inverse_kinematics, tip_sensitivity
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.analysis.tip_target import make_task
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.errors import NotResolved, TargetUnreachable
from soft_sim_ros.scene import load_scene

LENGTH, RADIUS, E = 0.6, 0.03, 1e6
EI = E * np.pi * RADIUS**4 / 4


def arc(angle_y, angle_z):
    """Tip of a constant-curvature rod: about z towards +y, about y towards −z."""
    turn = np.hypot(angle_y, angle_z)
    along = np.sin(turn) / turn
    across = (1 - np.cos(turn)) / turn**2
    return LENGTH * np.array([along, across * angle_z, -across * angle_y])


def bender(limit=np.inf):
    document = rod_document(strains=["bend_y", "bend_z"], order=1)
    document["actuators"] = [
        {"moment": f"m_{axis}", "rod": "rod", "section": "s", "strain": f"bend_{axis}"}
        | ({} if limit == np.inf else {"limits": [-limit, limit]})
        for axis in "yz"
    ]
    return Dynamics(scene_of(document))


@pytest.mark.parametrize("angles", [(0.4, -0.9), (-1.5, 0.3), (0.0, 2.0)])
def test_a_constant_curvature_arm_needs_the_moments_of_its_arc(angles):
    found = inverse_kinematics(bender(), arc(*angles))
    assert found.reached and found.distance < 1e-8 * LENGTH
    np.testing.assert_allclose(found.efforts, EI * np.array(angles) / LENGTH, rtol=1e-6, atol=1e-8)


def test_a_target_beyond_the_limits_is_missed_by_the_distance_of_the_arcs():
    limit = 0.5 * EI / LENGTH
    target = arc(1e-9, 1.2)
    with pytest.raises(TargetUnreachable, match="out of reach: the tip comes within") as refusal:
        inverse_kinematics(bender(limit), target)
    expected = np.linalg.norm(arc(1e-9, 0.5) - target)
    assert refusal.value.distance == pytest.approx(expected, rel=1e-6)
    np.testing.assert_allclose(refusal.value.closest.efforts, [0.0, limit], atol=1e-7)


def test_a_target_off_the_surface_of_the_arcs_is_missed_by_its_distance_from_it():
    target = np.array([0.5, 0.35, 0.0])
    nearest = minimize_scalar(
        lambda x: np.linalg.norm(arc(0.0, x) - target), bounds=(0.5, 2.5), method="bounded",
        options={"xatol": 1e-10},
    )  # fmt: skip
    found = inverse_kinematics(bender(), target, exact=False)
    assert not found.reached
    assert found.distance == pytest.approx(nearest.fun, rel=1e-7)
    assert found.efforts[1] == pytest.approx(EI * nearest.x / LENGTH, rel=1e-3)


@pytest.fixture(scope="module")
def arm():
    return Dynamics(load_scene("soft_arm"))


@pytest.mark.parametrize("seed", range(4))
def test_the_pose_of_random_efforts_is_reached_again(arm, seed):
    limits = np.array([actuator.limits for actuator in arm.compiled.scene.actuators]).T
    efforts = 0.4 * np.random.default_rng(seed).uniform(*limits)
    pose = arm.node_poses(equilibrium(arm, efforts=efforts))[-1]
    found = inverse_kinematics(arm, pose[:3, 3], pose[:3, :3])
    assert found.reached
    np.testing.assert_allclose(found.pose, pose, atol=2e-8)
    assert (limits[0] <= found.efforts).all() and (found.efforts <= limits[1]).all()
    # the answer is an equilibrium
    there = equilibrium(arm, efforts=found.efforts)
    np.testing.assert_allclose(arm.node_poses(there)[-1], found.pose, atol=1e-8)


def test_sensitivities_are_the_difference_quotients_of_equilibria():
    arm = Dynamics(load_scene("tendon_arm"))
    efforts = np.array([10.0, 4.0, 2.0, 6.0, 1.0, 8.0])
    push = np.array([0.0, 0.01, 0.0, 0.3, -0.2, 0.1])
    q = equilibrium(arm, efforts=efforts, tip=push)
    exact = tip_sensitivity(arm, q, efforts, tip=push)
    pose = arm.node_poses(q)[-1]
    for i, unit in enumerate(np.eye(6)):
        moved = [equilibrium(arm, q, efforts=efforts + h * unit, tip=push) for h in (1e-3, -1e-3)]
        slope = (moved[0] - moved[1]) / 2e-3
        size = np.abs(slope * arm.model.weight).max()
        np.testing.assert_allclose(
            exact.q[:, i] * arm.model.weight, slope * arm.model.weight, atol=1e-5 * size
        )
        poses = [arm.node_poses(x)[-1] for x in moved]
        shift = (poses[0][:3, 3] - poses[1][:3, 3]) / 2e-3
        turn = [Rotation.from_matrix(p[:3, :3] @ pose[:3, :3].T).as_rotvec() for p in poses]
        expected = np.concatenate([(turn[0] - turn[1]) / 2e-3, shift])
        np.testing.assert_allclose(exact.tip[:, i], expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize(
    "cost_of", [[0.25, 0.25, 0.5, 0.5, 1.0, 1.0], [1.0, 1.0, 3.0, 3.0, 1.0, 1.0]]
)
def test_of_many_solutions_the_one_of_least_effort_is_found(arm, cost_of):
    """Six moments for three coordinates of the tip, against SLSQP on the same equilibria."""
    limits = np.array([actuator.limits for actuator in arm.compiled.scene.actuators]).T
    weights = np.array(cost_of)
    efforts = np.array([0.9, -0.4, -0.3, 0.5, 0.2, -0.2])
    target = arm.node_poses(equilibrium(arm, efforts=efforts))[-1][:3, 3]
    found = inverse_kinematics(arm, target, weights=weights)
    cost = np.sum((weights * found.efforts) ** 2)
    assert cost < np.sum((weights * efforts) ** 2)
    other = minimize(
        lambda x: np.sum((weights * x) ** 2),
        efforts,
        method="SLSQP",
        bounds=limits.T,
        constraints={
            "type": "eq",
            "fun": lambda x: (arm.node_poses(equilibrium(arm, efforts=x))[-1][:3, 3] - target) * 10,
        },
        options={"ftol": 1e-12, "maxiter": 100},
    )
    assert other.success
    assert cost == pytest.approx(other.fun, rel=1e-4)
    np.testing.assert_allclose(found.efforts, other.x, atol=0.01)
    if cost_of[0] == 0.25:  # that is what the limits of this arm say by themselves
        by_itself = inverse_kinematics(arm, target)
        np.testing.assert_allclose(by_itself.efforts, found.efforts, atol=1e-9)


def test_tendons_only_pull():
    arm = Dynamics(load_scene("tendon_arm"))
    target = arm.node_poses(equilibrium(arm, efforts=np.array([20.0, 0, 5, 0, 0, 0])))[-1][:3, 3]
    found = inverse_kinematics(arm, target)
    assert found.reached and (found.efforts >= 0.0).all()
    assert np.isclose(found.efforts, 0.0, atol=1e-6).any()


@pytest.mark.parametrize(
    ("scene", "commands"),
    [("winch_arm", [0.02, 0.0, 0.0, 0.0]), ("pneumatic_arm", [0.0, 3e4, 0.0, 2e4, 0.0, 0.0])],
)
def test_lengths_of_winches_and_pressures_do_as_well(scene, commands):
    """Their sizes differ by 10⁷, and winches have slack tendons."""
    arm = Dynamics(load_scene(scene))
    target = arm.node_poses(equilibrium(arm, efforts=np.array(commands)))[-1][:3, 3]
    found = inverse_kinematics(arm, target)
    assert found.reached
    again = equilibrium(arm, efforts=found.efforts)
    np.testing.assert_allclose(arm.node_poses(again)[-1][:3, 3], target, atol=1e-7)


def test_slopes_of_the_error_are_its_difference_quotients_far_from_the_target_too(arm):
    """A turn of the tip changes the rotation vector of the error by more than its reverse."""
    turn = Rotation.from_rotvec([0.8, -1.1, 0.9]).as_matrix()
    task = make_task(arm, np.array([0.2, 0.1, 0.3]), turn, None, None, 1e-8, None)
    efforts = np.array([0.6, -0.3, 0.2, 0.4, -0.1, 0.2])
    point = task.at(efforts, None)
    assert np.linalg.norm(point.error[3:]) > 1.0
    size = 1e-4
    quotient = [
        (task.at(efforts - size * e, point.q).error - task.at(efforts + size * e, point.q).error)
        / (2 * size)
        for e in np.eye(6)
    ]
    slopes = task.sensitivities(point)[0]
    np.testing.assert_allclose(slopes, np.transpose(quotient), atol=1e-6 * np.abs(slopes).max())


@pytest.mark.parametrize("angle", [0.7, -0.7])
def test_a_slack_tendon_is_pulled_in_when_it_is_needed(angle):
    """Two antagonists, both paid out: nothing changes until one of them is taut, d · angle."""
    document = rod_document(strains=["bend_z"], order=1)
    winch = {"rod": "rod", "control": "length", "axial_stiffness": 1e5, "limits": [-0.05, 0.05]}
    document["actuators"] = [
        winch | {"tendon": "left", "offset": [0.02, 0.0]},
        winch | {"tendon": "right", "offset": [-0.02, 0.0]},
    ]
    arm = Dynamics(scene_of(document))
    found = inverse_kinematics(arm, arc(0.0, angle), start=[-0.03, -0.04], tries=1)
    assert found.reached
    pulled, other = found.efforts if angle > 0.0 else found.efforts[::-1]
    tension = EI * abs(angle) / LENGTH / 0.02
    assert pulled == pytest.approx(0.02 * abs(angle) + tension * LENGTH / 1e5, rel=1e-6)
    # the other one stays slack
    assert other < -0.02 * abs(angle) + 1e-9
    tensions = arm.port_efforts(found.q, np.zeros(arm.n), found.efforts)
    tensions = tensions[:: int(np.sign(angle))]
    np.testing.assert_allclose(tensions, [tension, 0.0], atol=1e-8 * 1e5 / LENGTH)  # of 10 nm


def test_an_orientation_alone_leaves_the_position_open(arm):
    efforts = np.array([0.5, 0.3, 0.0, 0.0, -0.2, 0.1])
    turn = arm.node_poses(equilibrium(arm, efforts=efforts))[-1][:3, :3]
    found = inverse_kinematics(arm, rotation=turn)
    assert found.reached and found.distance == 0.0
    np.testing.assert_allclose(found.pose[:3, :3], turn, atol=1e-7)


def test_weights_say_which_effort_is_dear(arm):
    target = arm.node_poses(equilibrium(arm, efforts=np.array([0.6, 0.2, 0.2, 0, 0, 0.1])))[-1]
    cheap = inverse_kinematics(arm, target[:3, 3], weights=np.ones(6)).efforts
    dear = inverse_kinematics(arm, target[:3, 3], weights=[1.0, 1.0, 9.0, 9.0, 1.0, 1.0]).efforts
    assert np.linalg.norm(dear[2:4]) < 0.2 * np.linalg.norm(cheap[2:4])


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({}, "a position, a rotation or both"),
        ({"position": [0.0, 1.0]}, "three finite numbers"),
        ({"rotation": 2 * np.eye(3)}, "a rotation matrix"),
        ({"position": np.ones(3), "limits": np.ones((6, 2))}, r"limits must be \(2, 6\)"),
        ({"position": np.ones(3), "weights": [1.0]}, "weights must be 6 numbers"),
    ],
)
def test_bad_questions_are_refused(arm, arguments, told):
    with pytest.raises(ValueError, match=told):
        inverse_kinematics(arm, **arguments)


@pytest.mark.parametrize("exact", [True, False])
def test_a_result_that_the_basis_does_not_show_is_told_of_once(exact):
    document = rod_document(strains=["bend_z"], order=1)
    document["actuators"] = [{"moment": "m", "rod": "rod", "section": "s", "strain": "bend_z"}]
    dynamics = Dynamics(scene_of(document))
    loads = {"tip": np.array([0.0, 0.0, 0.0, 0.0, 60.0 * EI / LENGTH**2, 0.0])}
    q = equilibrium(dynamics, efforts=np.array([0.1 * EI / LENGTH]), **loads)
    target = dynamics.node_poses(q)[-1][:3, 3]
    if not exact:
        target = target + np.array([0.0, 0.0, 0.1])  # out of the plane of the arm
    with pytest.warns(NotResolved) as said:
        found = inverse_kinematics(dynamics, target, check=True, exact=exact, **loads)
    assert len(said) == 1 and said[0].message.error > said[0].message.limit
    assert said[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # who writes a basis asks for the check
        same = inverse_kinematics(dynamics, target, exact=exact, **loads)
        inverse_kinematics(bender(), arc(0.4, -0.9), check=True)  # which any basis shows
    np.testing.assert_array_equal(same.efforts, found.efforts)


def test_without_a_written_basis_the_result_is_checked_unless_somebody_refuses(monkeypatch):
    document = rod_document(strains=["bend_z"])
    del document["numerics"]
    document["actuators"] = [{"moment": "m", "rod": "rod", "section": "s", "strain": "bend_z"}]
    dynamics = Dynamics(scene_of(document))
    module = sys.modules[inverse_kinematics.__module__]
    seen = []
    monkeypatch.setattr(module, "tell_if_coarse", lambda _, q, forcing: seen.append((q, forcing)))
    found = inverse_kinematics(dynamics, arc(0.0, 1.0))
    ((q, forcing),) = seen
    np.testing.assert_array_equal(q, found.q)
    np.testing.assert_array_equal(forcing.efforts, found.efforts)
    inverse_kinematics(dynamics, arc(0.0, 1.0), check=False)
    assert len(seen) == 1
