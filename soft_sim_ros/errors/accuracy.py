"""Errors and warnings about accuracy."""

from __future__ import annotations

from .base import SoftSimError


class ToleranceMissed(SoftSimError):
    """No choice of numerics, or not the one that the scene fixes, meets its tolerance.

    Parameters
    ----------
    file : of the scene
    tolerance, estimate : of the tip's error, over the arm's length
    finest : description of the choice that meets it for the longest time
    holds : simulated time in s up to which it does
    """

    def __init__(
        self, file: str, tolerance: float, estimate: float, finest: str, holds: float = 0.0
    ) -> None:
        super().__init__(file, tolerance, estimate, finest, holds)
        self.file, self.tolerance, self.estimate, self.finest = file, tolerance, estimate, finest
        self.holds = holds

    def __str__(self) -> str:
        """Return the message with its numbers."""
        until = f"it holds up to t = {self.holds:.4g} s" if self.holds > 0.0 else "at no time"
        return (
            f"{self.file}: numerics.tolerance = {self.tolerance:g} is not met: the estimate is "
            f"{self.estimate:.2g} with {self.finest}; {until}"
        )


class SearchSpent(ToleranceMissed):
    """The search for numerics that meet a tolerance reached its limit first.

    Parameters
    ----------
    file, tolerance, estimate, finest, holds : as for ToleranceMissed, of what was tried so far
    limit : of the work of all runs of the search (core/accuracy/search.py)
    """

    def __init__(
        self,
        file: str,
        tolerance: float,
        estimate: float,
        finest: str,
        holds: float,
        limit: float,
    ) -> None:
        super().__init__(file, tolerance, estimate, finest, holds)
        self.args = (file, tolerance, estimate, finest, holds, limit)
        self.limit = limit

    def __str__(self) -> str:
        """Return the message with its numbers."""
        return f"{super().__str__()}; the search ended at its limit of work, {self.limit:.2g}"


class NotResolved(UserWarning):
    """A result is further from the continuous arm than it should be: the basis is too coarse.

    Parameters
    ----------
    scene : its name
    error : estimate of the tip's error in space over the length; infinite where none can be given
    limit : beyond which a warning is given
    """

    def __init__(self, scene: str, error: float, limit: float) -> None:
        super().__init__(scene, error, limit)
        self.scene, self.error, self.limit = scene, error, limit

    def __str__(self) -> str:
        """Return the message with its numbers and a remedy."""
        size = f"{self.error:.2g} of the length"
        if self.error == float("inf"):
            size = "any amount (a finer basis finds no equilibrium nearby)"
        return (
            f"{self.scene}: basis and nodes do not show this state: the tip may be off by {size}, "
            f"more than {self.limit:g}; write a higher numerics.basis.order or more elements"
        )
