"""What is wrong with the state of a simulation."""

from __future__ import annotations

from .base import SoftSimError


class StateError(SoftSimError):
    """A state, from a file or from elsewhere, holds something that no state can.

    Parameters
    ----------
    where : the file, or what it was to be restored in
    key : which part of the state
    found : what is there
    expected : what should be there
    """

    def __init__(self, where: object, key: str, found: str, expected: str) -> None:
        super().__init__(str(where), key, found, expected)
        self.where, self.key, self.found, self.expected = str(where), key, found, expected

    def __str__(self) -> str:
        """Put it in a sentence."""
        return f"{self.where}: {self.key} is {self.found}: expected {self.expected}"


class OtherModel(SoftSimError):
    """A state belongs to another model than the simulation that should take it.

    Parameters
    ----------
    scene : name of the simulation's scene
    other : name of the scene that the state belongs to
    difference : in what the two differ
    """

    def __init__(self, scene: str, other: str, difference: str) -> None:
        super().__init__(scene, other, difference)
        self.scene, self.other, self.difference = scene, other, difference

    def __str__(self) -> str:
        """Put it in a sentence."""
        return (
            f"a state of {self.other!r} does not fit the model of {self.scene!r}: {self.difference}"
        )
