"""Ctrl-C at any moment: heeded soon, and never in the middle of a change."""

from collections.abc import Callable

SLICE = 0.02  # s that kernels take, about, before Python looks for interrupts


def next_pace(pace: int, spent: float) -> int:
    """Return how many evaluations of the residual a call may take, after one that took so many.

    spent : s that it took
    """
    if spent < 0.5 * SLICE:
        return 2 * pace
    return pace if spent <= SLICE else max(1, pace // 2)


def wholly(change: Callable[[], None]) -> None:
    """Make a change of several arrays, one that can be made twice, wholly or not at all.

    An interrupt in its middle is handed on when it is made.
    """
    try:
        change()
    except BaseException:
        change()
        raise
