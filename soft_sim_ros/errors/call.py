"""Errors of calls and commands."""

from __future__ import annotations

from .base import SoftSimError


class BadArgument(SoftSimError, ValueError):
    """A function of the package got an invalid argument.

    Parameters
    ----------
    name : of the argument
    value : what was given
    expected : what should be given
    """

    LONGEST = 400  # characters of the value in the message

    def __init__(self, name: str, value: object, expected: str) -> None:
        super().__init__(name, value, expected)
        self.name, self.value, self.expected = name, value, expected

    def __str__(self) -> str:
        """Return the message."""
        try:
            given = repr(self.value)
        except ValueError:  # a whole number of more digits than Python prints
            given = f"one of type {type(self.value).__name__}"
        if len(given) > self.LONGEST:
            given = given[: self.LONGEST] + " …"
        return f"{self.name} must be {self.expected}, not {given}"


class NotCopied(SoftSimError, TypeError):
    """An object that cannot be copied or pickled, or a pickle that does not fit this version.

    Parameters
    ----------
    what : the object
    why : why not, and what can be copied instead
    """

    def __init__(self, what: str, why: str) -> None:
        super().__init__(what, why)
        self.what, self.why = what, why

    def __str__(self) -> str:
        """Return the message."""
        return f"{self.what} cannot be copied or pickled: {self.why}"


class CommandError(SoftSimError):
    """A command that came in from outside is refused.

    Parameters
    ----------
    topic : where it came from
    why : what is wrong with it
    kind : the same word for all that is wrong in the same way; complaints are counted by it
    """

    def __init__(self, topic: str, why: str, kind: str = "") -> None:
        super().__init__(topic, why, kind)
        self.topic, self.why, self.kind = topic, why, kind

    def __str__(self) -> str:
        """Return the message with its numbers."""
        return f"{self.topic}: {self.why}"


class NoSuchPlace(SoftSimError):
    """A rod, a strain or an arc length that the arm does not have.

    Parameters
    ----------
    asked : what was asked for
    expected : what there is
    """

    def __init__(self, asked: object, expected: str) -> None:
        super().__init__(asked, expected)
        self.asked, self.expected = asked, expected

    def __str__(self) -> str:
        """Return the message."""
        return f"{self.asked!r}: expected {self.expected}"


class MissingExtra(SoftSimError):
    """Something optional is asked for, and the package it needs is not installed.

    Parameters
    ----------
    what : what was asked for
    package : name of the missing package
    extra : name of our extra that brings it
    """

    def __init__(self, what: str, package: str, extra: str) -> None:
        super().__init__(what, package, extra)
        self.what, self.package, self.extra = what, package, extra

    def __str__(self) -> str:
        """Say how to get it."""
        return (
            f"{self.what} needs {self.package}, which is not installed: "
            f"pip install 'soft_sim_ros[{self.extra}]', or apt install python3-{self.package}"
        )


class DeriveError(SoftSimError):
    """Equations cannot be derived from what is asked for.

    Parameters
    ----------
    key : the option
    value : what it says
    expected : what it should say
    """

    def __init__(self, key: str, value: object, expected: str) -> None:
        super().__init__(key, value, expected)
        self.key, self.value, self.expected = key, value, expected

    def __str__(self) -> str:
        """Return the message."""
        return f"{self.key} = {self.value!r}: expected {self.expected}"
