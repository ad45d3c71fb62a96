"""What three runs say about the error of the first, and what refuses to say more."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scenes import plain, rod_document, scene_of

from soft_sim_ros.core.accuracy.contract import choose, settle
from soft_sim_ros.core.accuracy.convergence import (
    SAFETY,
    SLOWEST,
    bound,
    contraction,
    distances,
    factor,
)
from soft_sim_ros.core.accuracy.drive import Drive
from soft_sim_ros.core.accuracy.watch import WatchedInputs
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import SceneError, SearchSpent, ToleranceMissed
from soft_sim_ros.scene import Free


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.3, 0.6, 0.85])
def test_errors_that_contract_evenly_are_bounded_closely(ratio):
    # a run, its companion and the finest, off by e, r e, r² e in one direction
    near, far, between = (np.array([x]) for x in (1 - ratio, 1 - ratio**2, ratio * (1 - ratio)))
    assert 1.0 <= bound(near, far, between)[0] <= 1.01 * SAFETY
    assert contraction(near, between)[0] == pytest.approx(ratio)


def test_companions_that_do_not_contract_make_the_estimate_large():
    near, far, between = np.array([1.0]), np.array([1.5]), np.array([1.2])
    assert contraction(near, between)[0] == SLOWEST
    assert bound(near, far, between)[0] > 10.0
    assert factor(1.2) == factor(SLOWEST) == pytest.approx(SAFETY / (1.0 - SLOWEST))
    assert bound(np.zeros(1), np.zeros(1), np.zeros(1))[0] == 0.0


def test_distances_are_of_positions_and_of_turns_whatever_the_sign_of_a_quaternion():
    angle = np.array([0.0, 0.3, 1e-6, 0.1])
    one = np.zeros((4, 2, 7))
    one[:, :, 6] = 1.0
    other = one.copy()
    other[:, 0, 1] = [0.0, 0.2, 0.1, 0.0]
    other[:, 0, 3], other[:, 0, 6] = np.sin(0.5 * angle), np.cos(0.5 * angle)
    other[2, 0, 3:] *= -1.0
    other[3, 1, 0] = 0.1  # a tip a quarter as far from the base
    arm = SimpleNamespace(length=2.0, tip_scale=np.array([1.0, 4.0]))
    found = distances(one, other, arm)
    assert found[:, 0] == pytest.approx([0.0, 0.1, 0.1, 0.2])  # the largest so far
    assert found[:, 1] == pytest.approx([0.0, 0.3, 0.3, 0.3])
    assert distances(one[2:3], other[2:3], arm)[0, 1] == pytest.approx(1e-6, rel=1e-3)


KICK = {
    "point": "kick",
    "body": "rod",
    "s": 0.6,
    "force": [0.0, 0.0, 8.0],
    "schedule": {"end": 0.05},
}
QUIET = Drive(np.zeros(0, dtype=np.int64), np.zeros((0, 0)), 40, 1)


def kicked(numerics, **options):
    """Return a planar arm that is kicked, and soon at rest again."""
    document = rod_document(
        strains=["bend_y"], material={"viscosity": 2e4}, loads=[KICK], **options
    )
    return scene_of(document | {"numerics": {"step": 0.01} | numerics})


def test_it_does_not_matter_how_seldom_a_run_publishes():
    seldom = replace(QUIET, every=QUIET.last)
    chosen = [choose(kicked({"tolerance": 1e-3}), drive) for drive in (QUIET, seldom)]
    assert chosen[0].estimate == chosen[1].estimate > 1e-5
    # where it is looked at, hardly anything is left of the error
    coarse, fine = (choose(kicked({"tolerance": t}), QUIET).scene for t in (1e-3, 1e-6))
    tips = [seldom.tip(Simulation(scene)) for scene in (coarse, fine)]
    assert np.linalg.norm(tips[0][-1] - tips[1][-1]) < 0.1 * chosen[0].estimate * 0.6


def test_a_tolerance_of_the_orientation_is_met_too():
    loose = choose(kicked({"tolerance": 1e-2}), QUIET)
    wanted = 0.1 * loose.angle  # so the tolerance of the position alone would not do
    scene = kicked({"tolerance": {"position": 1e-2, "orientation": wanted}})
    choice = choose(scene, QUIET)
    fine = QUIET.poses(Simulation(choose(kicked({"tolerance": 1e-6}), QUIET).scene))
    coarse = Simulation(choice.scene)
    off = distances(QUIET.poses(coarse), fine, coarse.compiled)[-1, 1]
    assert 0.0 < off <= choice.angle <= wanted
    assert choice.accuracy()["orientation_tolerance"] == wanted
    assert choice.scene.numerics.orientation == wanted


@pytest.mark.parametrize("value", [{"orientation": 1e-3}, {"position": 1e-3, "orientation": 0},
                                   {"position": 1e-3, "angle": 1e-3}])  # fmt: skip
def test_a_tolerance_of_the_orientation_alone_or_of_nothing_is_refused(value):
    with pytest.raises(SceneError, match=r"numerics.tolerance"):
        kicked({"tolerance": value})


def test_a_search_ends_at_its_limit_and_says_so_the_same_way_every_time():
    told = [[], []]
    errors = []
    for i in range(2):
        with pytest.raises(SearchSpent) as caught:
            choose(kicked({"tolerance": 1e-6}), QUIET, told[i].append, limit=3e5)
        errors.append(str(caught.value))
    assert errors[0] == errors[1] and told[0] == told[1]
    assert "limit of work, 3e+05" in errors[0]
    assert isinstance(caught.value, ToleranceMissed)
    assert any("of the limit" in text for text in told[0])


def test_motion_that_forgets_nothing_is_refused_with_the_time_up_to_which_the_answer_holds():
    half = {"strains": ["bend_y"], "sections": rod_document(length=0.2)["bodies"][0]["sections"]}
    document = rod_document(gravity=(0.0, 0.0, -9.81)) | {
        "bodies": [
            {"joint": "shoulder", "kind": "revolute", "axis": [0, 1, 0]},
            {"rod": "rod"} | half,
            {"joint": "elbow", "kind": "revolute", "axis": [0, 1, 0]},
            {"rod": "fore"} | half,
        ],
        "initial": {"positions": {"shoulder": -2.9, "elbow": -0.4}},
    }
    basis = {"order": 1, "elements": 1, "nodes": 6}
    numerics = {"step": 0.01, "tolerance": 1e-3, "basis": basis}
    scene = scene_of(document | {"numerics": numerics})
    with pytest.raises(ToleranceMissed) as caught:
        choose(scene, replace(QUIET, last=200))
    holds = caught.value.holds
    assert 0.0 < holds < 2.0
    assert f"it holds up to t = {holds:.4g} s" in str(caught.value)
    short = choose(scene, replace(QUIET, last=round(holds / 0.01) - 2))
    assert short.estimate <= 1e-3


def test_a_companion_is_trusted_as_far_as_the_search_saw_it_get_better():
    scene = choose(kicked({"tolerance": 1e-3}), QUIET).scene
    assert scene.numerics.trust is not None and scene.numerics.trust >= SAFETY
    watched = WatchedInputs(Simulation(scene), 0.0, 0.0)
    assert watched.trust == scene.numerics.trust
    plainly = replace(scene, numerics=replace(scene.numerics, trust=None, free=Free()))
    assert WatchedInputs(Simulation(plainly), 0.0, 0.0).trust == factor(1.0 / 3.0)


def test_a_watched_run_is_compared_at_the_same_steps_however_many_are_made_at_once():
    scene = settle(kicked({"tolerance": 1e-2}))
    one, many = (WatchedInputs(Simulation(scene), 0.0, 0.0) for _ in range(2))
    for _ in range(40):
        one.advance(1)
    many.advance(40)
    assert one.error_rel == many.error_rel > 0.0
    assert np.array_equal(one.simulation.q, many.simulation.q)


def test_a_soft_spot_narrower_than_nodes_is_met_within_the_tolerance():
    # closed form: small bending under a tip force, ∫ F (L − s)²/EI(s) ds by a dense rule
    soft = "0.6*(1 - 0.98*exp(-((s - 0.2345)/0.002)**2))"
    force = {"point": "push", "body": "rod", "s": 0.6, "force": [0.0, 0.0, 0.03]}
    document = rod_document(
        strains=["bend_y"],
        material={"viscosity": 2e3},
        loads=[force],
        initial={"state": "equilibrium"},
        section={"stiffness": {"bend_y": {"expression": soft}}},
    )
    scene = scene_of(plain(document | {"numerics": {"step": 0.05, "tolerance": 1e-5}}))
    drive = replace(QUIET, last=8)
    tip = drive.tip(Simulation(choose(scene, drive).scene))[-1]
    s = np.linspace(0.0, 0.6, 2_000_001)
    stiffness = 0.6 * (1.0 - 0.98 * np.exp(-(((s - 0.2345) / 0.002) ** 2)))
    exact = float(np.mean(0.03 * (0.6 - s) ** 2 / stiffness)) * 0.6
    assert abs(tip[2] - exact) < 1e-5 * 0.6 < 0.05 * exact
