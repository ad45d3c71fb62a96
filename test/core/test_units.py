"""Every kind of actuator names the units of its port, and they are those of its numbers."""

import typing

import numpy as np
import pytest
from scenes import ALL, SOFT, scene_of

from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.scene.actuator import Actuator, Units

# powers of length in each unit, where mass and time stay as they are
LENGTH_IN = {"rad": 0, "m": 1, "m³": 3, "N·m": 2, "N": 1, "Pa": -1}
ENERGY = 2


def document(size):
    """Return an arm with every kind of actuator, ``size`` times as large."""
    section = {"name": "s", "length": 0.3 * size, "material": "soft",
               "cross_section": {"shape": "circle", "radius": 0.02 * size}}  # fmt: skip
    return {
        "name": "all", "gravity": [0, 0, 0], "materials": {"soft": SOFT},
        "bodies": [
            {"joint": "turn", "kind": "revolute", "axis": [0, 0, 1]},
            {"rigid_body": "a", "mass": 1.0, "inertia": [1, 1, 1]},
            {"joint": "slide", "kind": "prismatic", "axis": [0, 1, 0]},
            {"rigid_body": "b", "mass": 1.0, "inertia": [1, 1, 1]},
            {"joint": "swing", "kind": "universal", "axes": [[0, 1, 0], [0, 0, 1]]},
            {"rod": "rod", "strains": ALL, "sections": [section]},
        ],
        "actuators": [
            {"joint_torque": "torque", "joint": "turn"},
            {"joint_force": "force", "joint": "slide"},
            {"joint_torque": "other", "joint": "swing", "axis": "second"},
            *({"moment": s, "rod": "rod", "section": "s", "strain": s} for s in ALL),
            {"tendon": "tendon", "rod": "rod", "offset": [0.01 * size, 0]},
            {"tendon": "winch", "rod": "rod", "offset": [0, 0.01 * size],
             "control": "length", "axial_stiffness": 100.0},
            {"chamber": "chamber", "rod": "rod", "offset": [0.005 * size, 0],
             "area": 1e-4 * size**2},
        ],
        "numerics": {"basis": {"order": 0}},
    }  # fmt: skip


def state(dynamics, size):
    """Return q (n,) of one shape, of an arm ``size`` times as large."""
    names = dynamics.compiled.coordinate_names
    q = np.random.default_rng(0).uniform(0.1, 0.2, len(names))
    curvatures = np.array([any(s in name for s in ALL[:3]) for name in names])
    q[curvatures] /= size
    q[["slide" in name for name in names]] *= size
    return q


@pytest.fixture(scope="module")
def arms():
    """Give two arms of one shape, one ten times as large, as (size, dynamics, q)."""
    found = [(size, Dynamics(scene_of(document(size)))) for size in (1.0, 10.0)]
    return [(size, dynamics, state(dynamics, size)) for size, dynamics in found]


def test_no_kind_is_forgotten(arms):
    kinds = {type(actuator) for actuator in arms[0][1].compiled.scene.actuators}
    assert kinds == set(typing.get_args(Actuator))


def test_a_position_grows_with_the_arm_as_its_unit_does(arms):
    (_, small, q), (size, large, p) = arms
    ratios = large.ports(p, 0 * p)[0] / small.ports(q, 0 * q)[0]
    units = [actuator.units.position for actuator in small.compiled.scene.actuators]
    expected = [size ** LENGTH_IN[unit] for unit in units]
    np.testing.assert_allclose(ratios, expected, rtol=1e-9)


def test_effort_times_position_is_an_energy_and_over_time_a_power(arms):
    for actuator in arms[0][1].compiled.scene.actuators:
        units = actuator.units
        assert LENGTH_IN[units.effort] + LENGTH_IN[units.position] == ENERGY, actuator.name
        assert units.velocity == f"{units.position}/s"
        assert isinstance(units, Units) and actuator.unit == units.command


def test_a_command_is_the_effort_or_a_position_and_its_unit_says_which(arms):
    (_, small, q), (size, large, p) = arms
    actuators = small.compiled.scene.actuators
    command = np.full(len(actuators), 0.3)
    scaled = command * [size ** LENGTH_IN[a.units.command] for a in actuators]
    told = small.port_efforts(q, 0 * q, command)
    # an effort grows with forces, which do not grow here where what pulls is a spring of its own
    grown = [size ** LENGTH_IN[a.units.command] if a.name != "winch" else 1.0 for a in actuators]
    np.testing.assert_allclose(large.port_efforts(p, 0 * p, scaled), told * grown, rtol=1e-9)
    for actuator, before in zip(actuators, told, strict=True):
        is_effort = actuator.units.command == actuator.units.effort
        assert is_effort == (before == 0.3), actuator.name
        assert is_effort or actuator.units.command == actuator.units.position
