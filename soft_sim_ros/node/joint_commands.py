"""Whether a sender of joint commands is there: ros2_control hardware that talks by topics."""

from __future__ import annotations

from collections.abc import Callable


class Senders:
    """Knows whether a sender of joint commands is there, and tells when the last one has left.

    Parameters
    ----------
    left : callable
        Called when no sender is left that could renew a command.
    """

    def __init__(self, left: Callable[[], None]):
        self._left, self._count = left, 0

    def changed(self, matched) -> None:
        """Take note of the number of publishers that match the subscription."""
        self._count = matched.current_count
        self.after_order()

    def after_order(self) -> None:
        """Say so again if a command arrived when its sender was gone already."""
        if not self._count:
            self._left()
