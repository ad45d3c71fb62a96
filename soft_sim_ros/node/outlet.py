"""The interface by which the physics thread publishes messages."""

from __future__ import annotations

from typing import Protocol

# keys in ``joined`` of those who look at views of the arm (views.py)
VIEWS = frozenset({"tf", "markers"})


class Outlet(Protocol):
    """Publishes messages that have subscribers."""

    def wanted(self, key: str) -> bool:
        """Whether this topic has subscribers."""

    def send(self, key: str, data: bytes) -> None:
        """Publish the bytes of one message."""

    def tick(self, time_ns: int) -> None:
        """Say that everything up to this simulation time has been sent."""

    def clock(self, time_ns: int) -> None:
        """Publish this simulation time on the clock."""

    def joined(self) -> dict[str, int]:
        """Count who has ever begun to listen, by key; ``tf`` and ``clock`` are keys, too."""
