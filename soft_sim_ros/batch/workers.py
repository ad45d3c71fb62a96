"""A pool of processes that works through a list of tasks, even if some of them die."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from typing import Any

GRACE = 30.0  # s that a process gets to close its recording
# One process per core, so libraries must not start threads of their own.
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


class WorkerDied(Exception):
    """The process of a task ended without an answer: killed, out of memory, crashed."""


def cores() -> int:
    """Return the number of cores this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def in_processes(
    function: Callable[..., Any], tasks: Iterable[tuple], jobs: int
) -> Iterator[tuple[int, Any]]:
    """Call ``function(*task)`` in ``jobs`` processes; yield (number of the task, answer).

    In the order in which they end. An answer is what was returned, the exception that was raised,
    or WorkerDied. When the iterator is closed early, running tasks get a KeyboardInterrupt and
    GRACE seconds.

    Parameters
    ----------
    function : importable in a fresh process
    """
    waiting = iter(enumerate(tasks))
    busy: dict[Connection, tuple[multiprocessing.process.BaseProcess, int]] = {}
    idle: list[tuple[Connection, multiprocessing.process.BaseProcess]] = []
    try:
        while True:
            while len(busy) < jobs and (task := next(waiting, None)) is not None:
                connection, process = idle.pop() if idle else _start(function)
                busy[connection] = process, task[0]
                with suppress(OSError):  # a dead process is noticed below, by its pipe
                    connection.send(task[1])
            if not busy:
                return
            for ready in wait(list(busy)):
                assert isinstance(ready, Connection)
                process, number = busy.pop(ready)
                try:
                    answer = ready.recv()
                except (EOFError, OSError):
                    ready.close()
                    process.join()
                    yield number, WorkerDied(f"its process ended with exit code {process.exitcode}")
                    continue
                idle.append((ready, process))
                yield number, answer
    finally:
        _stop([process for process, _ in busy.values()], [*busy, *(c for c, _ in idle)])


def _start(
    function: Callable[..., Any],
) -> tuple[Connection, multiprocessing.process.BaseProcess]:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(function, theirs), daemon=True)
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update({k: v for k, v in ONE_THREAD.items() if before[k] is None})
    try:
        process.start()
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
    theirs.close()  # so that the pipe ends when the process does
    return ours, process


def _stop(
    running: list[multiprocessing.process.BaseProcess], connections: list[Connection]
) -> None:
    for process in running:
        process.terminate()
    for process in running:
        process.join(GRACE)
        if process.is_alive():
            process.kill()
    for connection in connections:
        connection.close()  # idle ones end at the end of the pipe


def _work(function: Callable[..., Any], connection: Connection) -> None:
    """Answer tasks until the pipe ends."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # they reach the parent, which tells us
    signal.signal(signal.SIGTERM, _interrupt)
    threading.Thread(target=_watch_parent, daemon=True).start()
    try:
        while True:
            task = connection.recv()
            try:
                answer = function(*task)
            except Exception as error:
                answer = error
            connection.send(answer)
    except (EOFError, BrokenPipeError, KeyboardInterrupt):
        pass  # the parent has what it wanted, or is gone


def _watch_parent() -> None:
    """Interrupt the task when the parent dies, then end the process."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    wait([parent.sentinel])
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(GRACE)  # in this process: compiled code may be stuck in the other thread
    os._exit(1)


def _interrupt(*_: object) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # once: the recording is being closed
    raise KeyboardInterrupt
