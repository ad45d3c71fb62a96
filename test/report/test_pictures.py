"""What a reader must be able to tell apart in plots, and read."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from soft_sim_ros.recording.reader import read_run
from soft_sim_ros.recording.series import JointSeries
from soft_sim_ros.report import plots
from soft_sim_ros.report.motion import ABOVE, motion


def many(count):
    """A run of so many actuators."""
    names = tuple(f"cable_{i}" for i in range(count))
    values = np.linspace(0, 1, 5)[:, None] * np.arange(count)
    time_ns = np.arange(5) * 10**9
    joints = JointSeries(time_ns, names, values, values, values)
    return SimpleNamespace(
        joint_states=joints, scene_text=None, events=[(0, "reset"), (1000, "pause")],
        start=0.0, end=4.0,
    )  # fmt: skip


@pytest.mark.parametrize("count", [6, 16, 32])
def test_a_legend_names_every_actuator_by_a_look_of_its_own(count):
    figure = plots.actuators(many(count))
    FigureCanvasAgg(figure).draw()
    legend = figure.axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == [f"cable_{i}" for i in range(count)]
    looks = {(line.get_color(), line.get_linestyle(), str(line._dash_pattern))
             for line in legend.get_lines()}  # fmt: skip
    assert len(looks) == count
    box, picture = legend.get_window_extent(), figure.bbox
    assert picture.y0 <= box.y0 and box.x1 <= picture.x1 + 1


def test_labels_of_events_at_nearly_the_same_time_do_not_lie_on_each_other():
    labels = plots.actuators(many(2)).axes[0].texts
    assert [label.get_text().strip() for label in labels] == ["reset"]


def test_the_picture_of_a_motion_has_few_shapes_and_a_view_from_above(turning):
    figure = motion(read_run(turning))
    views = {axes.get_title(loc="left") or axes.get_title(): axes for axes in figure.axes}
    above = views["from above"]
    across, _ = ABOVE
    assert above.get_xlabel() == f"{'xyz'[across]} (m)" and above.get_ylabel() == "y (m)"
    assert len(above.collections[0].get_segments()) <= 10
