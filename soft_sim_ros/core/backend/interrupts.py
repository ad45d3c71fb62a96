"""Handling of Ctrl-C: soon, but never in the middle of a change of state."""

from collections.abc import Callable

SLICE = 0.02  # s of computing, about, between two checks for interrupts


def next_pace(pace: int, spent: float) -> int:
    """Return how many evaluations of the residual the next call may take.

    spent : s that the last call took
    """
    if spent < 0.5 * SLICE:
        return 2 * pace
    return pace if spent <= SLICE else max(1, pace // 2)


def wholly(change: Callable[[], None]) -> None:
    """Change several arrays completely or not at all; the change must be repeatable.

    An interrupt during the change is raised after it.
    """
    try:
        change()
    except BaseException:
        change()
        raise
