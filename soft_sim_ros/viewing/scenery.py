"""The picture of an arm: which parts a scene has, and drawing them all."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from soft_sim_ros.core.simulation.bounds import Bounds
from soft_sim_ros.scene import Attachment, Joint, Pose, RigidBody, Scene
from soft_sim_ros.scene.actuator import ChamberActuator, TendonActuator
from soft_sim_ros.scene.load import DistributedLoad, PointLoad
from soft_sim_ros.scene.pose import IDENTITY
from soft_sim_ros.scene.summary import total_mass
from soft_sim_ros.scene.taper import Floats
from soft_sim_ros.viewing import shapes
from soft_sim_ros.viewing.felt import felt_parts, strongest
from soft_sim_ros.viewing.frames import BASE, TIP, Frames, Spot
from soft_sim_ros.viewing.outline import FEW, Path, Stations, rods_of, stations, thickness
from soft_sim_ros.viewing.parts import (
    LONGEST,
    Arrow,
    Line,
    Part,
    Shade,
    Solid,
    State,
    Tube,
    multiply,
    upright,
)
from soft_sim_ros.viewing.shapes import Canvas, Shape
from soft_sim_ros.viewing.tube import rotations

if TYPE_CHECKING:
    from soft_sim_ros.core.settled import Simulation

STATIONS = 24  # along all rods
ALONG = 5  # arrows of a load along a rod
G = 9.81  # m/s²
SAME = 1e-9  # of two poses: in m, and of a unit quaternion
AHEAD = np.array([0.0, 0.0, 0.0, 1.0])
Vector = Callable[[State], Floats]


class Scenery:
    """All shapes of a simulation, and how they are drawn at its present state.

    Parameters
    ----------
    simulation : the arm

    Attributes
    ----------
    parts : one for each shape; their order, groups and numbers never change
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation, scene = simulation, simulation.scene
        self._length = simulation.length
        self._weight = max(total_mass(scene) * G, 1e-9)
        self._spots: list[Spot] = [(TIP, 0.0)]
        self._thick = thickness(scene, self._length)
        self._efforts = np.abs(Bounds.of_arm(scene, self._length).efforts).max(axis=1)
        paths = [a for a in scene.actuators if isinstance(a, TendonActuator | ChamberActuator)]
        self._fixed: list[tuple[int, list[float]]] = []  # frame, and y, z in m in it
        self.parts: list[Part] = []
        first: dict[str, tuple[int, Stations]] = {}
        for number, rod in enumerate(rods_of(scene)):
            count = max(4, math.ceil(STATIONS * rod.length / self._length))
            own = stations(rod, paths, count)
            at = [self._spot(rod.name, s) for s in own.s.tolist()]
            first[rod.name] = at[0], own
            self.parts.append(Tube(("rods", number), at, own.rings(FEW), shapes.SILICONE))
        for number, body in enumerate(scene.bodies):
            if isinstance(body, Joint):
                self._joint(number, body)
            elif isinstance(body, RigidBody):
                self._rigid_body(number, body)
        for number, actuator in enumerate(scene.actuators):
            if isinstance(actuator, TendonActuator | ChamberActuator):
                self._path(number, actuator, first)
        for number, load in enumerate(scene.scheduled_loads):
            self._load(number, load)
        for number, part in enumerate((slice(3, 6), slice(0, 3))):
            self._arrow("external_wrench", number, 0, _wrench(part), part.start > 0)
        longest = LONGEST * self._length
        self.parts += felt_parts(scene, self._head, self._weight, self._length, longest)
        self._frames = Frames(simulation.compiled, simulation.q, self._spots)
        self._at = np.array([at for at, _ in self._fixed], dtype=np.int64)
        self._yz = np.array([yz for _, yz in self._fixed]).reshape(-1, 2, 1)

    def draw(self, canvases: Sequence[Canvas]) -> None:
        """Write the present state to one canvas for each part, always the same canvases."""
        simulation = self._simulation
        poses = self._frames.poses()
        turns = rotations(poses[:, 3:])
        _, wrench, follows = simulation.held()
        if follows:
            wrench = (turns[0] @ wrench.reshape(2, 3).T).T.ravel()
        efforts = simulation.ports()[2]
        points = poses[self._at, :3] + (turns[self._at, :, 1:] @ self._yz)[:, :, 0]
        contacts = strongest(simulation.contacts())
        reactions = simulation.reactions() if simulation.scene.constraints else {}
        state = State(simulation.time, poses, turns, points, efforts, wrench, contacts, reactions)
        for part, canvas in zip(self.parts, canvases, strict=True):
            part.draw(state, canvas)

    @property
    def _head(self) -> tuple[float, float, float]:
        """Size of arrows in m: shaft, head, its length."""
        width = 0.3 * self._thick
        return width, 2.2 * width, 3.0 * width

    def _spot(self, body: str, s: float = 0.0) -> int:
        self._spots.append((body, s))
        return len(self._spots) - 1

    def _joint(self, number: int, joint: Joint) -> None:
        size = 2.0 * self._thick
        kind = {
            "revolute": shapes.CYLINDER,
            "prismatic": shapes.CUBE,
            "universal": shapes.SPHERE,
            "spherical": shapes.SPHERE,
        }.get(joint.kind)
        if kind is None:  # nothing to be seen: it holds fast, or lets go of everything
            return
        turn = upright(joint.axis) if kind == shapes.CYLINDER else AHEAD
        shape = Shape("joints", number, kind, (1.1 * size, 1.1 * size, 1.3 * size), shapes.METAL)
        self.parts.append(Solid(shape, self._spot(joint.name), np.zeros(3), turn))

    def _rigid_body(self, number: int, body: RigidBody) -> None:
        scale = tuple((2.0 * semi_axes(body, self._thick)).tolist())
        shape = Shape("bodies", number, shapes.SPHERE, scale, shapes.METAL)
        at = self._spot(body.name)
        self.parts.append(Solid(shape, at, body.com.position, body.com.quaternion))

    def _path(self, number: int, path: Path, first: dict[str, tuple[int, Stations]]) -> None:
        at, places = [], []
        for stretch in path.stretches:
            begin, own = first[stretch.rod]
            chosen = own.along(stretch)
            at += [begin + i for i in chosen]
            s = np.clip(own.s[chosen], stretch.start, stretch.end)
            places.append(stretch.offset(s))
        if isinstance(path, ChamberActuator):  # a band of its true width
            group, width = "chambers", 2.0 * math.sqrt(path.area / np.pi)
        else:
            group, width = "tendons", 0.12 * self._thick
        scale, colour = (width, 0.0, 0.0), (0.0, 0.45, 0.70, 1.0)
        shape = Shape(group, number, shapes.LINE_STRIP, scale, colour, len(at))
        begin = len(self._fixed)
        self._fixed += zip(at, np.concatenate(places)[:, 1:].tolist(), strict=True)
        here, full = slice(begin, len(self._fixed)), self._efforts[number] or 1.0
        self.parts.append(Line(shape, here, Shade(number, full)))

    def _load(self, number: int, load: PointLoad | DistributedLoad) -> None:
        if isinstance(load, PointLoad):
            places = [load.s]
        else:
            places = np.linspace(load.start, load.end, ALONG).tolist()
        share = 1.0 if isinstance(load, PointLoad) else load.end - load.start
        ids = itertools.count(2 * ALONG * number)
        for s in places:
            at = self._spot(load.body, s)
            for vector, is_force in ((load.force, True), (load.moment, False)):
                acts = _scheduled(load, share * vector, at)
                identity = next(ids)
                if np.any(vector != 0.0):
                    self._arrow("loads", identity, at, acts, is_force)

    def _arrow(self, group: str, number: int, at: int, vector: Vector, is_force: bool) -> None:
        colour = shapes.LOAD if is_force else shapes.MOMENT
        shape = Shape(group, number, shapes.ARROW, self._head, colour, 2)
        unit = self._weight * (1.0 if is_force else self._length)
        self.parts.append(Arrow(shape, at, vector, unit, LONGEST * self._length))


def _wrench(part: slice) -> Vector:
    def now(state: State) -> Floats:
        return state.wrench[part]

    return now


def _scheduled(load: PointLoad | DistributedLoad, vector: Floats, at: int) -> Vector:
    def now(state: State) -> Floats:
        acting = load.schedule.factor(state.time) * vector
        return state.turns[at] @ acting if load.frame == "body" else acting

    return now


def semi_axes(body: RigidBody, otherwise: float) -> Floats:
    """Return the semi-axes (3,) in m of the ellipsoid with a body's mass and moments.

    A point mass is a ball with the radius ``otherwise``; what has no thickness gets a fifth of it.
    """
    square = 2.5 / body.mass * (body.inertia.sum() - 2.0 * body.inertia)
    axes = np.sqrt(np.maximum(square, 0.0))
    if not axes.any():
        return np.full(3, otherwise)
    return np.maximum(axes, 0.2 * otherwise)


def plates(simulation: Simulation) -> list[tuple[Shape, Floats]]:
    """Return the plates that hold what leaves the base, and their poses (7,); one for each place.

    What begins with a free joint is held by nothing.
    """
    scene = simulation.scene
    size = thickness(scene, simulation.length)
    base = Frames(simulation.compiled, simulation.q, [(BASE, 0.0)]).poses()
    turn = rotations(base[:, 3:])
    found: list[tuple[Shape, Floats]] = []
    for offset in _held(scene):
        shape = Shape(
            "base", len(found), shapes.CYLINDER, (5 * size, 5 * size, 0.4 * size), shapes.PLATE
        )
        axis = multiply(offset.quaternion, upright(np.array([1.0, 0.0, 0.0])))
        back = rotations(offset.quaternion[None])[0][:, 0]
        holder = Solid(shape, 0, offset.position - 0.2 * size * back, axis)
        canvas = _Blank()
        holder.draw(State(0.0, base, turn, np.zeros((0, 3)), np.zeros(0), np.zeros(6)), canvas)
        if all(np.abs(canvas.pose - pose).max() > SAME for _, pose in found):
            found.append((shape, canvas.pose))
    return found


def _held(scene: Scene) -> list[Pose]:
    """Return where bodies leave the base that do not begin with a free joint."""
    found = []
    for body in scene.bodies:
        if scene.forest.parent(body.name) is not None:
            continue
        if not isinstance(body, Joint):
            found.append(scene.attachments.get(body.name, Attachment(None)).offset)
        elif body.kind != "free":  # the first joint of all is on the base, as far off as it may be
            found.append(body.offset if body.name in scene.attachments else IDENTITY)
    return found


class _Blank:
    """A canvas for a single pose."""

    def __init__(self) -> None:
        self.pose, self.points = np.zeros(7), np.zeros((0, 3))
        self.colour, self.action = np.zeros(4, np.float32), np.zeros(1, np.int32)
