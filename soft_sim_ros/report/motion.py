"""The motion of an arm in one picture: the backbone at many instants, coloured by time."""

from __future__ import annotations

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from numpy.typing import NDArray

from soft_sim_ros.recording.reader import Run
from soft_sim_ros.report.shapes import shapes_of
from soft_sim_ros.report.style import FAINT, INK, TIME_COLOURS, stride

SNAPSHOTS = 9
_AXES = "xyz"
ABOVE = (0, 1)


def motion(run: Run, snapshots: int = SNAPSHOTS) -> Figure:
    """Draw the backbones in space, from the side where most is to be seen, and from above.

    Parameters
    ----------
    run : recording with at least one instant at which the backbones are drawable
    snapshots : number of instants drawn
    """
    shapes = shapes_of(run)
    shapes = shapes.at(shapes.drawable)
    times, positions = shapes.time, shapes.poses[..., :3]
    chosen = stride(len(times), snapshots)
    curves = [positions[chosen, part] for part in shapes.parts]
    paths = [positions[stride(len(times), 600), part.stop - 1] for part in shapes.parts]
    path_time = times[stride(len(times), 600)]
    low, high = _box(positions)
    span = Normalize(times[0], max(times[-1], times[0] + 1e-3))
    colours = ScalarMappable(span, TIME_COLOURS)
    shades = colours.to_rgba(times[chosen])

    figure = Figure(figsize=(10, 5.2), layout="constrained")
    planes = _projections(high - low)
    extent = high - low
    across, up = planes[0]
    tall = extent[up] > 1.2 * extent[across]
    if tall:
        grid = figure.add_gridspec(1, 3, width_ratios=[1.4, 1, 1])
        places = [grid[0, 0], grid[0, 1], grid[0, 2]]
    else:
        grid = figure.add_gridspec(2, 2, width_ratios=[1.5, 1])
        places = [grid[:, 0], grid[0, 1], grid[1, 1]]
    space = figure.add_subplot(places[0], projection="3d", proj_type="ortho")
    for curve, path in zip(curves, paths, strict=True):
        _draw_space(space, curve, path, shades, low, high)
    space.set_box_aspect(extent, zoom=0.98 if tall else 1.08)
    for place, (across, up) in zip(places[1:], planes, strict=True):
        axes = figure.add_subplot(place)
        for curve, path in zip(curves, paths, strict=True):
            _draw_plane(axes, curve, path, path_time, shades, span, (across, up))
        axes.set(xlim=(low[across], high[across]), ylim=(low[up], high[up]))
        axes.set_title("from above" if (across, up) == ABOVE else "from the side")
    bar = figure.colorbar(colours, ax=figure.axes, shrink=0.6, aspect=30, pad=0.02)
    bar.set_label("time (s)")
    bar.outline.set_visible(False)
    return figure


def _box(points: NDArray) -> tuple[NDArray, NDArray]:
    """Give the corners of a box (3,) around all points, with a margin and never flat.

    Arms are slender and some move in a plane: a box as flat as the motion could not be read.
    """
    flat = points.reshape(-1, 3)
    low, high = flat.min(axis=0), flat.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    half = np.maximum(half * 1.06, max(0.45 * half.max(), 1e-6))
    return middle - half, middle + half


def _projections(extent: NDArray) -> list[tuple[int, int]]:
    """Choose the side with the most to see, where z points up, and the view from above."""
    return [max(((0, 2), (1, 2)), key=lambda plane: extent[plane[0]]), ABOVE]


def _draw_space(
    axes, curves: NDArray, path: NDArray, shades: NDArray, low: NDArray, high: NDArray
) -> None:
    axes.add_collection3d(Line3DCollection(curves, colors=shades, linewidths=1.9))
    axes.plot(*path.T, color=INK, linewidth=0.5, alpha=0.55)
    axes.scatter(*curves[:, -1].T, c=shades, s=10, depthshade=False)
    axes.scatter(*curves[0, 0], c=INK, s=26, marker="s", depthshade=False)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.view_init(elev=20, azim=-58)
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1, 1, 1, 0))
        axis._axinfo["grid"].update(color=FAINT, linewidth=0.6)  # no public way to set it
        axis.set_major_locator(MaxNLocator(4))


def _draw_plane(
    axes,
    curves: NDArray,
    path: NDArray,
    path_time: NDArray,
    shades: NDArray,
    span: Normalize,
    plane: tuple[int, int],
) -> None:
    across, up = plane
    axes.add_collection(LineCollection(list(curves[..., plane]), colors=shades, linewidths=1.6))
    steps = np.stack([path[:-1, plane], path[1:, plane]], axis=1)
    tip = LineCollection(list(steps), cmap=TIME_COLOURS, norm=span, linewidths=0.9, alpha=0.9)
    tip.set_array(path_time[:-1])
    axes.add_collection(tip)
    axes.plot(*curves[0, 0, plane], "s", color=INK, markersize=4)
    axes.set_aspect("equal")
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.set(xlabel=f"{_AXES[across]} (m)", ylabel=f"{_AXES[up]} (m)")
