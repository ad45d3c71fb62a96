"""Draw scenes as docs/forest.md, fluid.md and others show them: ``python tools/gallery.py``.

Each is simulated from its start under the efforts and drives below, and drawn at some instants in
one picture, earlier ones paler. Shapes and colours are those of the viewer (soft_sim_ros/viewing).
"""

from __future__ import annotations

import argparse
import io
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import NDArray

from soft_sim_ros import Scene, Simulation, load_scene
from soft_sim_ros.files import write_whole
from soft_sim_ros.report.style import FAINT, INK, RC
from soft_sim_ros.viewing import shapes
from soft_sim_ros.viewing.scenery import Scenery
from soft_sim_ros.viewing.shapes import REMOVED, Shape
from soft_sim_ros.viewing.tube import rotations

DOCS = Path(__file__).parents[1] / "docs"
STONE = np.array([0.55, 0.53, 0.5, 0.45])
LIGHT = np.array([0.3, -0.6, 0.75])
ROUND = 14  # sides of what is round
Array = NDArray[Any]


@dataclass(frozen=True)
class Shot:
    """What a picture shows.

    times : instants in s that are drawn
    efforts : of actuators by name; all others are zero
    view : elevation and azimuth in degrees
    page : of docs/, beside which its folder is
    drives : where driven joints that follow commands go within the time of the first instant
        after 0, in m or rad
    wave : period in s and length over that of the arm of a wave along the actuators, if efforts are
        its amplitudes
    """

    times: tuple[float, ...]
    efforts: dict[str, float]
    view: tuple[float, float]
    page: str = "forest"
    drives: dict[str, float] = field(default_factory=dict)
    wave: tuple[float, float] | None = None


SHOTS = {
    "two_arms": Shot(
        (0.0, 1.5),
        {"left_0": 15.0, "right_120": 10.0, "right_240": 20.0},
        (14.0, -20.0),
    ),
    "hand": Shot(
        (0.0, 0.8),
        {"index_flexor": 1.0, "middle_flexor": 5.0, "ring_flexor": 9.0, "little_flexor": 7.0,
         "thumb_flexor": 6.0, "wrist_motor": 0.5},
        (18.0, 196.0),
    ),
    "branched": Shot(
        (0.0, 1.5),
        {"branch_bend_y": 0.3, "branch_bend_z": 0.3, "hinge_motor": 0.5},
        (12.0, -35.0),
    ),
    "mobile_arm": Shot((0.0, 1.0, 2.1), {"pull_120": 6.0}, (24.0, -70.0)),
    "swimmer": Shot((0.0, 5.0, 8.0), {"steer": 0.01}, (58.0, -84.0), "fluid"),
    "table": Shot((0.0, 1.0), {"left": 25.0}, (24.0, -60.0), "contact"),
    "corner": Shot((0.0, 1.0), {"left": 20.0}, (24.0, -50.0), "contact"),
    "closed_arch": Shot(
        (0.0, 1.0), {"sway_near": 0.03, "sway_far": 0.03}, (16.0, -65.0), "constraints",
        {"carriage": -0.12},
    ),
    "parallel_robot": Shot(
        (0.0, 1.0), {}, (16.0, -55.0), "constraints",
        {"slide_1": 0.05, "slide_2": 0.05, "slide_3": 0.03, "slide_6": 0.02},
    ),
    "grasp": Shot(
        (0.0, 1.0, 2.0),
        {"first_flexor": 5.0, "second_flexor": 5.0, "third_flexor": 5.0},
        (12.0, -60.0),
        "contact",
    ),
    "snake": Shot(
        (0.0, 2.25, 4.5), {f"m{i}": 0.15 for i in range(6)}, (40.0, -80.0), "contact", (1.0, 1.0)
    ),
}  # fmt: skip


@dataclass
class Canvas:
    """Where a shape is drawn."""

    pose: Array = field(default_factory=lambda: np.array([0.0, 0, 0, 0, 0, 0, 1]))
    points: Array = field(default_factory=lambda: np.zeros((0, 3)))
    colour: Array = field(default_factory=lambda: np.ones(4, dtype=np.float32))
    action: Array = field(default_factory=lambda: np.zeros(1, dtype=np.int32))


def sphere() -> Array:
    """Return the triangles (T, 3, 3) of a ball of diameter 1."""
    angle, height = np.meshgrid(np.linspace(0, 2 * np.pi, ROUND + 1), np.linspace(0, np.pi, ROUND))
    grid = [np.sin(height) * np.cos(angle), np.sin(height) * np.sin(angle), np.cos(height)]
    return patches(0.5 * np.stack(grid, axis=-1))


def cylinder() -> Array:
    """Return the triangles (T, 3, 3) of a cylinder along z, of diameter and height 1."""
    angle = np.linspace(0, 2 * np.pi, ROUND + 1)
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    rings = [(0.0, -0.5), (0.5, -0.5), (0.5, 0.5), (0.0, 0.5)]
    made = [np.concatenate([r * rim, np.full((len(rim), 1), z)], axis=1) for r, z in rings]
    return patches(np.stack(made)[::-1])


def cube() -> Array:
    """Return the triangles (T, 3, 3) of a cube of edge 1."""
    side = patches(np.array([[[-0.5, -0.5, 0.5], [-0.5, 0.5, 0.5]],
                             [[0.5, -0.5, 0.5], [0.5, 0.5, 0.5]]]))  # fmt: skip
    turned = [np.roll(side, k, axis=-1) for k in range(3)]
    return np.concatenate([*turned, *(-part[:, ::-1] for part in turned)])


def patches(grid: Array) -> Array:
    """Return two triangles (T, 3, 3) for each cell of a grid of points (M, N, 3)."""
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    both = np.stack([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)])
    return both.reshape(-1, 3, 3)


SOLIDS = {shapes.SPHERE: sphere(), shapes.CYLINDER: cylinder(), shapes.CUBE: cube()}


def triangles(shape: Shape, canvas: Canvas) -> Array:
    """Return the triangles (T, 3, 3) of a tube or a solid in the world, in m."""
    if shape.kind == shapes.TRIANGLE_LIST:
        return canvas.points.reshape(-1, 3, 3).copy()
    turn = rotations(canvas.pose[None, 3:])[0]
    return canvas.pose[:3] + (SOLIDS[shape.kind] * shape.scale) @ turn.T


def shaded(faces: Array, colour: Array, share: float) -> Array:
    """Return the colours (T, 4) of triangles in a light; ``share`` 1 is as it is, 0 is white."""
    normal = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    length = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    bright = 0.72 + 0.28 * (normal @ LIGHT) / (length * np.linalg.norm(LIGHT))
    out = np.ones((len(faces), 4))
    out[:, :3] = 1.0 - share * (1.0 - np.outer(bright, colour[:3]))
    out[:, 3] = colour[3] * (0.3 + 0.7 * share)
    return out


def lines(shape: Shape, canvas: Canvas) -> Array:
    """Return a line or an arrow (P, 3), the latter with its head, in m."""
    points = canvas.points.copy()
    if shape.kind != shapes.ARROW:
        return points
    way = points[1] - points[0]
    side = np.cross(way, LIGHT) / np.linalg.norm(LIGHT)
    heads = [points[1] - 0.25 * way + sign * 0.12 * side for sign in (1.0, -1.0)]
    return np.stack([points[0], points[1], heads[0], points[1], heads[1]])


def surroundings(scene: Scene, points: Array) -> list[Array]:
    """Return the triangles (T, 3, 3) of the shapes of a scene; planes below points (P, 3)."""
    made = []
    for shape in scene.environment:
        r, half, _ = shape.size.tolist()
        if shape.kind == "plane":
            local = (points - shape.position) @ shape.axes[:, :2]
            low, high = local.min(axis=0) - 0.03, local.max(axis=0) + 0.03
            x, y = np.meshgrid(np.linspace(low[0], high[0], 2), np.linspace(low[1], high[1], 2))
            solid = patches(np.stack([x, y, 0.0 * x], axis=-1))
        elif shape.kind in ("box", "ellipsoid"):
            unit = SOLIDS[shapes.CUBE if shape.kind == "box" else shapes.SPHERE]
            solid = unit * (2.0 * shape.size)
        elif shape.kind == "sphere":
            solid = SOLIDS[shapes.SPHERE] * (2.0 * r)
        else:
            solid = SOLIDS[shapes.CYLINDER] * (2.0 * np.array([r, r, half]))
        made.append(shape.position + solid @ shape.axes.T)
    return made


def waved(wave: tuple[float, float], amplitudes: list[float], time: float) -> list[float]:
    """Return the efforts of a wave that travels along the actuators; it sets in within half a s."""
    period, length = wave
    places = (np.arange(len(amplitudes)) + 0.5) / len(amplitudes)
    phase = 2.0 * np.pi * (time / period - places / length)
    return (min(1.0, 2.0 * time) * np.array(amplitudes) * np.sin(phase)).tolist()


def draw(name: str) -> Figure:
    """Return the picture of a scene."""
    shot, simulation = SHOTS[name], Simulation(load_scene(name))
    scenery = Scenery(simulation)
    own = [part.shape for part in scenery.parts]
    canvases = [Canvas(points=np.zeros((shape.points, 3))) for shape in own]
    for shape, canvas in zip(own, canvases, strict=True):
        canvas.colour[:] = shape.colour
    efforts = [shot.efforts.get(actuator.name, 0.0) for actuator in simulation.scene.actuators]
    simulation.set_efforts(efforts)
    for joint, goal in shot.drives.items():
        simulation.set_driven(joint, goal)
    step, done = simulation.scene.numerics.step, 0
    faces, colours, strokes, inks, widths = [], [], [], [], []
    for number, time in enumerate(shot.times, 1):
        while done < round(time / step):
            made = 5 if shot.wave else round(time / step) - done
            if shot.wave:
                simulation.set_efforts(waved(shot.wave, efforts, done * step))
            simulation.advance(made)
            done += made
        scenery.draw(canvases)
        share = (0.35 + 0.65 * number / len(shot.times)) if number < len(shot.times) else 1.0
        for shape, canvas in zip(own, canvases, strict=True):
            if canvas.action[0] == REMOVED or (shape.kind == shapes.ARROW and share < 1.0):
                continue
            if shape.kind in (shapes.LINE_STRIP, shapes.ARROW):
                strokes.append(lines(shape, canvas))
                inks.append((*(1.0 - share * (1.0 - canvas.colour[:3])), share))
                widths.append(1.2)
            else:
                faces.append(triangles(shape, canvas))
                colours.append(shaded(faces[-1], canvas.colour, share))
    for solid in surroundings(simulation.scene, np.concatenate(faces).reshape(-1, 3)):
        faces.append(solid)
        colours.append(shaded(solid, STONE, 1.0))
    return picture(shot, np.concatenate(faces), np.concatenate(colours), (strokes, inks, widths))


def picture(shot: Shot, faces: Array, colours: Array, drawn: tuple[list, list, list]) -> Figure:
    """Return triangles (T, 3, 3), their colours (T, 4) and lines in space."""
    points = faces.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), 0.53 * np.maximum(high - low, 0.35 * np.ptp(points))
    figure = Figure(figsize=(5.2, 5.2), layout="constrained")
    axes: Any = figure.add_subplot(projection="3d", proj_type="ortho")
    axes.add_collection3d(Poly3DCollection(faces, facecolors=colours, edgecolors="none"))
    if drawn[0]:
        axes.add_collection3d(Line3DCollection(drawn[0], colors=drawn[1], linewidths=drawn[2]))
    low, high = middle - half, middle + half
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    axes.set_box_aspect(high - low, zoom=0.82)
    axes.view_init(elev=shot.view[0], azim=shot.view[1])
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1, 1, 1, 0))
        axis._axinfo["grid"].update(color=FAINT, linewidth=0.6)  # no public way to set it
        axis.set_major_locator(MaxNLocator(4))
        axis.label.set_color(INK)
    return figure


def main() -> None:
    """Write one PNG for each scene."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("scenes", nargs="*", default=list(SHOTS), help="default: all of them")
    parser.add_argument("--out", type=Path, default=DOCS, help="folder; default docs")
    options = parser.parse_args()
    for name in options.scenes:
        folder = options.out / SHOTS[name].page
        folder.mkdir(parents=True, exist_ok=True)
        image = io.BytesIO()
        with matplotlib.rc_context(RC):
            draw(name).savefig(image, format="png", dpi=110, metadata={"Software": None})
        write_whole(folder / f"{name}.png", image.getvalue())
        print(folder / f"{name}.png")


if __name__ == "__main__":
    main()
