"""What the physics thread needs of whoever publishes its messages."""

from __future__ import annotations

from typing import Protocol

# keys in ``joined`` of those who look at views of the arm (views.py)
VIEWS = frozenset({"tf", "markers"})


class Outlet(Protocol):
    """Where messages go while somebody listens."""

    def wanted(self, key: str) -> bool:
        """Whether anybody listens to this topic."""

    def send(self, key: str, data: bytes) -> None:
        """Publish the bytes of one message."""

    def tick(self, time_ns: int) -> None:
        """Say that everything up to this simulation time has been sent."""

    def clock(self, time_ns: int) -> None:
        """Move everybody's clock to this simulation time."""

    def joined(self) -> dict[str, int]:
        """Count who has ever begun to listen, by key; ``tf`` and ``clock`` are keys, too."""
