"""Intervals of allowed numbers, with their description for error messages."""

from __future__ import annotations

import math
from dataclasses import dataclass

# Sizes of numbers of a scene lie between these, except zero and infinity, so that products such as
# fourth powers of lengths times moduli do not overflow.
LEAST, MOST = 1e-60, 1e30


@dataclass(frozen=True)
class Interval:
    """Numbers between two bounds; a bound belongs to it where its bracket is square.

    An infinite bound with a square bracket allows infinity itself.
    """

    low: float
    high: float
    low_closed: bool
    high_closed: bool

    @staticmethod
    def parse(text: str) -> Interval:
        """Make an interval from its usual notation, such as ``(-1, 0.5]``."""
        low, high = text[1:-1].split(",")
        return Interval(float(low), float(high), text[0] == "[", text[-1] == "]")

    def __contains__(self, value: float) -> bool:
        """Return whether a number is allowed."""
        above = value > self.low or (self.low_closed and value == self.low)
        below = value < self.high or (self.high_closed and value == self.high)
        return above and below

    def refuses(self, value: float) -> str | None:
        """Return None if a number is allowed, also in its size, else what is expected."""
        if math.isnan(value) or value not in self:
            return f"a {self}"
        if math.isinf(value):
            return None
        if abs(value) > MOST and not (math.isinf(self.high) and self.high_closed):
            return f"a {self}, in size at most {MOST:g}"
        if 0.0 < value < LEAST and self.low == 0.0 and not self.low_closed:
            return f"a {self}, at least {LEAST:g}"
        return None

    def __str__(self) -> str:
        """Finish the sentence "expected a …"."""
        infinite_ends = math.isinf(self.low), math.isinf(self.high)
        if infinite_ends == (True, True):
            return "number or .inf" if self.high_closed else "finite number"
        if infinite_ends == (False, True):
            return f"number {'>=' if self.low_closed else '>'} {self.low:g}"
        if infinite_ends == (True, False):
            return f"number {'<=' if self.high_closed else '<'} {self.high:g}"
        left, right = "[" if self.low_closed else "(", "]" if self.high_closed else ")"
        return f"number in {left}{self.low:g}, {self.high:g}{right}"


FINITE = Interval.parse("(-inf, inf)")
ANY = Interval.parse("[-inf, inf]")
POSITIVE = Interval.parse("(0, inf)")
NONNEGATIVE = Interval.parse("[0, inf)")
