"""Which steps are instants of a run, and when a simulated instant is due in the real world."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

MAX_LAG_NS = 200_000_000  # more than this is given up instead of caught up
SLOWEST, FASTEST = 1e-3, 1e3  # factors, simulated seconds per second, besides 0
_PIECE_NS = 20_000_000


@dataclass(frozen=True)
class Grid:
    """Step counts between the instants of a run, from its rates (Hz) and step (ns)."""

    publish: int
    control: int
    clock: int = 0  # 0: with every state

    @classmethod
    def of(
        cls, step_ns: int, publish_rate: float, control_rate: float, clock_rate: float = 0.0
    ) -> Grid:
        """Nearest whole numbers of steps, at least one; control rate 0 = every step."""
        step = step_ns * 1e-9
        control = 1.0 if control_rate == 0.0 else 1.0 / (control_rate * step)
        clock = max(1, round(1.0 / (clock_rate * step))) if clock_rate else 0
        return cls(max(1, round(1.0 / (publish_rate * step))), max(1, round(control)), clock)

    def steps_from(self, index: int) -> int:
        """Count the steps from step ``index`` to the next instant of any kind."""
        kinds = (self.publish, self.control, self.clock or self.publish)
        return min(kind - index % kind for kind in kinds)


class Pacer:
    """Holds the simulation to ``factor`` simulated seconds per second.

    At every real instant one simulated time is due. It moves on at the factor, and nothing but
    real time moves it: a wait that is cut short leaves its instant early, and the next wait goes on
    from there. So the simulation is never ahead of its factor, whatever happens in between.

    A step that comes late is caught up by not waiting for the next ones. A lag beyond `MAX_LAG_NS`
    is given up: the deadlines start anew from now, so an arm that is too expensive for its factor
    runs slower, evenly, and never owes more than that.

    Parameters
    ----------
    factor : float
        0 (never wait), or from `SLOWEST` to `FASTEST`.
    now_ns : callable
        Real time in ns.
    """

    def __init__(self, factor: float, now_ns=time.monotonic_ns):
        self._now_ns = now_ns
        self._factor = factor
        self._origin: tuple[int, int] | None = None  # (real, simulated) ns: both now due
        self._early = 0  # simulated ns by which the present instant is early, while not running
        self._waiting_for: int | None = None
        self._lock = threading.Lock()  # the factor changes in another thread
        self.overruns = 0
        self.lost_ns = 0

    @property
    def factor(self) -> float:
        """Simulated seconds per second; 0 = no waiting at all."""
        return self._factor

    @factor.setter
    def factor(self, value: float) -> None:
        with self._lock:
            if self._origin is not None:
                now = self._now_ns()
                self._origin = (now, self._due(now)) if value > 0.0 else None
            self._factor = value

    def restart(self, time_ns: int) -> None:
        """Forget that the simulated ``time_ns`` is late, but not that it is early."""
        with self._lock:
            if self._origin is not None:
                self._early = max(0, time_ns - self._due(self._now_ns()))
            self._origin = None

    def begin(self) -> None:
        """Forget everything: the next instant is due at once, whatever its time."""
        with self._lock:
            self._origin, self._early = None, 0

    def wait(self, time_ns: int, interrupted: Callable[[], bool]) -> bool:
        """Sleep until the simulated ``time_ns`` is due; count it if it is late.

        Returns
        -------
        bool
            False if ``interrupted()`` came first: the instant is not yet due, call again.
        """
        again, self._waiting_for = self._waiting_for == time_ns, time_ns
        first = True
        while (left := self._left(time_ns, count=first and not again)) > 0:
            if not first and interrupted():
                return False
            first = False
            # Pieces, so that a slow factor does not delay the end or a change of the factor.
            time.sleep(min(left, _PIECE_NS) * 1e-9)
        self._waiting_for = None
        return True

    def _due(self, now: int) -> int:
        """Return the simulated time that is due at the real time ``now``."""
        assert self._origin is not None
        real, simulated = self._origin
        return simulated + round((now - real) * self._factor)

    def _left(self, time_ns: int, count: bool) -> float:
        """Return the real ns until ``time_ns`` is due; none or less if it is due or late."""
        with self._lock:
            if self._factor <= 0.0:
                self._early = 0
                return 0.0
            now = self._now_ns()
            if self._origin is None:
                self._origin, self._early = (now, time_ns - self._early), 0
                count = False
            real, simulated = self._origin
            # Not by way of `_due`: rounded to simulated ns, a slow factor would lose real time.
            left = (time_ns - simulated) / self._factor - (now - real)
            if left < 0.0 and count:
                self.overruns += 1
            if -left > MAX_LAG_NS:
                self.lost_ns += round(-left)
                self._origin = (now, time_ns)
            return left
