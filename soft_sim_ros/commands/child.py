"""A verb in a process of its own: its output line by line, its end in order."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from queue import SimpleQueue

from soft_sim_ros.errors import SoftSimError

GRACE = 30.0  # s that a process gets to end in order


class ChildFailed(SoftSimError):
    """A process of the demo did not do its part.

    Parameters
    ----------
    name : what it was to do
    code : its exit code
    said : the last it said
    """

    def __init__(self, name: str, code: int, said: str) -> None:
        super().__init__(name, code, said)
        self.name, self.code, self.said = name, code, said

    def __str__(self) -> str:
        said = f"; it said last:\n{self.said}" if self.said else ""
        return f"{self.name} ended with exit code {self.code}{said}"


class Child:
    """A Python module that runs in a process of its own.

    Parameters
    ----------
    name : description of its purpose
    module : of the module
    arguments : of its command line
    """

    def __init__(self, name: str, module: str, *arguments: str) -> None:
        self.name = name
        self.said: deque[str] = deque(maxlen=12)
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            text=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
            # Ctrl-C reaches the demo alone, which then ends its processes in order.
            start_new_session=True,
        )
        self._fresh: SimpleQueue[str | None] = SimpleQueue()
        threading.Thread(target=self._pump, name=f"output of {name}", daemon=True).start()

    def _pump(self) -> None:
        """Take everything it says at once: a full pipe would stop it."""
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._fresh.put(line.rstrip())
        self._fresh.put(None)

    def lines(self) -> Iterator[str]:
        """Yield what it says until it ends."""
        while (line := self._fresh.get()) is not None:
            self.said.append(line)
            yield line
        self._fresh.put(None)

    def wait_for(self, text: str) -> Iterator[str]:
        """Yield what it says up to the line that holds ``text``; it must not end before."""
        for line in self.lines():
            yield line
            if text in line:
                return
        raise ChildFailed(self.name, self._process.wait(), "\n".join(self.said))

    def interrupt(self) -> None:
        """Ask it to end, as Ctrl-C does."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)

    def finish(self, *codes: int) -> None:
        """Wait for its end; any other exit code than these (0 if none are given) is a failure."""
        for _ in self.lines():
            pass
        code = self._process.wait()
        if code not in (codes or (0,)):
            raise ChildFailed(self.name, code, "\n".join(self.said))

    def end(self) -> None:
        """Make sure that it is gone."""
        if self._process.poll() is None:
            self.interrupt()
            try:
                self._process.wait(GRACE)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()


@contextmanager
def child(name: str, module: str, *arguments: str) -> Iterator[Child]:
    """Start a process that is gone at the end of the block, whatever happens."""
    process = Child(name, module, *arguments)
    try:
        yield process
    finally:
        process.end()
