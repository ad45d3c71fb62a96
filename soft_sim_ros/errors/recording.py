"""Errors of recordings and files."""

from __future__ import annotations

from .base import SoftSimError


class RecordingError(SoftSimError):
    """A recording cannot be read or written.

    Parameters
    ----------
    path : file or directory of the recording
    reason : why
    """

    def __init__(self, path: object, reason: str) -> None:
        super().__init__(str(path), reason)
        self.path, self.reason = str(path), reason

    def __str__(self) -> str:
        """Return the message with its numbers."""
        return f"{self.path}: {self.reason}"


class TornRecording(RecordingError):
    """A recording that was never closed: its end is missing, its beginning may be readable."""


class UnfitFile(SoftSimError):
    """A file from outside is not what can be read: of another kind, too large, or not text.

    Parameters
    ----------
    path : the file
    found, expected : what it is, and what it should be
    """

    def __init__(self, path: object, found: str, expected: str) -> None:
        super().__init__(str(path), found, expected)
        self.path, self.found, self.expected = str(path), found, expected

    def __str__(self) -> str:
        """Return the message."""
        return f"{self.path} {self.found}: expected {self.expected}"
