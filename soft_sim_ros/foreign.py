"""Foreign text, made safe for one line of a log, an event, a diagnostic or an error.

Names in messages, parameters, files and topics come from outside of this process. Printed as they
are, a new line fakes a line of the log, an escape sequence drives the terminal, and a name of
a megabyte drowns everything else. So every such text goes through one of these functions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

LONGEST, MANY = 60, 5
LINE = 1000


def shown(value: object, longest: int = LONGEST) -> str:
    """Return ``value`` in quotes (numbers and other things as Python writes them).

    What cannot be printed is escaped; what is longer than ``longest`` characters is cut, and its
    full length is said.
    """
    if isinstance(value, str):
        return _cut(value, longest, repr)
    return _cut(repr(value), longest, one_line)


def bare(value: object, longest: int = LONGEST) -> str:
    """Return ``value`` as `shown`, but without quotes."""
    return one_line(value, longest)


def listed(
    values: Iterable[object], most: int = MANY, write: Callable[[object], str] = shown
) -> str:
    """Return the first ``most`` values, each in quotes as `shown`, and how many more there are."""
    everything = list(values)
    text = ", ".join(map(write, everything[:most]))
    left = len(everything) - most
    return f"{text} and {left} more" if left > 0 else text


def one_line(text: object, longest: int = LINE) -> str:
    """Return ``text`` without quotes, on one line of at most about ``longest`` characters.

    Printable characters stay as they are; new lines, escape sequences, marks that turn the
    direction of writing, and half of a surrogate pair become what Python writes for them.
    """
    return _cut(str(text), longest, _escape)


def printable(text: str) -> str:
    """Return ``text`` as `one_line` writes it, but whole, and with its ends of lines and tabs."""
    return _escape(text, keep="\n\t")


def _escape(text: str, keep: str = "") -> str:
    if text.isprintable():
        return text
    return "".join(c if c in keep or c.isprintable() else repr(c)[1:-1] for c in text)


def _cut(text: str, longest: int, write: Callable[[str], str]) -> str:
    if len(text) <= longest:
        return write(text)
    return f"{write(text[:longest])}… ({len(text)} characters)"
