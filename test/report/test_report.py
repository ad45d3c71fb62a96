"""The report is one page that needs nothing else, and its numbers are those of the recording."""

from __future__ import annotations

import base64
import json
import math
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from html.parser import HTMLParser
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import soft_sim_ros
from soft_sim_ros.errors import RecordingError
from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.recording.topics import recorded_topics
from soft_sim_ros.recording.writer import BagWriter
from soft_sim_ros.report import picture, write_report
from soft_sim_ros.report.style import look, stride, thin


class Page(HTMLParser):
    """Collects what a page shows: images, table rows, text inside <pre>, and open elements."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.images: dict[str, str] = {}
        self.references: list[str] = []
        self.rows: dict[str, str] = {}
        self.pre = self.heading = ""
        self._cell: str | None = None
        self._name = ""
        self._open: list[str] = []
        self.feed(text)
        assert self._open == [], "an element was left open"

    def handle_starttag(self, tag: str, attributes: list) -> None:
        given = dict(attributes)
        self.references += [v for k, v in given.items() if k in ("src", "href", "srcset")]
        if tag == "img":
            self.images[given["alt"]] = given["src"]
        elif tag != "meta":
            self._open.append(tag)
        if tag == "tr":
            self._name = ""

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        inside = self._open[-1] if self._open else ""
        if inside == "th":
            self._name += data
        elif inside == "td":
            self.rows[self._name] = data
        elif inside == "pre":
            self.pre += data
        elif inside == "h1":
            self.heading += data


def test_the_page_says_when_the_recording_was_made(turning: Path) -> None:
    begun = json.loads(read_run(turning).attachments["machine.json"])["recorded"]
    assert f"recorded {begun}" in write_report(turning).read_text()


def test_the_page_stands_alone(turning: Path) -> None:
    path = write_report(turning)
    assert path == turning / "report.html"
    text = path.read_text()
    page = Page(text)
    assert all(reference.startswith("data:") for reference in page.references)
    assert not re.search(r"https?:|@import|url\(", text)
    expected = ["Backbone and path of the tip", "Tip", "Actuators", "Energy", "Timing"]
    assert list(page.images) == expected
    for source in page.images.values():
        svg = base64.b64decode(source.removeprefix("data:image/svg+xml;base64,"))
        assert ElementTree.fromstring(svg).tag.endswith("svg")
        assert len(svg) > 5000
    assert page.pre == "name: turning <arm> & more\n"
    assert "<title>turning &lt;arm&gt; &amp; more</title>" in text


def test_the_numbers_are_those_of_the_motion(turning: Path) -> None:
    rows = Page(write_report(turning).read_text()).rows
    assert rows["Simulated time"] == "0 s to 4 s"
    # a polygon of 400 sides inscribed in the circle of the tip
    side = 2 * 0.5 * math.sin(math.pi / 400)
    assert float(rows["Path of the tip"].split()[0]) == pytest.approx(400 * side, rel=1e-3)
    assert float(rows["Fastest tip speed"].split()[0]) == pytest.approx(side / 0.01, rel=1e-3)
    assert rows["Room taken by the tip"] == "1 × 1 × 0 m"
    assert rows["Largest effort"] == "0.75 (pitch)"
    assert rows["Energy residual at the end"] == "0.002 J"
    assert float(rows["… of the largest entry"]) == pytest.approx(0.002 / 0.7, rel=0.02)
    assert rows["Commands, wrenches, events"] == "1, 0, 1"
    assert rows["Real-time factor"] == "0.998" and rows["Missed deadlines"] == "3"
    assert rows["Step, worst"] == "1210 µs" and rows["Ended by"] == "SIGINT"
    assert rows["numpy"] == np.__version__
    assert rows["/soft_arm/backbone"] == "401"


def test_equal_runs_give_equal_pages(turning: Path, tmp_path: Path) -> None:
    first = write_report(turning, tmp_path / "a" / "one.html").read_bytes()
    assert write_report(turning, tmp_path / "two.html").read_bytes() == first


def test_a_torn_recording_says_so_at_the_top(turning: Path) -> None:
    (file,) = turning.glob("*.mcap")
    data = file.read_bytes()
    file.write_bytes(data[:-40])
    with pytest.warns(UserWarning, match="never closed"):
        text = write_report(turning).read_text()
    assert text.index("was never closed") < text.index("<img")


def test_an_empty_recording_still_gives_a_page(tmp_path: Path) -> None:
    BagWriter(tmp_path / "empty", recorded_topics("/soft_arm")).close()
    page = Page(write_report(tmp_path / "empty").read_text())
    assert page.images == {} and page.rows["Messages"] == "0"
    assert page.heading == "empty"  # no scene inside: the name of the directory


def test_a_broken_summary_is_named(turning: Path) -> None:
    (turning / "summary.json").write_text("{not json")
    with pytest.raises(RecordingError, match=r"summary.json: is not JSON"):
        write_report(turning)


def test_without_a_summary_the_timing_comes_from_the_stamps(turning: Path) -> None:
    (turning / "summary.json").unlink()
    page = Page(write_report(turning).read_text())
    assert "Timing" in page.images and "Real-time factor" not in page.rows


def test_the_picture_shows_the_motion_in_the_colours_of_time(turning: Path) -> None:
    path = picture(turning, turning / "pictures" / "motion.png")
    image = matplotlib.image.imread(path)
    assert image.shape[0] > 600 and image.shape[1] > 1200
    colours = matplotlib.colormaps["viridis"]([0.0, 0.5, 1.0])[:, :3]
    for colour in colours:  # the first, a middle and the last snapshot are there
        assert (np.abs(image[..., :3] - colour).max(axis=2) < 0.03).sum() > 50


def test_a_picture_needs_a_backbone(tmp_path: Path) -> None:
    BagWriter(tmp_path / "empty", recorded_topics("/soft_arm")).close()
    with pytest.raises(RecordingError, match="cannot be drawn: it holds no backbone"):
        picture(tmp_path / "empty", tmp_path / "x.png")


def test_neither_ros_nor_a_display_is_needed(turning: Path) -> None:
    code = (
        "import sys\n"
        "sys.modules['rclpy'] = None\n"  # importing it would now fail
        "import soft_sim_ros.report as report\n"
        "assert 'matplotlib' not in sys.modules, 'it is imported only to draw'\n"
        "assert 'numba' not in sys.modules, 'a report needs no solver'\n"
        "report.write_report(sys.argv[1])\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    root = str(Path(soft_sim_ros.__file__).parents[1])
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "MPLBACKEND")}
    environment["PYTHONPATH"] = os.pathsep.join([root, environment.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", code, str(turning)], env=environment, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert (turning / "report.html").exists()


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=400), st.integers(2, 50))
def test_thinning_keeps_ends_and_extremes(values: list[float], limit: int) -> None:
    y = np.array(values)
    time, kept = thin(np.arange(len(y)), y, limit)
    assert len(time) <= max(limit, 2) + 4 and (np.diff(time) > 0).all()
    assert (kept.min(), kept.max()) == (y.min(), y.max())
    assert (time[0], time[-1]) == (0, len(y) - 1)
    assert (y[time] == kept).all()


def test_thirty_two_lines_look_different() -> None:
    assert len({(v["color"], str(v["linestyle"])) for v in map(look, range(32))}) == 32


@given(st.integers(1, 1000), st.integers(1, 40))
def test_strides_have_both_ends(count: int, limit: int) -> None:
    chosen = stride(count, limit)
    assert len(chosen) == min(count, limit) and chosen[0] == 0
    assert chosen[-1] == (count - 1 if limit > 1 else 0)


def test_csv_tables_hold_exactly_what_was_recorded(turning: Path, tmp_path: Path) -> None:
    from soft_sim_ros.report import export_csv

    run = read_run(turning)
    written = {path.name: path for path in export_csv(run, tmp_path / "tables")}
    assert set(written) == {
        "backbone.csv",
        "tip_pose.csv",
        "joint_states.csv",
        "strain_state.csv",
        "energy.csv",
        "inputs.csv",
    }
    table = np.genfromtxt(written["backbone.csv"], delimiter=",", names=True)
    assert table.dtype.names[:9] == (
        "time",
        *(f"{n}0" for n in ["x", "y", "z", "qx", "qy", "qz", "qw"]),
        "x1",
    )
    values = np.array(table.tolist())
    np.testing.assert_array_equal(values[:, 0], run.backbone.time)
    np.testing.assert_array_equal(
        values[:, 1:].reshape(run.backbone.poses.shape), run.backbone.poses
    )
    header = written["joint_states.csv"].read_text().splitlines()[0]
    assert header == (
        "time,position:yaw,position:pitch,velocity:yaw,velocity:pitch,effort:yaw,effort:pitch"
    )
    assert written["inputs.csv"].read_text().splitlines() == [
        "time,topic,name,value,unit",
        "0.0,/soft_arm/command,0,0.25,",
        "0.0,/soft_arm/command,1,0.0,",
        "1.0,/soft_arm/events,,reset,",
    ]


def test_npz_holds_every_array(turning: Path, tmp_path: Path) -> None:
    from soft_sim_ros.report import export_npz

    run = read_run(turning)
    path = export_npz(run, tmp_path / "run")
    assert path == tmp_path / "run.npz"
    with np.load(path) as arrays:
        np.testing.assert_array_equal(arrays["backbone_poses"], run.backbone.poses)
        np.testing.assert_array_equal(arrays["backbone_time_ns"], run.backbone.time_ns)
        np.testing.assert_array_equal(arrays["energy_values"], run.energy.values)
        assert tuple(arrays["energy_names"]) == run.energy.names
        np.testing.assert_array_equal(arrays["joint_states_effort"], run.joint_states.effort)
        assert tuple(arrays["joint_states_name"]) == ("yaw", "pitch")


def test_the_summary_may_lack_anything(turning: Path) -> None:
    (turning / "summary.json").write_text(json.dumps({"step_cost": None, "recording": None}))
    assert "Timing" in Page(write_report(turning).read_text()).images
