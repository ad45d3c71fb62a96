"""Which steps are instants of a run, and when a simulated instant is due in the real world."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

MAX_LAG_NS = 200_000_000  # more than this is given up instead of caught up


@dataclass(frozen=True)
class Grid:
    """Step counts between the instants of a run, from its rates (Hz) and step (ns)."""

    publish: int
    control: int

    @classmethod
    def of(cls, step_ns: int, publish_rate: float, control_rate: float) -> Grid:
        """Nearest whole numbers of steps, at least one; control rate 0 = every step."""
        step = step_ns * 1e-9
        control = 1.0 if control_rate == 0.0 else 1.0 / (control_rate * step)
        return cls(max(1, round(1.0 / (publish_rate * step))), max(1, round(control)))

    def steps_from(self, index: int) -> int:
        """Count the steps from step ``index`` to the next instant of either kind."""
        return min(self.publish - index % self.publish, self.control - index % self.control)


class Pacer:
    """Holds the simulation to ``factor`` simulated seconds per second.

    A step that comes late is caught up by not waiting for the next ones. A lag beyond `MAX_LAG_NS`
    is given up: the deadlines start anew from now, so an arm that is too expensive for its factor
    runs slower, evenly, and never owes more than that.
    """

    def __init__(self, factor: float, now_ns=time.monotonic_ns):
        self._now_ns = now_ns
        self._factor = factor
        self._origin: tuple[int, int] | None = None  # (real, simulated) ns
        self.overruns = 0
        self.lost_ns = 0

    @property
    def factor(self) -> float:
        """Simulated seconds per second; 0 = no waiting at all."""
        return self._factor

    @factor.setter
    def factor(self, value: float) -> None:
        self._factor = value
        self._origin = None

    def restart(self) -> None:
        """Forget the deadlines; the next instant is due now."""
        self._origin = None

    def wait(self, time_ns: int, hurry: Callable[[], bool]) -> None:
        """Sleep until the simulated ``time_ns`` is due, or until ``hurry()``; count it if late."""
        factor = self._factor
        if factor <= 0.0:
            return
        now = self._now_ns()
        if self._origin is None:
            self._origin = (now, time_ns)
            return
        deadline = self._origin[0] + round((time_ns - self._origin[1]) / factor)
        if now > deadline:
            self.overruns += 1
            if now - deadline > MAX_LAG_NS:
                self.lost_ns += now - deadline
                self._origin = (now, time_ns)
            return
        while (left := deadline - self._now_ns()) > 0:
            # Pieces, so that a slow factor does not delay the end or a change of the factor.
            time.sleep(min(left, 20_000_000) * 1e-9)
            if left > 20_000_000 and (hurry() or self._factor != factor):
                return
