"""From the bytes of a command message to an order, as the node and a re-simulation take it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.core.simulation.orders import (
    BODY,
    JOINT_COMMAND,
    MOST_NAMES,
    Order,
    wrench_frame,
)
from soft_sim_ros.errors import CommandError
from soft_sim_ros.foreign import bare, listed, shown
from soft_sim_ros.recording.decode import (
    DecodeError,
    FloatArray,
    JointState,
    Odometry,
    Poses,
    Wrench,
    decode,
)
from soft_sim_ros.recording.topics import COMMANDS

ATTACHED, DROPPED = "attached: ", "dropped: "  # events, with the name of a payload
HELD, RELEASED = "held: ", "released: "  # events, with the name of a constraint
SENDER_LEFT = f"sender_left: {JOINT_COMMAND}"  # the event at which timeouts start


def read_order(
    inputs: Inputs, key: str, data: bytes, frame_id: str, lasting: bool = False
) -> Order:
    """Decode and check one command message.

    Parameters
    ----------
    inputs : Inputs
        Knows the actuators.
    key : str
        Of a topic, such as ``command``, ``external_wrench`` or ``drive/base``.
    data : bytes
        The message as received.
    frame_id : str
        Frame of the poses, in which a wrench is dead.
    lasting : bool
        Whether joint commands have no timeout while their sender is there.

    Raises
    ------
    CommandError
        If the message cannot be carried out, with what is wrong with it.
    """
    kind, _, of = key.partition("/")
    topic, message_type, _ = COMMANDS[kind]
    topic = f"{topic}/{of}" if of else topic
    try:
        message = decode(message_type, data)
    except DecodeError as error:
        raise CommandError(topic, str(error), "bytes") from error
    if isinstance(message, FloatArray):
        return inputs.effort_order(message.data)
    if isinstance(message, JointState):
        return joint_message_order(inputs, message, lasting)
    if isinstance(message, Wrench) and not of:
        return inputs.wrench_order(message.wrench, wrench_frame(message.frame_id, frame_id))
    if isinstance(message, Wrench):
        frame = message.frame_id and wrench_frame(message.frame_id, frame_id, BODY, topic=topic)
        return inputs.wrench_order(message.wrench, frame or None, of)
    assert isinstance(message, Poses | Odometry)
    if message.frame_id not in ("", frame_id):
        why = f"frame {shown(message.frame_id)}: expected {frame_id!r} or an empty one"
        raise CommandError(topic, why, "frame")
    if isinstance(message, Odometry):
        return inputs.pose_order(of, message.pose, message.twist)
    return inputs.pose_order(of, message.poses[0])


def joint_message_order(inputs: Inputs, message: JointState, lasting: bool) -> Order:
    """Return the order of a joint command.

    A joint takes its ``effort``; NaN there, or no efforts at all, is no command for it: it is as if
    it were not named. A tendon with ``control: length`` that has no effort takes its ``position``,
    in m pulled in. A driven coordinate that follows commands takes ``position`` and ``velocity``.
    All arrays are empty or as long as ``name``.

    Parameters
    ----------
    inputs : Inputs
        Knows the actuators.
    message : JointState
        What was sent.
    lasting : bool
        Whether the order has no timeout.

    Raises
    ------
    CommandError
        If the message cannot be carried out.
    """
    drives = [i for i, name in enumerate(message.name) if name in inputs.commanded]
    if drives and len(set(message.name)) == len(message.name):
        return _with_drives(inputs, message, lasting, drives)
    names, values = message.name, np.array(message.effort, dtype=float)
    if not names or (len(values) not in (0, len(names))):
        return inputs.joint_order(names, values)  # raises the CommandError
    channels = inputs.channels(names)
    if not len(values):
        if not (len(message.position) or len(message.velocity)):
            return inputs.joint_order(names, values)
        values = np.full(len(names), np.nan)
    if len(message.position):
        _take_positions(inputs, message, channels, values)
    given = ~np.isnan(values)
    if not given.any():
        return Order(channels[given], values[given], lasting=lasting)
    chosen = [name for name, here in zip(names, given, strict=True) if here]
    order = inputs.joint_order(chosen, values[given])
    return Order(order.channels, order.values, order.clamped, lasting=lasting)


def _with_drives(inputs: Inputs, message: JointState, lasting: bool, drives: list[int]) -> Order:
    """Return the order of a joint command, some of whose names are driven coordinates."""
    count = len(message.name)
    for what in ("position", "velocity", "effort"):
        if len(getattr(message, what)) not in (0, count):
            why = f"{len(getattr(message, what))} of {what} for {count} names"
            raise CommandError(JOINT_COMMAND, why, "length")
    named = [message.name[i] for i in drives]
    if len(message.effort) and not np.isnan(message.effort[drives]).all():
        why = f"efforts for {listed(named)}: expected a position or a velocity"
        raise CommandError(JOINT_COMMAND, why, "effort")
    rest = [i for i in range(count) if i not in set(drives)]
    motions = (message.position, message.velocity)
    goals = inputs.drive_order(named, *(part[drives] if len(part) else None for part in motions))
    others = None
    if rest:
        parts = (message.position, message.velocity, message.effort)
        own = [part[rest] if len(part) else part for part in parts]
        names = tuple(message.name[i] for i in rest)
        others = JointState(message.stamp_ns, message.frame_id, names, *own)
    if others is None or not any(len(part) for part in (others.position, others.effort)):
        return replace(goals, lasting=lasting)
    order = joint_message_order(inputs, others, lasting)
    return Order(
        np.concatenate([order.channels, goals.channels]),
        np.concatenate([order.values, goals.values]),
        order.clamped + goals.clamped,
        lasting=lasting,
        goals=goals.goals,
    )


def _take_positions(
    inputs: Inputs, message: JointState, channels: np.ndarray, values: np.ndarray
) -> None:
    """Put the positions of winches into ``values`` (n,) where there is no effort."""
    names, positions = message.name, message.position
    if len(positions) != len(names):
        why = f"{len(positions)} positions for {len(names)} names"
        raise CommandError(JOINT_COMMAND, why, "length")
    asked = np.isnan(values) & ~np.isnan(positions)
    actuators = inputs.simulation.scene.actuators
    winch = np.array([getattr(actuators[i], "control", "") == "length" for i in channels])
    if len(message.effort) == 0 and (wrong := asked & ~winch).any():
        which = listed((names[i] for i in np.flatnonzero(wrong)), MOST_NAMES, bare)
        why = f"positions for {which}: expected efforts; only tendons by length take positions"
        raise CommandError(JOINT_COMMAND, why, "position")
    values[asked & winch] = positions[asked & winch]
