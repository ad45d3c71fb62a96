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
WORLD, TIP = "world", "tip"
MOST_NAMES = 20  # in one complaint


@dataclass(frozen=True)
class Order:
    """A validated command, ready to be taken up at a step boundary.

    ``channels`` (k,) counts the actuators first, then the six components of the tip wrench;
    ``values`` (k,) are efforts in actuator units, moments in N·m, forces in N, already inside the
    limits. ``clamped`` says in words what had to be cut. ``frame`` is set for a wrench only. A
    ``lasting`` order has no timeout.
    """

    channels: np.ndarray
    values: np.ndarray
    clamped: tuple[str, ...] = ()
    frame: str | None = None
    lasting: bool = False


def wrench_frame(frame_id: str, base_frame_id: str) -> str:
    """Frame of a wrench message: empty or the frame of the poses = "world", "tip" = follower."""
    if frame_id == TIP:
        return TIP
    if frame_id in ("", base_frame_id):
        return WORLD
    raise CommandError(
        EXTERNAL_WRENCH,
        f"frame {shown(frame_id)}: expected {base_frame_id!r}, an empty one or {TIP!r}",
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
