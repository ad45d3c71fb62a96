"""Contacts and reactions in pages, tables and lines: the numbers of the recording."""

from __future__ import annotations

import csv
import json
import re

import numpy as np
import pytest
from pages import BROWSER, part, played

from soft_sim_ros.batch.programme import Programme
from soft_sim_ros.batch.rollout import Rollout
from soft_sim_ros.commands.felt import felt_lines
from soft_sim_ros.core.mechanics.contacts import ContactReader
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.report import around, export_csv, export_npz, write_report
from soft_sim_ros.report.felt import felt_rows, pair_forces
from soft_sim_ros.scene import load_scene


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Give the end of a run of each scene, and its recording."""
    folder, found = tmp_path_factory.mktemp("felt"), {}
    for name, efforts in (("table", [0.0, 20.0, 0.0]), ("closed_arch", [0.02, 0.02, 0.03, 0.03])):
        programme = Programme(np.array([0.02]), np.array([efforts]))
        rollout = Rollout(load_scene(name), folder / name, programme, space=False)
        rollout.run(0.06)
        found[name] = rollout.simulation, folder / name
    return found


def test_the_page_shows_what_touched_and_what_held(runs):
    table, arch = (write_report(runs[name][1]).read_text() for name in runs)
    for page in (table, arch):
        assert page.count("<h2>Contacts and reactions</h2>") == 2  # a picture and a table
    assert "arm on table" in table
    assert "Largest at foot" in arch


def test_the_view_holds_surroundings_and_the_contacts_of_every_frame(runs):
    meta = json.loads(part(write_report(runs["table"][1]).read_text(), "view-meta"))
    (slab,) = meta["solids"]
    assert slab["kind"] == "box"
    assert slab["place"][2] + slab["size"][2] / 2 == pytest.approx(0.0, abs=1e-9)
    run = read_run(runs["table"][1])
    largest = np.linalg.norm(run.contacts.force, axis=1).max()
    times = (np.array(meta["times"]) * 1e9).round().astype(int)
    assert len(meta["pushes"]) == len(times)
    for time_ns, found in zip(times, meta["pushes"], strict=True):
        at = np.flatnonzero(run.contacts.time_ns == time_ns)[0]
        own = run.contacts.at == at
        rows = np.array(found).reshape(-1, 7)
        np.testing.assert_allclose(rows[:, :3], run.contacts.point[own], atol=1e-4)
        np.testing.assert_allclose(rows[:, 3:6] * largest, run.contacts.force[own], atol=1e-3)
        assert rows[:, 6].astype(bool).tolist() == run.contacts.sticks[own].tolist()


def test_of_many_contacts_a_frame_holds_the_largest(runs, monkeypatch):
    monkeypatch.setattr(around, "MOST", 1)
    run = read_run(runs["table"][1])
    found = around.pushes(run, run.contacts.time_ns, 5)
    size = np.linalg.norm(run.contacts.force, axis=1)
    for at, row in enumerate(found):
        if (own := size[run.contacts.at == at]).size:
            assert np.linalg.norm(row[3:6]) == pytest.approx(own.max() / size.max(), abs=1e-3)


def test_rows_tell_the_largest_forces(runs):
    run = read_run(runs["closed_arch"][1])
    force = np.linalg.norm(run.reactions["foot"].force, axis=1).max()
    assert dict(felt_rows(run))["Largest at foot"].startswith(f"{force:.4g} N")
    run = read_run(runs["table"][1])
    normal, friction = pair_forces(run, "arm", "table")
    weight = run.contacts.resultant("arm", "table")
    np.testing.assert_allclose(normal, weight[:, 5], atol=1e-6)  # the table is level
    np.testing.assert_allclose(friction, np.linalg.norm(weight[:, 3:5], axis=1), atol=1e-6)


def test_tables_and_arrays_hold_what_was_recorded(runs, tmp_path):
    for name, (_, folder) in runs.items():
        run = read_run(folder)
        export_csv(run, tmp_path / name)
        arrays = np.load(export_npz(run, tmp_path / f"{name}.npz"))
        if name == "closed_arch":
            rows = list(csv.reader((tmp_path / name / "reaction_foot.csv").open()))
            assert rows[0] == ["time", "moment_x (N·m)", "moment_y (N·m)", "moment_z (N·m)",
                               "force_x (N)", "force_y (N)", "force_z (N)"]  # fmt: skip
            values = np.array(rows[1:], float)
            np.testing.assert_array_equal(values[:, 1:], run.reactions["foot"].wrench)
            np.testing.assert_array_equal(arrays["reaction_foot_wrench"], values[:, 1:])
        else:
            rows = list(csv.DictReader((tmp_path / name / "contacts.csv").open()))
            assert [row["other"] for row in rows] == ["table"] * len(run.contacts.at)
            forces = [float(row["normal_force (N)"]) for row in rows]
            np.testing.assert_array_equal(forces, run.contacts.normal_force)
            np.testing.assert_array_equal(arrays["contacts_point"], run.contacts.point)


def test_lines_of_check_and_rollout_say_what_holds_and_what_touches(runs):
    arm = runs["closed_arch"][0]
    reactions = arm.reactions()
    (line,) = felt_lines(arm.scene, reactions, (), arm.dynamics.redundant_constraints(arm.q))
    assert f"foot, weld: {np.linalg.norm(reactions['foot'].force):.4g} N" in line
    assert "implied" not in line
    arm = runs["table"][0]
    (line,) = felt_lines(arm.scene, {}, arm.contacts())
    assert re.search(r"arm on table: [\d.]+ N, .* points \d+, of which \d+ stick", line)
    lifted = arm.q.copy()
    lifted[:] = 0.0
    apart = ContactReader(arm.compiled).near(lifted, lifted)
    assert list(felt_lines(arm.scene, {}, apart)) == ["contact           none"]


@pytest.mark.skipif(BROWSER is None, reason="no Chromium here")
@pytest.mark.timeout(120)
@pytest.mark.slow
def test_a_browser_plays_contacts_without_an_error(runs, tmp_path):
    page = write_report(runs["table"][1])
    assert 'data-ready="yes"' in played(page, tmp_path / "profile")
