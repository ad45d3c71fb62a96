"""Reports on kernels being compiled, which happens once per machine and version."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

from .together import listeners


class Compilations:
    """What has been compiled since this began.

    Attributes
    ----------
    names : kernels whose compilation has begun, in this process or in one that helps it
    active : how many are being compiled in this process now
    """

    def __init__(self) -> None:
        self.names: list[str] = []
        self.active = 0
        self._told = 0

    def going_on(self) -> bool:
        """Whether something is being compiled, or has begun since this was asked last."""
        count, before = len(self.names), self._told
        self._told = count
        return self.active > 0 or count > before


class _Listener(event.Listener):
    def __init__(self, seen: Compilations, begins: Callable[[str], None]) -> None:
        self._seen, self._begins = seen, begins

    def on_start(self, event: Any) -> None:
        self._seen.active += 1
        self._begins(event.data["dispatcher"].py_func.__name__)

    def on_end(self, event: Any) -> None:
        self._seen.active -= 1


@contextmanager
def compilations(begins: Callable[[str], None] = lambda name: None) -> Iterator[Compilations]:
    """Watch what is compiled in the block; ``begins`` is told the name of every kernel at once."""
    seen = Compilations()

    def note(name: str) -> None:
        seen.names.append(name)
        begins(name)

    listeners.append(note)
    with event.install_listener("numba:compile", _Listener(seen, note)):
        try:
            yield seen
        finally:
            listeners.remove(note)
