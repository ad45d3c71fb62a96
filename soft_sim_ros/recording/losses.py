"""How many messages a recording lacks, by topic."""

from __future__ import annotations

from collections.abc import Mapping, Sequence


class Losses:
    """Counts messages that will never be on disk.

    Those dropped before they reached the queue are counted by one thread, those lost after it by
    another: neither count has two writers.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._dropped = [0] * len(self._names)
        self._lost = [0] * len(self._names)

    def drop(self, index: int) -> None:
        """Count a message of a topic that found no room."""
        self._dropped[index] += 1

    def lose(self, counts: Mapping[str, int]) -> None:
        """Count messages, by the names of their topics, that the disk did not keep."""
        for index, name in enumerate(self._names):
            self._lost[index] += counts.get(name, 0)

    @property
    def total(self) -> int:
        """Number of all of them."""
        return sum(self._dropped) + sum(self._lost)

    @property
    def by_topic(self) -> dict[str, int]:
        """Their numbers by the name of the topic; topics without losses are left out."""
        rows = zip(self._names, self._dropped, self._lost, strict=True)
        return {name: dropped + lost for name, dropped, lost in rows if dropped + lost}
