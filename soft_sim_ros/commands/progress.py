"""Progress lines."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

REFRESH = 0.2  # s between updates of a line on a terminal
PERIOD = 5.0  # s between lines anywhere else, such as the log of a build machine


class Line:
    """One line that is rewritten on a terminal, and repeated now and then elsewhere.

    Parameters
    ----------
    stream : where it goes; standard error unless told
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._live = self._stream.isatty()
        self._due = time.monotonic() + (0.0 if self._live else PERIOD)
        self._shown = ""

    def show(self, text: str) -> None:
        """Show ``text`` if it is time to."""
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + (REFRESH if self._live else PERIOD)
        self._write("\r" + text.ljust(len(self._shown)) if self._live else text + "\n")
        self._shown = text

    def clear(self) -> None:
        """Take the line off a terminal, so that the next print starts at its left edge."""
        if self._live and self._shown:
            self._write("\r" + " " * len(self._shown) + "\r")
            self._shown = ""

    def _write(self, text: str) -> None:
        """Write, unless the terminal is gone; the work goes on without it."""
        try:
            self._stream.write(text)
            self._stream.flush()
        except OSError:
            self._due = float("inf")


@contextmanager
def compiling(stream: TextIO | None = None) -> Iterator[None]:
    """Show which kernels are being compiled: it happens once per machine and version."""
    from soft_sim_ros.core.backend.compilation import compilations

    line = Line(stream)
    start = time.monotonic()

    def begins(name: str) -> None:
        seconds = time.monotonic() - start
        line.show(f"compiling kernels, once: {len(seen.names)} so far, {seconds:.0f} s ({name})")

    with compilations(begins) as seen:
        try:
            yield
        finally:
            line.clear()
    if seen.names:
        seconds = time.monotonic() - start
        print(f"compiled {len(seen.names)} kernels in {seconds:.1f} s", file=stream or sys.stderr)


def bar(done: int, total: int, width: int = 20) -> str:
    """Return a bar of text."""
    full = width * done // max(total, 1)
    return f"[{'#' * full}{'.' * (width - full)}]"
