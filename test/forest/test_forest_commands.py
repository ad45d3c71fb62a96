"""Commands on scenes of several branches."""

from __future__ import annotations

import json

import numpy as np
import pytest
from branched import NAMES, file_of

from soft_sim_ros.commands import check, linearise, report, rerun, rollout, urdf
from soft_sim_ros.report.wrench import limbs_drawn

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


def test_a_picture_of_wrenches_has_each_backbone_by_itself(moved):
    for name, expected in (("ring", ["stem", "twig"]), ("two_arms", ["left", "right"])):
        compiled = moved[name].compiled
        found = limbs_drawn(compiled)
        assert list(found) == expected
        nodes = [i for part in found.values() for i in range(part.start, part.stop)]
        assert len(set(nodes)) == len(nodes)
        for limb, part in found.items():
            assert compiled.chain.rods[limb].first_node in range(part.start, part.stop)


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
