"""Errors of scenes."""

from __future__ import annotations

from .base import SoftSimError


class SceneError(SoftSimError):
    """A scene has a key or a value that is unknown, wrong, or cannot be simulated.

    Parameters
    ----------
    file : name of the scene file
    key_path : where in the file, such as ``bodies[0].sections[1].length``; empty for the whole file
    value : what is written there; None if nothing is
    expected : what should be written there
    line : line in the file, counted from 1, if known
    """

    def __init__(
        self, file: str, key_path: str, value: object, expected: str, line: int | None = None
    ) -> None:
        super().__init__(file, key_path, value, expected, line)
        self.file, self.key_path, self.value = file, key_path, value
        self.expected, self.line = expected, line

    def __str__(self) -> str:
        """Return the message with its numbers."""
        where = self.file if self.line is None else f"{self.file}:{self.line}"
        key = self.key_path or "scene"
        what = f"{key} is missing" if self.value is None else f"{key} = {self.value}"
        return f"{where}: {what}: expected {self.expected}"
