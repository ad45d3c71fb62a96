"""From the bytes of a command message to an order, as the node and a re-simulation take it."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.core.simulation.orders import JOINT_COMMAND, MOST_NAMES, Order, wrench_frame
from soft_sim_ros.errors import CommandError
from soft_sim_ros.foreign import bare, listed
from soft_sim_ros.recording.decode import DecodeError, FloatArray, JointState, Wrench, decode
from soft_sim_ros.recording.topics import INPUTS

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
        ``command``, ``joint_command`` or ``external_wrench``.
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
    topic, message_type, _ = INPUTS[key]
    try:
        message = decode(message_type, data)
    except DecodeError as error:
        raise CommandError(topic, str(error), "bytes") from error
    if isinstance(message, FloatArray):
        return inputs.effort_order(message.data)
    if isinstance(message, JointState):
        return joint_message_order(inputs, message, lasting)
    assert isinstance(message, Wrench)
    return inputs.wrench_order(message.wrench, wrench_frame(message.frame_id, frame_id))


def joint_message_order(inputs: Inputs, message: JointState, lasting: bool) -> Order:
    """Return the order of a joint command.

    A joint takes its ``effort``; NaN there, or no efforts at all, is no command for it: it is as if
    it were not named. A tendon with ``control: length`` that has no effort takes its ``position``,
    in m pulled in. All arrays are empty or as long as ``name``.

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
