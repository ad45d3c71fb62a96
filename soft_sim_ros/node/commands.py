"""Commands on their way from topics to the physics, and complaints about bad ones."""

from __future__ import annotations

import re
import time
from collections.abc import Callable

from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.core.simulation.orders import MOST_NAMES, Order
from soft_sim_ros.errors import CommandError
from soft_sim_ros.foreign import bare, listed, one_line
from soft_sim_ros.recording.orders import read_order
from soft_sim_ros.recording.topics import written

# Bytes of a command that are looked at: a header, and a long name and four numbers per actuator.
_ANY, _EACH = 16_384, 1_024


class Throttle:
    """Logs a message at once, and its repetitions, counted, at most once per ``period`` s.

    Messages of one kind are repetitions of each other, whatever numbers and names are in them: a
    controller that sends a new NaN every millisecond is one complaint, and so is one that sends a
    new name; a wrong name among the NaNs is another.
    """

    _MOST = 100  # kinds within one period

    def __init__(self, say: Callable[[str], None], period: float = 1.0, now=time.monotonic):
        self._say, self._period, self._now = say, period, now
        self._due: dict[str, tuple[float, int]] = {}

    def __call__(self, text: str, kind: str | None = None) -> None:
        """Say ``text`` unless one of its kind was said a moment ago.

        Without a ``kind``, texts that differ in their numbers only are of one.
        """
        if kind is None:
            kind = re.sub(r"\d+", "0", text)
        now = self._now()
        if kind not in self._due and len(self._due) >= self._MOST:
            self._due = {k: (due, n) for k, (due, n) in self._due.items() if now < due or n}
            if len(self._due) >= self._MOST:
                kind = ""  # further kinds share one entry
        due, held_back = self._due.get(kind, (now, 0))
        if now < due:
            self._due[kind] = (due, held_back + 1)
            return
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
        Takes ``(key, order, data)``; gives False if it cannot.
    warn : callable
        Takes a text.
    lasting : bool
        Whether joint commands have no timeout while their sender is there.
    """

    def __init__(
        self,
        inputs: Inputs,
        frame_id: str,
        submit: Callable[[str, Order, bytes], bool],
        warn: Callable[[str], None],
        lasting: bool = False,
    ):
        self._lasting = lasting
        self._inputs, self._frame_id, self._submit = inputs, frame_id, submit
        self._warn = Throttle(warn)
        self._largest = _ANY + _EACH * (len(inputs.names) + len(inputs.commanded))
        self.accepted = 0
        self.refused = 0
        self.clamped = 0

    def receive(self, key: str, data: bytes) -> None:
        """Handle one message."""
        topic = written(key)
        try:
            order = self._read(key, data)
            if not self._submit(key, order, data):
                raise CommandError(topic, "too many commands wait for the next step", "many")
        except CommandError as error:
            self.refused += 1
            self._warn(f"refused {one_line(error)}", f"{topic} refused: {error.kind}")
            return
        self.accepted += 1
        if order.clamped:
            self.clamped += 1
            which = listed(order.clamped, MOST_NAMES, bare)
            self._warn(f"{topic}: outside the limits: {which}", f"{topic} cut")

    def _read(self, key: str, data: bytes) -> Order:
        """Read an order; a message that is too large is refused unread."""
        if len(data) > self._largest:
            topic = written(key)
            why = f"a message of {len(data)} bytes: at most {self._largest} are looked at"
            raise CommandError(topic, why, "size")
        return read_order(self._inputs, key, data, self._frame_id, self._lasting)
