"""Every packaged scene of several branches has a picture, and something that draws it."""

import sys
from pathlib import Path

import pytest

from soft_sim_ros.scene import load_scene, packaged_scenes

ROOT = Path(__file__).parents[2]
BRANCHED = [name for name in packaged_scenes() if load_scene(name).attachments]


def test_there_are_some():
    assert {"two_arms", "hand", "branched", "mobile_arm"} <= set(BRANCHED)


@pytest.mark.parametrize("name", BRANCHED)
def test_every_scene_of_several_branches_is_shown(name):
    assert f"(forest/{name}.png)" in (ROOT / "docs" / "forest.md").read_text(encoding="utf-8")
    picture = (ROOT / "docs" / "forest" / f"{name}.png").read_bytes()
    assert picture.startswith(b"\x89PNG")


def test_the_page_on_fluids_shows_what_swims():
    page = (ROOT / "docs" / "fluid.md").read_text(encoding="utf-8")
    for name in packaged_scenes():
        if load_scene(name).fluid is not None:
            assert f"(fluid/{name}.png)" in page
            assert (ROOT / "docs" / "fluid" / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_the_gallery_draws_what_the_page_shows(tmp_path, monkeypatch):
    from tools import gallery

    assert {name for name, shot in gallery.SHOTS.items() if shot.page == "forest"} == set(BRANCHED)
    monkeypatch.setattr(sys, "argv", ["gallery", "two_arms", "--out", str(tmp_path)])
    gallery.main()
    first = (tmp_path / "two_arms.png").read_bytes()
    gallery.main()
    assert first.startswith(b"\x89PNG")
    assert (tmp_path / "two_arms.png").read_bytes() == first
