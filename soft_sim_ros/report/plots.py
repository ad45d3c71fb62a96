"""Plots over time: tip, actuators, energy, timing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter
from numpy.typing import NDArray

from soft_sim_ros.recording.reader import Run
from soft_sim_ros.report.numbers import short, tip_paths
from soft_sim_ros.report.style import COLOURS, FAINT, INK, look, shown, thin
from soft_sim_ros.report.units import grouped, port_units

_WIDTH = 10.0
_MOST_NAMES = 32  # more lines than this are drawn without a legend: no two of these look alike
_COLUMN = 12  # names in one column of a legend
_APART = 0.08  # of the time shown: events closer than this share one label
_MOST_LINES = 64  # no more are drawn


def tip(run: Run, name: str = "") -> Figure:
    """Draw the position of a tip and its speed."""
    time, position = tip_paths(run)[name]
    figure, (upper, lower) = _two(2.0, 1.0)
    for index, name in enumerate("xyz"):
        upper.plot(*thin(time, position[:, index]), label=name, **look(index))
    upper.set(title="Tip position", ylabel="m")
    legend(upper)
    distinct = np.concatenate([[True], np.diff(time) > 0.0]) if len(time) else np.empty(0, bool)
    time, position = time[distinct], shown(position[distinct])
    if len(time) > 1:
        speed = np.linalg.norm(np.gradient(position, time, axis=0), axis=1)
        lower.plot(*thin(time, speed), color=INK, linewidth=1.0)
    lower.set(title="Tip speed", ylabel="m/s", xlabel="time (s)")
    mark_events(run, upper, lower)
    return figure


def actuators(run: Run) -> Figure:
    """Draw effort and conjugate position of every actuator; what shares axes shares its unit."""
    joints = run.joint_states
    groups = grouped(joints.name[:_MOST_LINES], port_units(run))
    figure = Figure(figsize=(_WIDTH, 4.6 * len(groups)), layout="constrained")
    panels = figure.subplots(2 * len(groups), 1, sharex=True)
    for place, ((effort, position), members) in enumerate(groups.items()):
        upper, lower = panels[2 * place : 2 * place + 2]
        for index in members:
            label = short(joints.name[index])
            if index < joints.effort.shape[1]:
                upper.plot(*thin(joints.time, joints.effort[:, index]), label=label, **look(index))
            if index < joints.position.shape[1]:
                values = joints.position[:, index]
                lower.plot(*thin(joints.time, values), label=label, **look(index))
        upper.set(title="Actuator efforts", ylabel=effort)
        lower.set(title="Conjugate positions", ylabel=position)
        legend(upper)
    panels[-1].set(xlabel="time (s)")
    mark_events(run, *panels)
    return figure


def energy(run: Run) -> Figure:
    """Draw the energy ledger, and below it what the ledger cannot account for."""
    ledger = run.energy
    figure, (upper, lower) = _two(1.7, 1.0)
    entries = [name for name in ledger.names if name != "residual"]
    for index, name in enumerate(entries[:_MOST_LINES]):
        label = short(name.replace("_", " "))
        upper.plot(*thin(ledger.time, ledger[name]), label=label, **look(index))
    upper.set(title="Energy ledger", ylabel="J")
    legend(upper)
    if "residual" in ledger.names:
        lower.axhline(0, color=FAINT, linewidth=1)
        lower.plot(*thin(ledger.time, ledger["residual"]), color=COLOURS[1], linewidth=1.0)
    lower.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
    lower.set(title="Residual of the ledger", ylabel="J", xlabel="time (s)")
    mark_events(run, upper, lower)
    return figure


def timing(run: Run, summary: Mapping[str, Any]) -> Figure:
    """Draw what a step cost, if the summary says so, and how evenly messages are spaced."""
    figure = Figure(figsize=(_WIDTH, 3.0), layout="constrained")
    cost = summary.get("step_cost") or {}
    bins = cost.get("histogram") or []
    panels = figure.subplots(1, 2 if bins else 1, squeeze=False)[0]
    if bins:
        _draw_cost(panels[0], cost, bins)
    intervals = [
        (name, np.diff(series.time_ns) / 1e6)
        for name, series in (("backbone", run.backbone), ("joint_states", run.joint_states))
        if len(series) > 1
    ]
    axes = panels[-1]
    for index, (name, values) in enumerate(intervals):
        _draw_intervals(axes, name, values, index)
    axes.set(
        title="Simulation time between messages", xlabel="interval (ms)", ylabel="share of messages"
    )
    if intervals:
        legend(axes)
    return figure


def _draw_cost(axes: Axes, cost: Mapping[str, Any], bins: list[Mapping[str, Any]]) -> None:
    """Draw a histogram that was counted in uneven bins, on a logarithmic axis."""
    worst = float(cost.get("worst_us") or 0.0)
    high = np.array([float(b["to_us"] or max(worst, 2 * b["from_us"])) for b in bins])
    low = np.maximum([float(b["from_us"]) for b in bins], high / 10)  # 0 is far on such an axis
    counts = np.array([int(b["steps"]) for b in bins])
    axes.bar(low, counts / max(counts.sum(), 1), width=high - low, align="edge", color=COLOURS[5])
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    for key, label, colour in (
        ("p50_us", "median", COLOURS[0]),
        ("p99_us", "99 %", COLOURS[4]),
        ("worst_us", "worst", COLOURS[1]),
    ):
        if cost.get(key):
            value = float(cost[key])
            axes.axvline(value, color=colour, linewidth=1.3, label=f"{label} {value:.4g} µs")
    axes.set(title="Cost of a step", xlabel="wall time (µs)", ylabel="share of steps")
    legend(axes)


def _draw_intervals(axes: Axes, name: str, values: NDArray, index: int) -> None:
    width = max(float(values.max() - values.min()), 0.02 * float(values.max()), 1e-6)
    middle = float(values.max() + values.min()) / 2
    edges = np.linspace(middle - 0.55 * width, middle + 0.55 * width, 32)
    counts, _ = np.histogram(values, edges)
    axes.stairs(
        counts / len(values),
        edges,
        fill=index == 0,
        alpha=0.55 if index == 0 else 1.0,
        color=COLOURS[index],
        label=f"{name}, mean {values.mean():.4g} ms",
    )


def _two(upper: float, lower: float) -> tuple[Figure, NDArray]:
    figure = Figure(figsize=(_WIDTH, 4.6), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True, height_ratios=[upper, lower])
    return figure, panels


def legend(axes: Axes) -> None:
    """Name the lines beside axes, unless there are too many to tell apart."""
    lines = axes.get_legend_handles_labels()[1]
    if 0 < len(lines) <= _MOST_NAMES:
        axes.legend(
            loc="upper left",
            bbox_to_anchor=(1.0, 1.02),
            borderaxespad=0.4,
            ncols=-(-len(lines) // _COLUMN),
            handlelength=2.6,  # long enough for dashes to be told apart
        )


def mark_events(run: Run, *panels: Axes) -> None:
    """Mark resets, pauses and the like by thin vertical lines, named once."""
    room, free = _APART * max(run.end - run.start, 1e-9), -np.inf
    for time_ns, text in run.events[:40]:
        for axes in panels:
            axes.axvline(time_ns / 1e9, color="#9aa5b1", linewidth=0.8, linestyle=(0, (2, 2)))
        if time_ns / 1e9 < free:  # the line says it, a label would lie on the one before
            continue
        free = time_ns / 1e9 + room
        panels[0].text(
            time_ns / 1e9,
            1.0,
            f" {short(text.split(':')[0])[:30]}",
            transform=panels[0].get_xaxis_transform(),
            fontsize=7,
            color="#66717d",
            va="top",
        )
