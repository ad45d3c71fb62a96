"""Ctrl-C, SIGTERM and SIGHUP: what is being written is closed before the program ends.

A closed terminal and a lost ssh send SIGHUP, ``systemd`` and ``docker stop`` send SIGTERM. All
three raise an exception where the program stands, so that whatever has a file open closes it; only
what must not be torn is left to finish.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
AGAIN = 0.02  # s after which an ending that was dropped comes again
ECHO = 2.0  # s in which a further signal adds nothing: terminals and launchers send several


class Ended(KeyboardInterrupt):
    """A signal asks the program to end.

    Parameters
    ----------
    number : of the signal
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number

    def __str__(self) -> str:
        return signal.Signals(self.number).name


def _main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


@contextmanager
def endings() -> Iterator[None]:
    """Let these signals raise Ended in the block; those that are ignored (``nohup``) stay so.

    Python drops exceptions in finalisers and in callbacks of C. An Ended that is dropped there
    comes once more soon after.
    """
    first: float | None = None
    show = sys.unraisablehook

    def dropped(what: Any) -> None:
        if isinstance(what.exc_value, Ended):
            threading.Timer(AGAIN, again, (what.exc_value.number,)).start()
        else:
            show(what)

    def again(number: int) -> None:
        nonlocal first
        first = None
        os.kill(os.getpid(), number)

    def end(number: int, _: Any) -> None:
        nonlocal first
        now = time.monotonic()
        if first is None or now - first > ECHO:
            first = now
            raise Ended(number)

    before: dict[int, Any] = {}
    if _main_thread():
        for number in ENDINGS:
            handler = signal.getsignal(number)
            if handler in (signal.SIG_DFL, signal.default_int_handler):  # whose it is, keeps it
                before[number] = signal.signal(number, end)
        sys.unraisablehook = dropped
    try:
        yield
    finally:
        for which, handler in before.items():
            signal.signal(which, handler)
        sys.unraisablehook = show


@contextmanager
def undisturbed() -> Iterator[None]:
    """Let the block finish: signals that come meanwhile take effect at its end, the first of them.

    For moments in which a file is neither there nor not there. Costs a few microseconds.
    """
    came: list[int] = []
    before: dict[int, Callable[[int, Any], Any] | int] = {}
    if _main_thread():
        for number in ENDINGS:
            handler = signal.getsignal(number)
            if handler is not None and handler != signal.SIG_IGN:
                before[number] = handler
                signal.signal(number, lambda number, _: came.append(number))
    try:
        yield
    finally:
        for which, handler in before.items():
            signal.signal(which, handler)
        if came:
            handler = before[came[0]]
            if callable(handler):
                handler(came[0], None)
            else:
                os.kill(os.getpid(), came[0])
