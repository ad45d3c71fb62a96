"""Where the stamps of a recorded run differ from its own time: the event that says so.

An arm that follows ``/clock`` begins at 0 like every other, and its log times are simulation
time. Its stamps are those of the clock: simulation time plus an offset, which begins to hold with
an event in the recording.
"""

from __future__ import annotations

import re

OFFSET = "time_offset: "
_LARGEST = 2**62  # ns


def offset_event(offset_ns: int) -> str:
    """Return the text of the event that a new offset begins with."""
    return f"{OFFSET}{offset_ns} ns"


def offset_of(text: str) -> int | None:
    """Return the offset in ns that an event speaks of, None if it is another one.

    Raises
    ------
    ValueError
        if it is meant to be one and no number is in it
    """
    if not text.startswith(OFFSET):
        return None
    found = re.fullmatch(r"(-?[0-9]{1,20}) ns", text.removeprefix(OFFSET))
    if found is None or abs(int(found[1])) > _LARGEST:
        raise ValueError(f"expected a whole number of ns, up to {_LARGEST}")
    return int(found[1])
