"""How every verb ends: an exit code, and at most one line that says why."""

from __future__ import annotations

import functools
import os
import signal
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol, TextIO

from soft_sim_ros.endings import Ended, endings
from soft_sim_ros.errors import SoftSimError, SolverError
from soft_sim_ros.foreign import printable

DONE, FAILED, BAD_INPUT = 0, 1, 2
SIGNALLED = 128  # and the number of the signal, as shells have it


class Main(Protocol):
    """The main function of a verb: command line → exit code."""

    def __call__(self, argv: Sequence[str] | None = None) -> int: ...


def verb(main: Main) -> Main:
    """Let ``main`` end with an exit code and one line, whatever the user's files and disks do.

    0 = done, 1 = the run failed, 2 = the input is bad; 130 = interrupted (Ctrl-C), 143 = SIGTERM,
    129 = SIGHUP (the terminal was closed). Only what is a bug of this package still ends in a
    traceback.
    """

    @functools.wraps(main)
    def wrapped(argv: Sequence[str] | None = None) -> int:
        try:
            with endings(), warnings.catch_warnings():
                warnings.showwarning = _show_warning
                return main(argv)
        except KeyboardInterrupt as ending:
            number = ending.number if isinstance(ending, Ended) else signal.SIGINT
            told = "interrupted" if number == signal.SIGINT else f"ended by {ending}"
            return _end(told, SIGNALLED + number)
        except SolverError as error:
            return _end(f"error: {error}", FAILED)
        except SoftSimError as error:
            return _end(f"error: {error}", BAD_INPUT)
        except BrokenPipeError:
            # The reader of a pipe has left; nothing more can be said, not even at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return FAILED
        except OSError as error:
            where = f"{error.filename}: " if error.filename else ""
            return _end(f"error: {where}{error.strerror or error}", BAD_INPUT)

    return wrapped


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Show a warning as one line for users, without its place in the code."""
    with suppress(OSError):  # the terminal may be gone
        print(f"warning: {printable(str(message))}", file=sys.stderr, flush=True)


def require_ros(name: str) -> None:
    """End with a sentence, not with a traceback, where there is no ROS."""
    try:
        import rclpy  # noqa: F401
    except ImportError as error:
        raise NoRos(name, str(error)) from error


class NoRos(SoftSimError):
    """A verb needs ROS, which is not installed.

    Parameters
    ----------
    name : the verb
    reason : what Python said
    """

    def __init__(self, name: str, reason: str) -> None:
        super().__init__(name, reason)
        self.name, self.reason = name, reason

    def __str__(self) -> str:
        return (
            f"{self.name} needs ROS 2 Jazzy, but its Python client cannot be imported "
            f"({self.reason}): source a Jazzy, or use the environment that make builds"
        )


def _end(line: str, code: int) -> int:
    # A progress line may still stand without its end.
    with suppress(OSError):  # and the terminal may be gone
        print(("\n" if sys.stderr.isatty() else "") + printable(line), file=sys.stderr, flush=True)
    return code
