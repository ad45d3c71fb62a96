"""A load path that ends: walked on by arc length, or explained, with finer numerics first."""

import numpy as np
import pytest
from scenes import ALL, rod, rod_document, scene_of

from soft_sim_ros.core.analysis import load_steps
from soft_sim_ros.core.analysis.continuation import LIMIT, follow
from soft_sim_ros.core.analysis.load_path import whole_load
from soft_sim_ros.core.analysis.stability import verdict
from soft_sim_ros.core.analysis.statics import equilibrium
from soft_sim_ros.core.settled import Dynamics
from soft_sim_ros.errors import StaticsFailed, UndampedFlutter

LENGTH, E = 0.6, 1e6
EI = E * np.pi * 0.03**4 / 4


def curled():
    """Return a flat strip, curled at rest, and a force under which it snaps over on the way."""
    section = {
        "reference": {"curvature": [0.0, 6.93, 0.3]},
        "cross_section": {"shape": "rectangle", "width_y": 0.06, "width_z": 0.006},
    }
    document = rod_document(
        strains=["torsion", "bend_y", "bend_z"], order=6, nodes=24, section=section,
        material={"viscosity": 300.0},
    )  # fmt: skip
    return Dynamics(scene_of(document)), np.array([0, 0, 0, 0.0456, -0.0126, 0.073])


def test_a_path_through_limit_points_is_walked_by_arc_length_to_a_stable_equilibrium():
    dynamics, tip = curled()
    with pytest.raises(StaticsFailed, match="the arm snaps") as ended:
        equilibrium(dynamics, tip=tip, thorough=False)
    q = equilibrium(dynamics, tip=tip)
    zero = np.zeros(dynamics.n)
    residual = dynamics.residual(q, zero, zero, dynamics.forcing(tip=tip))
    assert np.abs(residual / dynamics.model.weight).max() < 1e-9
    assert verdict(dynamics).unstable == 0
    branch = follow(dynamics, whole_load(dynamics, tip=tip), zero, within=(0.0, 1.0))
    limits = branch.of_kind(LIMIT)
    assert branch.ended_by == "load" and len(limits) >= 2
    assert limits[0].load == pytest.approx(ended.value.load_factor, abs=1e-4)
    np.testing.assert_allclose(branch.q[-1], q, atol=1e-7 / dynamics.model.weight.min())


def rolled(turns, bending=3, other=1):
    """Return a rod of some orders and the moment that rolls it up so many times."""
    moment = np.array([0, 0, turns * 2 * np.pi * EI / LENGTH, 0, 0, 0])
    document = rod_document()
    document["numerics"]["basis"]["order"] = {
        strain: bending if strain.startswith("bend") else other for strain in ALL
    }
    return Dynamics(scene_of(document)), moment


@pytest.mark.filterwarnings("ignore::soft_sim_ros.errors.UndampedFlutter")
def test_what_is_too_coarse_is_not_called_buckling():
    coarse, moment = rolled(2.0)
    with pytest.raises(StaticsFailed, match=r"too coarse.*bend_z 5.*nodes of rod all") as failure:
        equilibrium(coarse, tip=moment, tip_follows=True)
    assert "buckles" not in str(failure.value) and "flutters" not in str(failure.value)
    fine, _ = rolled(2.0, 5, 3)
    q = equilibrium(fine, tip=moment, tip_follows=True)
    np.testing.assert_allclose(fine.node_poses(q)[-1][:3, 3], 0.0, atol=1e-9)


def test_what_buckles_says_so_and_what_helps():
    dynamics = rod(strains=["bend_y", "bend_z"], order=4, nodes=20)
    tip = np.array([0, 0, 0, -3.0 * EI / LENGTH**2, 0, 0])
    with pytest.raises(StaticsFailed, match="buckles or tips over; finer numerics say") as failure:
        equilibrium(dynamics, tip=tip)
    assert "stable=False" in str(failure.value) and "follow" in str(failure.value)
    assert np.abs(equilibrium(dynamics, tip=tip, stable=False)).max() < 1e-9


def hinge():
    return Dynamics(
        scene_of(
            {
                "name": "door", "gravity": [0.0, 0.0, -9.81],
                "bodies": [
                    {"joint": "a", "kind": "revolute", "axis": [0.0, 1.0, 0.0]},
                    {"rigid_body": "b", "mass": 1.0, "inertia": [1e-3] * 3,
                     "com": {"position": [0.3, 0.0, 0.0]}},
                ],
            }
        )
    )  # fmt: skip


def pushed_tendon():
    document = rod_document(strains=["stretch"], order=1)
    document["actuators"] = [{"tendon": "t", "rod": "rod", "offset": [0.0, 0.0]}]
    return Dynamics(scene_of(document))


FAILURES = {
    "a crushed rod": (pushed_tendon, {"efforts": np.array([3.0 * E * np.pi * 0.03**2])}),
    "nothing holds it": (hinge, {}),
    "a buckled column": (
        lambda: rod(strains=["bend_y"], order=3),
        {"tip": np.array([0, 0, 0, -3.0 * EI / LENGTH**2, 0, 0])},
    ),
    "too few iterations": (
        lambda: rod(strains=["bend_y"], order=3),
        {"tip": np.array([0, 0, 0, 0, 0, 3.0]), "iterations": 1},
    ),
    "no tolerance that can be met": (
        lambda: rod(strains=["bend_y"], order=3),
        {"tip": np.array([0, 0, 0, 0, 0, 3.0]), "tolerance": 0.0},
    ),
    "a load beyond all numbers": (
        lambda: rod(strains=["bend_y", "stretch"], order=3),
        {"tip": np.array([0, 0, 0, 0, 0, 1e300])},
    ),
    "a limit point": (lambda: curled()[0], {"tip": curled()[1]}),
    "a thin heavy rod": (
        lambda: rod(radius=LENGTH / 1e4, order=3, nodes=20, gravity=(0, 0, -9.81)), {}
    ),
    "flutter": (
        lambda: rod(
            strains=["bend_z"], order=6, nodes=24, material={"rayleigh": {"mass": 0.1}}
        ),
        {"tip": np.array([0, 0, 0, -30.0 * EI / LENGTH**2, 0, 0]), "tip_follows": True},
    ),
}  # fmt: skip


WALKED = ("a limit point", "too few iterations")  # by arc length these paths go on


@pytest.mark.parametrize(
    ("name", "thorough"),
    [(name, thorough) for name in FAILURES for thorough in (False, True)[: 2 - (name in WALKED)]],
)
def test_no_load_path_ends_without_a_reason(name, thorough):
    make, arguments = FAILURES[name]
    with pytest.raises(StaticsFailed) as failure:
        equilibrium(make(), thorough=thorough, **arguments)
    assert len(failure.value.why) > 10 and not failure.value.why.startswith(";")
    assert "(;" not in str(failure.value) and "()" not in str(failure.value)
    assert 0.0 <= failure.value.load_factor < 1.0


def test_every_end_of_a_walk_has_a_reason():
    """Whatever `newton` returns: an equilibrium and no reason, or a reason and no equilibrium."""
    dynamics = rod(strains=["bend_y", "stretch"], order=3)
    mask = np.ones(dynamics.n, dtype=bool)
    rng = np.random.default_rng(0)
    for size in (1.0, 1e3, 1e9, 1e200):
        tip = np.zeros(6)
        tip[3:] = size * rng.normal(size=3)
        for iterations in (1, 3, 25):
            question = load_steps.Question(
                dynamics, mask, None, 0.0, tip, False, 1e-12, iterations, True
            )
            for _ in range(3):
                start = rng.normal(size=dynamics.n)
                found, _, why = load_steps.newton(question, start, 1.0)
                assert (found is None) == (len(why) > 10)


def test_flutter_without_damping_is_told_and_not_refused():
    dynamics, moment = rolled(0.5, 5, 5)
    with pytest.warns(UndampedFlutter, match="material.viscosity") as said:
        q = equilibrium(dynamics, tip=moment, tip_follows=True)
    assert said[0].filename == __file__
    assert dynamics.node_poses(q)[-1][0, 3] == pytest.approx(0.0, abs=1e-9)
