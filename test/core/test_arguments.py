"""Arguments of the wrong size are refused: kernels would read whatever lies behind an array."""

import numpy as np
import pytest
from scenes import rod_document, scene_of

from soft_sim_ros.core.analysis.continuation import SpecialPoint, follow, switch
from soft_sim_ros.core.analysis.inverse_kinematics import inverse_kinematics
from soft_sim_ros.core.analysis.linearisation import linearise
from soft_sim_ros.core.analysis.load_path import one_effort, one_load, tip_wrench
from soft_sim_ros.core.analysis.modes import complex_modes, modes
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.mechanics.sampler import Sampler
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.errors import CommandError

BENT = np.array([0, 0, 0, 0, 0.1, 0.0])


@pytest.fixture(scope="module")
def arm():
    document = rod_document(strains=["bend_y", "bend_z"], order=2, gravity=(0, 0, -1.0))
    document["actuators"] = [
        {"tendon": "a", "rod": "rod", "offset": [0.02, 0.0]},
        {"tendon": "b", "rod": "rod", "offset": [0.0, 0.02]},
    ]
    document["loads"] = [
        {"point": "later", "body": "rod", "force": [0, 1.0, 0], "schedule": {"start": 1.0}}
    ]
    return Dynamics(scene_of(document))


CALLS = {
    "inverse_dynamics": lambda d, q: d.inverse_dynamics(q, q, q),
    "forward_dynamics": lambda d, q: d.forward_dynamics(np.zeros(d.n), q),
    "node_poses": lambda d, q: d.node_poses(q),
    "energies": lambda d, q: d.energies(q, q),
    "ports": lambda d, q: d.ports(q, q),
    "momentum": lambda d, q: d.momentum(q, q),
    "elastic_force": lambda d, q: d.elastic_force(q),
    "stiffness_matrix": lambda d, q: d.stiffness_matrix(q),
    "mass_matrix": lambda d, q: d.mass_matrix(q),
    "tip_jacobian": lambda d, q: d.tip_jacobian(q),
    "internal_wrench": lambda d, q: d.internal_wrench(q),
    "equilibrium": lambda d, q: equilibrium(d, q),
    "free": lambda d, q: equilibrium(d, free=q > 0.0),
    "modes": lambda d, q: modes(d, q),
    "complex_modes": lambda d, q: complex_modes(d, q),
    "linearise": lambda d, q: linearise(d, q),
    "follow": lambda d, q: follow(d, tip_wrench(d, BENT), q, within=(0.0, 1.0)),
    "sampler": lambda d, q: Sampler(d.compiled, q, np.linspace(0.0, 0.6, 3)),
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("size", [4, 7])
def test_coordinates_of_another_number_are_refused(arm, call, size):
    assert arm.n == 6
    with pytest.raises(ValueError, match=r"must be 6 (numbers|truth values), not array\("):
        CALLS[call](arm, np.zeros(size))


@pytest.mark.parametrize("efforts", [3.0, [3.0], [3.0, 0.0, 0.0], [[3.0, 0.0]]])
def test_one_effort_does_not_stand_for_all(arm, efforts):
    for call in (
        lambda: equilibrium(arm, efforts=efforts),
        lambda: modes(arm, np.zeros(6), efforts),
        lambda: linearise(arm, np.zeros(6), efforts),
        lambda: arm.port_efforts(np.zeros(6), np.zeros(6), efforts),
        lambda: one_effort(arm, "a", efforts),
    ):
        with pytest.raises(ValueError, match="efforts must be 2 numbers"):
            call()
    with pytest.raises(ValueError, match="start must be 2 numbers"):
        inverse_kinematics(arm, [0.5, 0.1, 0.0], start=efforts)


@pytest.mark.parametrize("follows", [False, True])
def test_a_wrench_is_six_numbers(arm, follows):
    with pytest.raises(ValueError, match="tip must be 6 numbers"):
        equilibrium(arm, tip=np.array([0.0, 0.0, 1.0]), tip_follows=follows)
    with pytest.raises(ValueError, match="wrench must be 6 numbers"):
        tip_wrench(arm, np.ones(3))
    with pytest.raises(ValueError, match="held must be 6 numbers"):
        tip_wrench(arm, np.ones(6), held=np.ones(3))


def test_lists_whole_numbers_and_strided_arrays_are_numbers_too(arm):
    q = equilibrium(arm, tip=BENT, tip_follows=True)
    expected = arm.node_poses(q)
    np.testing.assert_array_equal(arm.node_poses(q.tolist()), expected)
    np.testing.assert_array_equal(arm.node_poses(np.repeat(q, 2)[::2]), expected)
    assert arm.energies([0] * 6, [0] * 6)[0] == 0.0
    np.testing.assert_array_equal(equilibrium(arm, tip=BENT.tolist(), tip_follows=True), q)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"load": 5.0}, "the branch starts at the load 5, not within"),
        ({"step": 0.0}, "step must be a finite number above zero, not 0.0"),
        ({"step": -0.1}, "step must be a finite number above zero, not -0.1"),
        ({"max_step": np.nan}, "max_step must be a finite number above zero, not nan"),
        ({"steps": 0}, r"steps must be a whole number in \[1, 1000000\], not 0"),
        ({"tolerance": 0.0}, "tolerance must be a finite number above zero"),
    ],
)
def test_a_branch_that_cannot_be_followed_as_asked_is_refused(arm, options, told):
    path = tip_wrench(arm, BENT)
    with pytest.raises(ValueError, match=told):
        follow(arm, path, np.zeros(6), **({"within": (0.0, 1.0)} | options))


def test_neither_can_one_be_switched_to(arm):
    point = SpecialPoint("bifurcation", 0.5, np.zeros(6), np.eye(6)[:, :1], 0)
    path = tip_wrench(arm, BENT)
    with pytest.raises(ValueError, match="offset must be a finite number above zero"):
        switch(arm, path, point, within=(0.0, 1.0), offset=0.0)
    with pytest.raises(ValueError, match=r"starts at the load 0.5, not within"):
        switch(arm, path, point, within=(1.0, 2.0))


def test_a_load_that_does_not_act_leads_nowhere(arm):
    with pytest.raises(CommandError, match="load 'later' does not act at t = 0 s"):
        one_load(arm, "later")
    one_load(arm, "later", time=1.0)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"rotation": np.diag([1.0, 1.0, -1.0])}, "rotation must be a rotation matrix"),
        ({"tolerance": 0.0}, "tolerance must be above zero"),
        ({"tolerance": np.nan}, "tolerance must be above zero"),
    ],
)
def test_a_pose_that_is_none_is_refused(arm, options, told):
    with pytest.raises(ValueError, match=told):
        inverse_kinematics(arm, [0.5, 0.1, 0.0], **options)


def test_unknown_names_of_a_linear_system_are_told_with_the_known_ones(arm):
    system = linearise(arm, equilibrium(arm))
    with pytest.raises(ValueError, match="unknown input 'c': expected one of a, b, tip_moment_x"):
        system.select(("c",), ("tip_x",))
    with pytest.raises(ValueError, match="unknown output 'tip': expected one of tip_x"):
        system.select(("a",), ("tip",))
