"""The view of a page: whole without a browser, and playing in one where there is one."""

import hashlib
import json
import re
from pathlib import Path

import numpy as np
import pytest
from pages import BROWSER, part, played, unpacked

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.report import vendor, write_report
from soft_sim_ros.scene import load_scene
from soft_sim_ros.viewing.recorded import recorded_tubes
from soft_sim_ros.viewing.tube import around, rotations


def test_the_page_holds_the_poses_of_the_run_to_a_hair(turning):
    page = write_report(turning).read_text()
    meta = json.loads(part(page, "view-meta"))
    width = 7 * meta["poses"] + meta["shares"]
    numbers = np.frombuffer(unpacked(page, "view-data"), "<i2").reshape(meta["frames"], width)
    found = numbers[:, : 7 * meta["poses"]].reshape(meta["frames"], meta["poses"], 7)
    places = np.array(meta["low"]) + meta["step"] * (found[..., :3] + 32767.0)
    backbone = read_run(turning).backbone
    shown = np.searchsorted(backbone.time, np.array(meta["times"]) - 1e-9)
    assert shown[0] == 0 and shown[-1] == len(backbone) - 1
    assert np.abs(places - backbone.positions[shown]).max() < 2e-5
    turns = rotations(found[:, -1, 3:] / 32767.0)
    assert np.abs(turns - rotations(backbone.quaternions[shown, -1])).max() < 2e-4


def test_the_library_is_the_one_it_says_it_is_with_its_licence(turning):
    page = write_report(turning).read_text()
    library = unpacked(page, "view-library")
    assert hashlib.sha256(library).hexdigest() in vendor.__doc__
    assert "Permission is hereby granted, free of charge" in page
    assert "<noscript>" in page


def test_a_recording_without_a_scene_is_shown_with_a_thickness_that_is_said_to_be_made_up(turning):
    assert "made up" in json.loads(part(write_report(turning).read_text(), "view-meta"))["legend"]


@pytest.mark.parametrize("name", ["tendon_arm", "mixed_chain"])
def test_tubes_through_recorded_poses_have_the_radius_of_the_scene(name):
    simulation = Simulation(load_scene(name))
    poses = simulation.sampler(51).poses()
    turns = rotations(poses[:, 3:])
    scene = simulation.scene
    tubes = recorded_tubes(scene, {"": 51}, simulation.length)
    assert {t.actuator for t in tubes} > {None}
    bodies = [tube for tube in tubes if tube.actuator is None]
    covered = sorted(i for tube in bodies for i in tube.at)
    assert covered == list(range(51)), "each pose lies on one rod"
    last = bodies[-1]
    at = np.array(last.at)
    corners = around(poses[at, :3], turns[at], last.rings)
    radius = np.linalg.norm(corners - poses[at, None, :3], axis=2)
    expected = {"tendon_arm": 0.022, "mixed_chain": 0.010}[name]
    assert radius[-1] == pytest.approx(expected)


@pytest.mark.skipif(BROWSER is None, reason="no Chromium here")
@pytest.mark.timeout(120)
def test_a_browser_plays_the_page_from_a_file_without_an_error(turning, tmp_path):
    page: Path = write_report(turning)
    shown = played(page, tmp_path / "profile")
    view = re.search(r'<div id="view"[^>]*>', shown)[0]
    assert 'data-ready="yes"' in view
    assert float(re.search(r'data-time="([0-9.]+)"', view)[1]) > 0.0, "it plays"
    assert "<canvas" in shown
    for button in ("Front", "Side", "Top", "3-D"):
        assert f">{button}</button>" in shown
