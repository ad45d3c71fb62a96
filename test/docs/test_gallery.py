"""Packaged scenes of branches, with contact, constraints or a fluid have pictures."""

import sys
from pathlib import Path

import pytest

from soft_sim_ros.scene import load_scene, packaged_scenes

ROOT = Path(__file__).parents[2]
HELD = [name for name in packaged_scenes() if load_scene(name).constraints]
TOUCHING = [name for name in packaged_scenes() if load_scene(name).environment]
BRANCHED = [
    name
    for name in packaged_scenes()
    if load_scene(name).attachments and name not in HELD and name not in TOUCHING
]
SWIMMING = [name for name in packaged_scenes() if load_scene(name).fluid is not None]
SHOWN = [
    (page, name)
    for page, names in (
        ("forest", BRANCHED),
        ("contact", TOUCHING),
        ("fluid", SWIMMING),
        ("constraints", HELD),
    )
    for name in names
]


def test_there_are_some():
    assert {"two_arms", "hand", "branched", "mobile_arm"} <= set(BRANCHED)
    assert {"table", "corner", "grasp", "snake"} <= set(TOUCHING)
    assert "swimmer" in SWIMMING
    assert {"closed_arch", "parallel_robot"} <= set(HELD)


@pytest.mark.parametrize(("page", "name"), SHOWN)
def test_every_scene_of_branches_with_contact_or_in_a_fluid_is_shown(page, name):
    assert f"({page}/{name}.png)" in (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    picture = (ROOT / "docs" / page / f"{name}.png").read_bytes()
    assert picture.startswith(b"\x89PNG")


def test_the_gallery_draws_what_the_page_shows(tmp_path, monkeypatch):
    from tools import gallery

    assert {(shot.page, name) for name, shot in gallery.SHOTS.items()} == set(SHOWN)
    monkeypatch.setattr(sys, "argv", ["gallery", "two_arms", "--out", str(tmp_path)])
    gallery.main()
    first = (tmp_path / "forest" / "two_arms.png").read_bytes()
    gallery.main()
    assert first.startswith(b"\x89PNG")
    assert (tmp_path / "forest" / "two_arms.png").read_bytes() == first
