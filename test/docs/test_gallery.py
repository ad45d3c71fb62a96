"""Packaged scenes of several branches or with contact have a picture, and what draws it."""

import sys
from pathlib import Path

import pytest

from soft_sim_ros.scene import load_scene, packaged_scenes

ROOT = Path(__file__).parents[2]
BRANCHED = [name for name in packaged_scenes() if load_scene(name).attachments]
TOUCHING = [name for name in packaged_scenes() if load_scene(name).environment]
SHOWN = [("forest", name) for name in BRANCHED] + [("contact", name) for name in TOUCHING]


def test_there_are_some():
    assert {"two_arms", "hand", "branched", "mobile_arm"} <= set(BRANCHED)
    assert {"table", "corner"} <= set(TOUCHING)


@pytest.mark.parametrize(("page", "name"), SHOWN)
def test_every_scene_of_branches_or_with_contact_is_shown(page, name):
    assert f"({page}/{name}.png)" in (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    picture = (ROOT / "docs" / page / f"{name}.png").read_bytes()
    assert picture.startswith(b"\x89PNG")


def test_the_gallery_draws_what_the_page_shows(tmp_path, monkeypatch):
    from tools import gallery

    assert set(gallery.SHOTS) == {name for _, name in SHOWN}
    monkeypatch.setattr(sys, "argv", ["gallery", "two_arms", "--out", str(tmp_path)])
    gallery.main()
    first = (tmp_path / "forest" / "two_arms.png").read_bytes()
    gallery.main()
    assert first.startswith(b"\x89PNG")
    assert (tmp_path / "forest" / "two_arms.png").read_bytes() == first
