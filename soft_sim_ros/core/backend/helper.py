"""The process that compiles units for another one (together.py): orders come in by stdin."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import warnings
from contextlib import suppress
from importlib import import_module
from typing import Any

from numba.core import event

from .disk import KernelCacheWarning
from .together import DONE


class _Names(event.Listener):
    """Write the name of everything that is being compiled."""

    def __init__(self, out: Any) -> None:
        self._out = out

    def on_start(self, event: Any) -> None:
        self._out.write(event.data["dispatcher"].py_func.__name__.encode() + b"\n")

    def on_end(self, event: Any) -> None:
        pass


def main() -> None:
    """Compile units on request until the input ends."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # the parent process ends this one
    warnings.simplefilter("ignore", KernelCacheWarning)  # the parent process warns
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # keep prints of libraries out of the answers
    with event.install_listener("numba:compile", _Names(answers)):
        while True:
            try:
                module, name, types = pickle.load(sys.stdin.buffer)
            except EOFError:
                return
            getattr(import_module(module), name).compile(types)
            answers.write(DONE)


if __name__ == "__main__":
    with suppress(BrokenPipeError):  # the parent process has died
        main()
