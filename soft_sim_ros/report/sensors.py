"""Readings of sensors: plots over time, and columns of tables."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from soft_sim_ros.recording.reader import Run
from soft_sim_ros.recording.sensor_series import SensorSeries
from soft_sim_ros.report.numbers import short
from soft_sim_ros.report.plots import legend, mark_events
from soft_sim_ros.report.style import look, thin
from soft_sim_ros.scene.sensor import QUANTITIES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_SENSORS = 16  # no more are drawn
MOST_LINES = 64
_WIDTH = 10.0
UNITS = {name: unit for kind in QUANTITIES.values() for name, (_, unit) in kind.items()}


def pictures(run: Run) -> list[tuple[str, bool, Callable[[], Figure]]]:
    """Return title, whether there is anything, and what draws it, of every sensor."""
    found = list(run.sensors.items())[:MOST_SENSORS]
    return [
        (f"Sensor {short(name)}", len(one) > 0, partial(sensor, run, one)) for name, one in found
    ]


def sensor(run: Run, series: SensorSeries) -> Figure:
    """Draw the quantities of a sensor, each on axes of its own, over the time of measurement."""
    from matplotlib.figure import Figure

    groups: dict[str, list[int]] = {}
    for index, label in enumerate(series.labels[:MOST_LINES]):
        groups.setdefault(label.split("/")[0], []).append(index)
    figure = Figure(figsize=(_WIDTH, 0.8 + 1.9 * len(groups)), layout="constrained")
    panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (quantity, members) in zip(panels, groups.items(), strict=True):
        for line, index in enumerate(members):
            label = short(series.labels[index].partition("/")[2] or quantity)
            axes.plot(*thin(series.measured, series.values[:, index]), label=label, **look(line))
        unit = "" if quantity == "orientation" else UNITS.get(quantity, "")
        axes.set(title=short(quantity.replace("_", " ")).capitalize(), ylabel=unit)
        legend(axes)
    panels[-1].set(xlabel="time of measurement (s)")
    mark_events(run, *panels)
    return figure
