"""Compile units in several processes at once, which shortens the first start on a machine.

One process can compile only one function at a time. So others are started, which get units to
compile by their names and types, and leave the code in the common folder, where ``jit.address``
and numba find it.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
import warnings
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from .disk import _FOLDER
from .jit import Call, signature_of

Job = tuple[Any, tuple[Any, ...]]  # a unit, types of its arguments
# Every process compiles what units share again, so more processes would cost more than they save.
MOST = 4
DONE = b"done\n"
# Called, in any thread, with the name of a kernel that another process begins to compile.
listeners: list[Callable[[str], None]] = []


def compile_together(calls: list[Call]) -> None:
    """Have all units that will be called compiled or on disk.

    If a process cannot be started or dies, its part is compiled here when it is called.
    """
    jobs = dict.fromkeys((call[0], signature_of(call[1:])) for call in calls if call)
    queue = deque((unit, types) for unit, types in jobs if not _known(unit, types))
    team: list[_Helper] = []
    ctrl_c = _CtrlC()
    try:
        for _ in range(min(len(os.sched_getaffinity(0)), MOST, len(queue)) - 1):
            try:
                team.append(_Helper(queue))
            except OSError as failure:
                warnings.warn(f"no other process compiles kernels: {failure}", stacklevel=2)
                break
        while queue:
            try:
                unit, types = queue.popleft()
            except IndexError:  # a helper was faster
                break
            unit.compile(types)
            ctrl_c.heed()
        for helper in team:
            helper.thread.join()
    finally:
        ctrl_c.leave()
        for helper in team:
            helper.stop()


class _CtrlC:
    """Keeps exceptions of signals (Ctrl-C): Python drops those raised in a compiler's callback."""

    def __init__(self) -> None:
        self._raised: BaseException | None = None
        self._before: dict[int, Callable[[int, Any], Any]] = {}
        if threading.current_thread() is not threading.main_thread():
            return
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            handler = signal.getsignal(number)
            if callable(handler):
                self._before[number] = handler
                signal.signal(number, self._note)

    def _note(self, number: int, frame: Any) -> None:
        try:
            self._before[number](number, frame)
        except BaseException as raised:
            self._raised = raised
            raise

    def heed(self) -> None:
        """Raise the exception that was kept, if any."""
        if self._raised is not None:
            raise self._raised

    def leave(self) -> None:
        """Restore the signal handlers."""
        for number, handler in self._before.items():
            signal.signal(number, handler)


def _known(unit: Any, types: tuple[Any, ...]) -> bool:
    """Return whether a unit needs no compilation."""
    return types in unit.overloads or unit._cache.holds(types, unit.targetctx)


class _Helper:
    """Another process, and the thread that hands it one job after the other."""

    def __init__(self, queue: deque[Job]) -> None:
        self._queue = queue
        paths = os.pathsep.join(path for path in sys.path if path)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "soft_sim_ros.core.backend.helper"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=Path(__file__).parents[3],  # not where files might be named like modules
            env=os.environ | {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(_FOLDER.parent)},
        )
        self.thread = threading.Thread(target=self._feed, daemon=True)
        self.thread.start()

    def _feed(self) -> None:
        """Hand over jobs until there are none."""
        order, answer = self._process.stdin, self._process.stdout
        assert order is not None and answer is not None
        try:
            while self._queue:
                unit, types = self._queue.popleft()
                pickle.dump((unit.__module__, unit.__name__, types), order)
                order.flush()
                for line in iter(answer.readline, DONE):
                    if not line:
                        raise BrokenPipeError
                    for listener in listeners:
                        listener(line.decode().strip())
        except IndexError:  # another one was faster
            pass
        except (OSError, ValueError):
            if not self._stopped:
                warnings.warn("a process that compiles kernels ended early", stacklevel=2)

    _stopped = False

    def stop(self) -> None:
        """End the process, also in the middle of a job."""
        self._stopped = True
        self._process.kill()
        self._process.wait()
        self.thread.join()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(BrokenPipeError):  # a job sent after the process died
                    pipe.close()
