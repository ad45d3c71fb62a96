"""Commands on scenes of several branches."""

from __future__ import annotations

import json

import numpy as np
import pytest
from branched import NAMES, file_of

from soft_sim_ros.commands import check, linearise, report, rerun, rollout, urdf
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.report.wrench import by_backbone

TOLD = {
    "two_arms": ("branches 2: left, right", "tips     2: left, right;"),
    "palm": ("branches 3: index, middle, thumb", "tips     3: index, middle, thumb;"),
    "ring": ("branches 2: stem → leaf, twig", "tips     3: leaf, twig, ring;"),
}


@pytest.mark.parametrize("name", NAMES)
def test_check_says_how_many_branches_and_tips_there_are(name, tmp_path, capsys):
    drawn = tmp_path / "wrench.png"
    assert check.main([str(file_of(name)), "--wrench", str(drawn)]) == 0
    said = capsys.readouterr().out
    for line in TOLD[name]:
        assert line in said
    assert drawn.stat().st_size > 10_000


def test_each_backbone_carries_the_weight_of_what_leaves_it_where_it_leaves(scenes):
    simulation = Simulation(scenes["ring"])
    q, _ = check.rest(simulation)
    compiled, poses = simulation.compiled, simulation.dynamics.node_poses(q)
    found = by_backbone(compiled, check.carried(simulation, q), poses)
    assert list(found) == ["stem", "twig"]
    density = 1000.0 * np.pi * np.array([0.02, 0.01, 0.015]) ** 2  # kg/m of stem, twig, leaf
    stem, first = found["stem"], compiled.backbones["stem"].first_node
    for s, mass in ((0.1, 0.1), (0.25, 0.2 * density[1])):
        (node,) = np.flatnonzero(np.abs(stem.s - s) < 1e-9)
        turn = poses[first + node, :3, :3]
        jump = turn @ (stem.after[node, 3:] - stem.before[node, 3:])
        # what is beyond pulls down, and less of it is beyond after the jump
        np.testing.assert_allclose(jump, [0.0, 0.0, 9.81 * mass], atol=1e-3 * 9.81 * mass)
    beyond = 9.81 * (density @ [0.4, 0.2, 0.1] + 0.1)
    np.testing.assert_allclose(stem.after[0, 3:], [0.0, 0.0, -beyond], atol=1e-3 * beyond)
    twig, start = found["twig"], compiled.backbones["twig"].first_node
    force = poses[start, :3, :3] @ twig.before[0, 3:]
    weight = 9.81 * 0.2 * density[1]
    np.testing.assert_allclose(force, [0.0, 0.0, -weight], atol=1e-3 * weight)
    for one in found.values():
        np.testing.assert_allclose(one.after[-1], 0.0, atol=1e-9)


@pytest.mark.parametrize("name", ["two_arms", "ring"])
def test_linearise_holds_for_a_forest(name, tmp_path, capsys):
    out = tmp_path / "system.json"
    assert linearise.main([str(file_of(name)), "--out", str(out)]) == 0
    assert "growth   -" in capsys.readouterr().out, "what hangs and is damped comes to rest"
    assert np.isfinite(json.loads(out.read_text())["A"]).all()


def test_linearise_says_why_it_does_not_for_a_driven_joint(capsys):
    assert linearise.main([str(file_of("palm"))]) != 0
    assert "bodies.wrist.driven" in capsys.readouterr().err


def test_a_rollout_is_shown_and_simulated_again(tmp_path, capsys):
    run = tmp_path / "run"
    assert rollout.main([str(file_of("ring")), "--duration", "0.05", "--out", str(run)]) == 0
    assert report.main([str(run), "--csv", str(tmp_path / "tables")]) == 0
    assert rerun.main([str(run)]) == 0
    assert "0 bits different" in capsys.readouterr().out
    assert (tmp_path / "tables" / "backbone_twig.csv").exists()


def test_urdf_writes_a_forest(tmp_path):
    out = tmp_path / "palm.urdf"
    assert urdf.main([str(file_of("palm")), "--out", str(out)]) == 0
    assert '<child link="thumb_end" />' in out.read_text()
