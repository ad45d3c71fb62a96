"""What every program with a node does first: arguments, ROS, the node; or one line that says no."""

from __future__ import annotations

import argparse
import itertools
import os
import re
import stat
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import rclpy
from rclpy.exceptions import NameValidationException, ParameterException
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from soft_sim_ros.errors import SoftSimError
from soft_sim_ros.foreign import one_line, shown

PARAMETERS = "--params-file"
_LAST_DOMAIN = 232
_LARGEST = 1_000_000  # bytes of a parameter file
# What rclpy raises where ROS refuses a name, a value or a quality of service.
_REFUSALS = (RuntimeError, ValueError, TypeError, ParameterException, NameValidationException)
_PLACE = re.compile(r",? at /\S+:\d+|\n")  # where in the sources of rcl
_SAID = re.compile(r"^\[(?:WARN|ERROR)\] \[[\d.]+\] \[rcl\w*\]: (.*)$", re.MULTILINE)
_HIDDEN = re.compile(r"This error state is being overwritten:\s+'([^\n]*)'")


class StartError(SoftSimError):
    """ROS cannot make sense of its arguments, or cannot start."""


class Parser(argparse.ArgumentParser):
    """A parser that says what is wrong on one line, as everything else here does."""

    def error(self, message: str):
        """Raise instead of printing the usage as well."""
        raise StartError(f"{one_line(message)} (-h shows what there is)")


def start(parser: argparse.ArgumentParser, args: list[str]) -> argparse.Namespace:
    """Parse the arguments that are not for ROS, and initialise rclpy with the others.

    Signal handlers are left to the caller.
    """
    _check_domain()
    for file in parameter_files(args):
        _check_file(file)
    with asking_ros("cannot start"):
        options = parser.parse_args(remove_ros_args([parser.prog, *args])[1:])
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    return options


def parameter_files(args: Sequence[str]) -> list[str]:
    """Return the files of parameters that a command line names."""
    return [file for flag, file in itertools.pairwise(args) if flag == PARAMETERS]


def _check_domain() -> None:
    """Refuse a domain that DDS has no ports for: it would end the process by itself."""
    domain = os.environ.get("ROS_DOMAIN_ID", "").strip() or "0"
    if not (domain.isascii() and domain.isdigit() and int(domain[:9]) <= _LAST_DOMAIN):
        why = f"expected a whole number from 0 to {_LAST_DOMAIN}"
        raise StartError(f"cannot start: ROS_DOMAIN_ID = {shown(domain)}: {why}")


def _check_file(file: str) -> None:
    """Refuse what is no file, and what is far too large to be one of parameters."""
    what = f"cannot start: {PARAMETERS} {shown(file, 200)}"
    try:
        found = os.stat(file)
    except (OSError, ValueError) as error:
        raise StartError(f"{what}: {getattr(error, 'strerror', None) or error}") from error
    if not stat.S_ISREG(found.st_mode):
        raise StartError(f"{what} is not a regular file")
    if found.st_size > _LARGEST:
        raise StartError(f"{what} has {found.st_size} bytes, allowed are {_LARGEST}")


@contextmanager
def asking_ros(what: str) -> Iterator[None]:
    """Turn a refusal of ROS into a StartError of one line, which begins with ``what``.

    The libraries below Python print parts of their reasons straight to the standard error of the
    process. They go into the error, or follow when all is well.
    """
    sys.stderr.flush()
    terminal = os.dup(2)
    with tempfile.TemporaryFile() as caught:
        os.dup2(caught.fileno(), 2)
        failed = True
        try:
            yield
            failed = False
        except _REFUSALS as error:
            sys.stderr.flush()
            raise StartError(f"{what}: {_reason(error, _read(caught))}") from error
        finally:
            sys.stderr.flush()
            os.dup2(terminal, 2)
            os.close(terminal)
            if not failed and (text := _read(caught)):
                sys.stderr.write(text)
                sys.stderr.flush()


def _read(file) -> str:
    file.seek(0)
    return file.read().decode("utf-8", "replace")


def _reason(error: Exception, printed: str) -> str:
    """Put together what rclpy and what the libraries below it say."""
    text = str(error)
    if type(error).__name__ == "UnknownROSArgsError":
        text = f"unknown ROS arguments {text}"
    why = [*_SAID.findall(printed), *_HIDDEN.findall(printed)]
    words = dict.fromkeys(_PLACE.sub("", part).strip() for part in (text, *why))
    return one_line("; ".join(filter(None, words)))
