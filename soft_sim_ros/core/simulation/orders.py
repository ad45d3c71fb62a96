"""Validated commands (orders), and the errors of invalid ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from soft_sim_ros.core.arguments import real
from soft_sim_ros.errors import BadArgument, CommandError
from soft_sim_ros.foreign import bare, listed, shown

COMMAND, JOINT_COMMAND, EXTERNAL_WRENCH = "~/command", "~/joint_command", "~/external_wrench"
WORLD, TIP, BODY = "world", "tip", "body"
DRIVE = "~/drive"
MOST_NAMES = 20  # in one complaint


@dataclass(frozen=True)
class Order:
    """A validated command, ready to be taken up at a step boundary.

    ``channels`` (k,) counts the actuators first, then the six components of the tip wrench and of
    every wrench at a place of its own, then the driven coordinates that follow commands;
    ``values`` (k,) are efforts in actuator units, moments in N·m, forces in N, already inside the
    limits, and for driven coordinates whether they will go on moving, 1 or 0. ``clamped`` says in
    words what had to be cut. ``frame`` is set for a wrench only, ``which`` of them it is: 0, that
    at the tip. A ``lasting`` order has no timeout. ``goals`` say where driven coordinates are to
    go, ``pose`` where a free joint is.
    """

    channels: np.ndarray
    values: np.ndarray
    clamped: tuple[str, ...] = ()
    frame: str | None = None
    lasting: bool = False
    which: int = 0
    goals: tuple[Goal, ...] = ()
    pose: PoseGoal | None = None


@dataclass(frozen=True)
class Goal:
    """Where a driven coordinate is to go: position in rad or m, and rate; None: not said."""

    name: str
    position: float | None
    velocity: float | None


@dataclass(frozen=True, eq=False)
class PoseGoal:
    """Where a free joint is to go: pose (7,) and twist (6,), which is along its own axes."""

    joint: str
    pose: np.ndarray
    twist: np.ndarray | None


def wrench_frame(
    frame_id: str, base_frame_id: str, own: str = TIP, plain: str = WORLD, topic: str = ""
) -> str:
    """Return along which axes the wrench of a message is: "world", or ``own`` = a follower.

    An empty frame is ``plain``, the frame of the poses is the world.
    """
    if frame_id == "":
        return plain
    if frame_id == own:
        return own
    if frame_id == base_frame_id:
        return WORLD
    raise CommandError(
        topic or EXTERNAL_WRENCH,
        f"frame {shown(frame_id)}: expected {base_frame_id!r}, an empty one or {own!r}",
        "frame",
    )


def require_finite(topic: str, labels: Sequence[str], values: np.ndarray) -> None:
    """Refuse values (n,) with NaN or infinity among them, by their labels."""
    if not np.isfinite(values).all():
        wrong = np.flatnonzero(~np.isfinite(values)).tolist()
        which = listed((f"{labels[i]} = {values[i]}" for i in wrong), MOST_NAMES, bare)
        raise CommandError(topic, "not finite: " + which, "finite")


def numbers(topic: str, values: Any) -> np.ndarray:
    """Return the numbers of a command as an array of its own."""
    try:
        return real("values", values).copy()
    except BadArgument as error:
        raise CommandError(topic, str(error)) from None
