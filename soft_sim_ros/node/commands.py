"""From the bytes of a command message to an order, and what is said about bad ones."""

from __future__ import annotations

import re
import time
from collections.abc import Callable

from soft_sim_ros.core.inputs import Inputs, Order, wrench_frame
from soft_sim_ros.errors import CommandError
from soft_sim_ros.recording.decode import DecodeError, FloatArray, JointState, Wrench, decode
from soft_sim_ros.recording.topics import INPUTS


def read_order(inputs: Inputs, key: str, data: bytes, frame_id: str) -> Order:
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

    Raises
    ------
    CommandError
        If the message cannot be carried out, with what is wrong with it.
    """
    topic, message_type, _ = INPUTS[key]
    try:
        message = decode(message_type, data)
    except DecodeError as error:
        raise CommandError(topic, str(error)) from error
    if isinstance(message, FloatArray):
        return inputs.effort_order(message.data)
    if isinstance(message, JointState):
        return inputs.joint_order(message.name, message.effort)
    assert isinstance(message, Wrench)
    return inputs.wrench_order(message.wrench, wrench_frame(message.frame_id, frame_id))


class Throttle:
    """Says a thing at once, and its repetitions, counted, at most once per ``period`` s.

    Texts that differ in their numbers only are repetitions of each other: a controller that sends a
    new NaN every millisecond is one complaint, a wrong name among them is another.
    """

    _MOST = 100

    def __init__(self, say: Callable[[str], None], period: float = 1.0, now=time.monotonic):
        self._say, self._period, self._now = say, period, now
        self._due: dict[str, tuple[float, int]] = {}

    def __call__(self, text: str) -> None:
        """Say ``text`` unless something like it was said a moment ago."""
        kind = re.sub(r"\d+", "0", text)
        now = self._now()
        due, held_back = self._due.get(kind, (now, 0))
        if now < due:
            self._due[kind] = (due, held_back + 1)
            return
        if len(self._due) >= self._MOST:
            self._due.clear()
        self._due[kind] = (now + self._period, 0)
        self._say(f"{text} ({held_back} more like it)" if held_back else text)


class Gate:
    """Lets good commands through to the physics, and says what is wrong with the others.

    Parameters
    ----------
    inputs : Inputs
        Checks the commands; only what never changes is used here, so any thread may.
    frame_id : str
        Frame of the poses.
    submit : callable
        Takes ``(key, order, data)``.
    warn : callable
        Takes a text.
    """

    def __init__(
        self,
        inputs: Inputs,
        frame_id: str,
        submit: Callable[[str, Order, bytes], None],
        warn: Callable[[str], None],
    ):
        self._inputs, self._frame_id, self._submit = inputs, frame_id, submit
        self._warn = Throttle(warn)
        self.accepted = 0
        self.refused = 0
        self.clamped = 0

    def receive(self, key: str, data: bytes) -> None:
        """Handle one message."""
        try:
            order = read_order(self._inputs, key, data, self._frame_id)
        except CommandError as error:
            self.refused += 1
            self._warn(f"refused {error}")
            return
        self.accepted += 1
        if order.clamped:
            self.clamped += 1
            self._warn(f"{INPUTS[key][0]}: outside the limits: {', '.join(order.clamped)}")
        self._submit(key, order, data)
