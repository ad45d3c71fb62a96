"""B-2, B-5: what a person may get wrong with joints, and what is said about it."""

import pytest
import yaml

from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import parse_scene

BODY = {"rigid_body": "b", "mass": 1.0, "inertia": [1, 1, 1]}


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        ({"kind": "universal", "axes": [[1, 0, 0], [2, 0, 0]]}, "two axes that are not parallel"),
        ({"kind": "universal", "axes": [[1, 0, 0]]}, "a list of 2 lists of 3 numbers"),
        ({"kind": "universal", "axis": [1, 0, 0]}, "a universal joint has two axes"),
        ({"kind": "prismatic"}, "axis is missing"),
        ({"kind": "prismatic", "axes": [[1, 0, 0]]}, "a prismatic joint has one axis"),
        ({"kind": "spherical", "axis": [1, 0, 0]}, "it has no effect on a spherical joint"),
        ({"kind": "spherical", "stiffness": 1.0}, "a spherical joint has no axes; springs"),
        ({"kind": "free", "damping": 1.0}, "a free joint has no axes; springs"),
    ],
)
def test_joints_are_refused_by_key(joint, message):
    document = {"bodies": [{"joint": "j"} | joint, BODY]}
    with pytest.raises(SceneError, match=message):
        parse_scene(yaml.safe_dump(document))


def test_only_the_first_body_is_free():
    document = {"bodies": [BODY, {"joint": "j", "kind": "free"}, BODY | {"rigid_body": "c"}]}
    with pytest.raises(
        SceneError, match=r"bodies\[1\].kind = free: expected a free joint only on the base"
    ):
        parse_scene(yaml.safe_dump(document))


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (
            {"initial": {"positions": {"u": 1.0}}},
            r"initial.positions.u = 1.0: expected a list of 2",
        ),
        ({"initial": {"positions": {"s": [4.0, 0, 0]}}}, "no longer than half a turn, not 4 rad"),
        ({"actuators": [{"joint_torque": "t", "joint": "s"}]}, "revolute or universal joint"),
        ({"actuators": [{"joint_torque": "t", "joint": "u"}]}, r"actuators\[0\].axis is missing"),
        ({"actuators": [{"joint_force": "t", "joint": "u"}]}, "the name of a prismatic joint"),
    ],
)
def test_values_must_fit_the_joint(more, message):
    joints = [
        {"joint": "u", "kind": "universal", "axes": [[1, 0, 0], [0, 1, 0]]},
        {"joint": "s", "kind": "spherical"},
    ]
    with pytest.raises(SceneError, match=message):
        parse_scene(yaml.safe_dump({"bodies": [*joints, BODY]} | more))
