"""Ctrl-C, SIGTERM, SIGHUP: the first ends the node in order, others do not disturb the ending."""

from __future__ import annotations

import signal
from collections.abc import Callable

from soft_sim_ros.endings import ENDINGS


class Stopped(Exception):
    """A signal came before there was anything to end in order."""


class Signals:
    """Handlers of SIGINT, SIGTERM and SIGHUP for the time of a ``with`` block.

    A closed terminal or a lost ssh sends SIGHUP. ``nohup`` has it ignored, which stays so.

    Before `hold` or `when_stopped` is called a signal raises `Stopped`, wherever the main thread
    is: the compilation of kernels need not be waited for. After it, the first signal calls the
    given function and sets ``received``; every further one is ignored. ``ros2 launch`` and a
    terminal together send two.
    """

    def __init__(self) -> None:
        self.received: str | None = None
        self._action: Callable[[], None] | None = None
        self._before: dict[int, object] = {}

    def when_stopped(self, action: Callable[[], None]) -> None:
        """Call ``action`` at the first signal instead of raising."""
        self._action = action
        if self.received:
            action()

    def hold(self) -> None:
        """Only take note of a signal, until `when_stopped` says what to do."""
        self._action = lambda: None

    def __enter__(self) -> Signals:
        for number in ENDINGS:
            if number == signal.SIGHUP and signal.getsignal(number) == signal.SIG_IGN:
                continue
            self._before[number] = signal.signal(number, self._handle)
        return self

    def __exit__(self, *_) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]

    def _handle(self, number: int, _) -> None:
        if self.received:
            return
        self.received = signal.Signals(number).name
        if self._action is None:
            raise Stopped(self.received)
        self._action()
