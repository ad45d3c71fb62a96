"""What may be ordered of an arm: what is wrong with a command is said before it gets there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from soft_sim_ros.errors import CommandError
from soft_sim_ros.foreign import bare, listed, shown
from soft_sim_ros.scene import Scene

from .bounds import Bounds
from .orders import (
    COMMAND,
    EXTERNAL_WRENCH,
    JOINT_COMMAND,
    MOST_NAMES,
    TIP,
    WORLD,
    Order,
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
    bounds : those given
    """

    def __init__(self, scene: Scene, bounds: Bounds | None = None) -> None:
        self.names = tuple(actuator.name for actuator in scene.actuators)
        self._index = {name: i for i, name in enumerate(self.names)}
        self._known = listed(self.names, MOST_NAMES, bare)
        self.bounds = Bounds.none(scene) if bounds is None else bounds
        self._limits = self.bounds.efforts
        self._all = np.arange(len(self.names))

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

    def wrench_order(self, wrench: Sequence[float] | np.ndarray, frame: str = WORLD) -> Order:
        """Order for the tip wrench (6,), moment N·m then force N; "world" dead, "tip" follower."""
        values = numbers(EXTERNAL_WRENCH, wrench)
        if values.shape != (6,):
            raise CommandError(
                EXTERNAL_WRENCH,
                f"a wrench of shape {values.shape}: expected 3 moments and 3 forces",
                "length",
            )
        if frame not in (WORLD, TIP):
            raise CommandError(
                EXTERNAL_WRENCH, f"wrench frame {shown(frame)}: expected {WORLD!r} or {TIP!r}"
            )
        labels = ("torque.x", "torque.y", "torque.z", "force.x", "force.y", "force.z")
        require_finite(EXTERNAL_WRENCH, labels, values)
        values, clamped = self.bounds.cut(values)
        return Order(len(self.names) + np.arange(6), values, clamped, frame=frame)

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
