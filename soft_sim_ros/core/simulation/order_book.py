"""What may be ordered of an arm: what is wrong with a command is said before it gets there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from soft_sim_ros.errors import CommandError
from soft_sim_ros.foreign import bare, listed, shown
from soft_sim_ros.scene import Scene
from soft_sim_ros.scene.joint import LABELS

from .bounds import Bounds
from .orders import (
    BODY,
    COMMAND,
    DRIVE,
    EXTERNAL_WRENCH,
    JOINT_COMMAND,
    MOST_NAMES,
    TIP,
    WORLD,
    Goal,
    Order,
    PoseGoal,
    numbers,
    require_finite,
)


class OrderBook:
    """Makes orders of commands to the actuators and the tip of a scene.

    Parameters
    ----------
    scene : Scene
        its actuators give names and limits
    bounds : Bounds or None
        To what a wrench, and efforts without limits, are cut; None = to nothing.

    Attributes
    ----------
    names : of the actuators, in scene order
    wrenches : names of what wrenches may be given to: the tip, and the input loads
    commanded : driven coordinates that follow commands
    bounds : those given
    """

    def __init__(self, scene: Scene, bounds: Bounds | None = None) -> None:
        self.names = tuple(actuator.name for actuator in scene.actuators)
        self._index = {name: i for i, name in enumerate(self.names)}
        self._loads = scene.input_loads
        self.bounds = Bounds.none(scene) if bounds is None else bounds
        self._limits = self.bounds.efforts
        self._all = np.arange(len(self.names))
        self.wrenches = (TIP, *(load.name for load in scene.input_loads))
        self.commanded = tuple(scene.commanded)
        self._first_drive = len(self.names) + 6 * len(self.wrenches)
        known = (*self.names, *self.commanded)
        self._known = listed(known, MOST_NAMES, bare)
        self._poses = {
            joint: tuple(f"{joint}/{label}" for label in LABELS["free"]) for joint in scene.posed
        }

    def effort_order(self, efforts: Sequence[float] | np.ndarray) -> Order:
        """Order for all actuators, ``efforts`` (n_actuators,) in scene order."""
        values = numbers(COMMAND, efforts)
        if values.shape != (len(self.names),):
            raise CommandError(
                COMMAND,
                f"{values.size} efforts for {len(self.names)} actuators ({self._known})",
                "length",
            )
        return self._bounded(COMMAND, self._all, values)

    def joint_order(self, names: Sequence[str], efforts: Sequence[float] | np.ndarray) -> Order:
        """Order for some actuators by name, ``efforts`` (len(names),)."""
        if not names:
            raise CommandError(JOINT_COMMAND, f"no names: expected some of {self._known}", "length")
        if len(names) != len(efforts):
            given = listed(names, write=bare)
            raise CommandError(
                JOINT_COMMAND, f"{len(efforts)} efforts for {len(names)} names ({given})", "length"
            )
        channels = self.channels(names)
        values = numbers(JOINT_COMMAND, efforts)
        if values.shape != channels.shape:
            raise CommandError(
                JOINT_COMMAND, f"efforts of shape {values.shape}: expected a list", "length"
            )
        return self._bounded(JOINT_COMMAND, channels, values)

    def channels(self, names: Sequence[str]) -> np.ndarray:
        """Return the channels (len(names),) of actuators by name."""
        if driven := [name for name in names if name in self.commanded]:
            why = f"efforts for {listed(driven)}: expected a position or a velocity"
            raise CommandError(JOINT_COMMAND, why, "effort")
        unknown = [name for name in names if name not in self._index]
        if unknown:
            raise CommandError(
                JOINT_COMMAND,
                f"unknown actuator {listed(unknown)}: expected some of {self._known}",
                "name",
            )
        if len(set(names)) < len(names):
            counts = Counter(names)
            twice = listed((name for name in sorted(counts) if counts[name] > 1), write=bare)
            raise CommandError(JOINT_COMMAND, f"actuator named more than once: {twice}", "twice")
        return np.array([self._index[name] for name in names], dtype=np.intp)

    def wrench_order(
        self, wrench: Sequence[float] | np.ndarray, frame: str | None = WORLD, of: str = TIP
    ) -> Order:
        """Order for a wrench (6,), moment N·m then force N.

        frame : "world" dead, "tip" (of input loads "body") follower; None: as the scene says
        of : which of ``wrenches``
        """
        topic = EXTERNAL_WRENCH if of == TIP else f"{EXTERNAL_WRENCH}/{of}"
        if of not in self.wrenches:
            known = listed(self.wrenches, MOST_NAMES, bare)
            raise CommandError(topic, f"no such wrench: expected one of {known}", "name")
        which = self.wrenches.index(of)
        load = self._loads[which - 1] if which else None
        values = numbers(topic, wrench)
        if values.shape != (6,):
            why = f"a wrench of shape {values.shape}: expected 3 moments and 3 forces"
            raise CommandError(topic, why, "length")
        own, plain = (TIP, WORLD) if load is None else (BODY, load.frame)
        frame = plain if frame is None else frame
        if frame not in (WORLD, own):
            why = f"wrench frame {shown(frame)}: expected {WORLD!r} or {own!r}"
            raise CommandError(topic, why)
        labels = ("torque.x", "torque.y", "torque.z", "force.x", "force.y", "force.z")
        require_finite(topic, labels, values)
        bounds = self.bounds if load is None else self.bounds.within(load.moment, load.force)
        values, clamped = bounds.cut(values)
        channels = len(self.names) + 6 * which + np.arange(6)
        return Order(channels, values, clamped, frame=frame, which=which)

    def drive_order(
        self,
        names: Sequence[str],
        positions: Sequence[float] | np.ndarray | None = None,
        velocities: Sequence[float] | np.ndarray | None = None,
    ) -> Order:
        """Order for driven coordinates by name: positions in rad or m, rates, or both.

        NaN is no command; of one that gets none nothing changes.
        """
        rows = np.full((2, len(names)), np.nan)
        for row, given, what in zip(
            rows, (positions, velocities), ("positions", "velocities"), strict=True
        ):
            if given is None or not len(given):
                continue
            values = numbers(JOINT_COMMAND, given)
            if values.shape != row.shape:
                why = f"{values.size} {what} for {len(names)} names"
                raise CommandError(JOINT_COMMAND, why, "length")
            row[:] = values
        goals, clamped = [], []
        for i, name in enumerate(names):
            if name not in self.commanded:
                known = listed(self.commanded, MOST_NAMES, bare)
                why = f"{shown(name)} follows no commands: expected some of {known}"
                raise CommandError(JOINT_COMMAND, why, "name")
            if np.isnan(rows[:, i]).all():
                continue
            if np.isinf(rows[:, i]).any():
                why = f"not finite: {name} = {rows[:, i].tolist()}"
                raise CommandError(JOINT_COMMAND, why, "finite")
            most = self.bounds.drives[self.commanded.index(name)]
            cut = np.minimum(np.maximum(rows[:, i], -most), most)
            said = [x for x, y in zip(rows[:, i], cut, strict=True) if x < y or x > y]
            clamped += [f"{name} = {x:g} cut" for x in said]
            position, velocity = (None if np.isnan(x) else float(x) for x in cut)
            goals.append(Goal(name, position, velocity))
        channels = [self._first_drive + self.commanded.index(goal.name) for goal in goals]
        moving = [1.0 if goal.velocity else 0.0 for goal in goals]
        return Order(
            np.array(channels, dtype=np.intp), np.array(moving), tuple(clamped), goals=tuple(goals)
        )

    def pose_order(
        self,
        joint: str,
        pose: Sequence[float] | np.ndarray,
        twist: Sequence[float] | np.ndarray | None = None,
    ) -> Order:
        """Order for a free joint at the base: pose (7,) of what it carries in the world.

        twist : (6,) angular and linear velocity along its own axes, rad/s and m/s; None: it will
            rest
        """
        topic = f"{DRIVE}/{joint}"
        if joint not in self._poses:
            known = listed(tuple(self._poses), MOST_NAMES, bare)
            raise CommandError(topic, f"follows no poses: expected one of {known}", "name")
        place = numbers(topic, pose)
        rates = None if twist is None else numbers(topic, twist)
        if place.shape != (7,) or (rates is not None and rates.shape != (6,)):
            raise CommandError(topic, "expected x y z qx qy qz qw, and 6 rates", "length")
        require_finite(topic, ("x", "y", "z", "qx", "qy", "qz", "qw"), place)
        if rates is not None:
            require_finite(topic, ("wx", "wy", "wz", "vx", "vy", "vz"), rates)
        size = float(np.linalg.norm(place[3:]))
        if not abs(size - 1.0) < 1e-2:
            raise CommandError(topic, f"a quaternion of length {size:g}: expected 1", "quaternion")
        place[3:] /= size
        first = self._first_drive + self.commanded.index(f"{joint}/rx")
        most = self.bounds.drives[self.commanded.index(f"{joint}/x")]
        cut = np.minimum(np.maximum(place[:3], -most), most)
        clamped = (f"{topic}: position cut to {most:g} m",) if (cut != place[:3]).any() else ()
        place[:3] = cut
        goal = PoseGoal(joint, place, rates)
        moving = np.full(6, 0.0 if rates is None or not rates.any() else 1.0)
        return Order(first + np.arange(6), moving, clamped, pose=goal)

    def _bounded(self, topic: str, channels: np.ndarray, values: np.ndarray) -> Order:
        lo, hi = self._limits[channels].T
        cut = np.minimum(np.maximum(values, lo), hi)
        if (cut == values).all() and not np.isinf(values).any():
            return Order(channels, values)
        names = [self.names[i] for i in channels]
        require_finite(topic, names, values)
        clamped = tuple(
            f"{names[i]} = {values[i]:g} cut to {cut[i]:g}" for i in np.flatnonzero(cut != values)
        )
        return Order(channels, cut, clamped)
