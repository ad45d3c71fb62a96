"""An arm on somebody else's time: it goes where ``/clock`` has been, and never further."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from soft_sim_ros.node.commands import Throttle
from soft_sim_ros.node.states import BEAT

STILL_NS = 2_000_000_000  # real time without a new tick after which the clock stands still
LEAP_NS = 60_000_000_000  # a tick further ahead than this is a jump, and not to be caught up
LATE_NS = 1_000_000_000  # so far behind the clock an arm says that it is too slow
_GAP_NS = 200_000_000  # what a pause may cost before the stamps leap over it
_PIECE = 0.02  # s: requests are answered at least as often
_NEVER = float("inf")


class Follower:
    """Paces a simulation by the ticks of a clock that another program publishes.

    ``lock_step``: whatever the clock has reached is due at once. ``resampled``: what lies between
    two ticks is spread over the real time between them, so that a slow or jerky clock moves the
    arm evenly, one tick behind. In neither of them a stamp is ever ahead of the clock.

    Stamps are simulated time plus an offset. The offset is a whole number of ``period_ns``, so
    arms that follow one clock at one rate have the same stamps, whenever they joined. When the
    clock jumps, the arm goes on from where it is, with another offset.

    Parameters
    ----------
    period_ns : int
        Time between two states, ns.
    resampled : bool
        Whether to spread what lies between ticks.
    moved : callable
        Told the new offset in ns, by the thread that waits.
    inform, warn : callable
        Told in words.
    now_ns : callable
        Real time in ns.
    """

    factor = 1.0
    overruns = lost_ns = 0  # nothing has a deadline, nothing is given up

    def __init__(
        self,
        period_ns: int,
        resampled: bool,
        moved: Callable[[int], None],
        inform: Callable[[str], None],
        warn: Callable[[str], None],
        now_ns: Callable[[], int] = time.monotonic_ns,
    ):
        self._period, self._resampled, self._moved = period_ns, resampled, moved
        self._inform, self._warn, self._now = inform, Throttle(warn), now_ns
        self._lock, self._tick = threading.Lock(), threading.Event()
        self._last: int | None = None  # newest time of the clock
        self._heard = self._now()  # real time at which it came
        self._from, self._span = 0, 0  # resampled: shown when it came; real time until it is shown
        self._why = ""  # why a new offset is needed; empty: it is not
        self._still = self._late = False  # whether that has been said
        self._at = 0  # simulated time of the present state
        self.offset_ns: int | None = None

    @property
    def behind_ns(self) -> int:
        """By how much the present state is behind the clock, ns."""
        last, offset = self._last, self.offset_ns
        return 0 if last is None or offset is None else max(0, last - offset - self._at)

    def doubt(self) -> str | None:
        """Say what is wrong between the arm and the clock now."""
        if self._last is None:
            return "waiting for the first /clock" if self._still else None
        if self._still:
            return f"/clock stands still at {self._last * 1e-9:.9g} s"
        late = self.behind_ns > LATE_NS
        said = f"{self.behind_ns * 1e-9:.3g} s behind /clock: it is faster than the arm"
        if late and not self._late:
            self._warn(said)
        self._late = late
        return said if late else None

    # In the thread of the messages.

    def hear(self, time_ns: int) -> None:
        """Take note of a tick."""
        with self._lock:
            now, last = self._now(), self._last
            if last == time_ns:
                return
            if last is None:
                self._why = f"joined /clock at {time_ns * 1e-9:.9g} s"
            elif time_ns < last or time_ns - last > LEAP_NS:
                way = "back" if time_ns < last else "forward"
                self._why = f"/clock jumped {way} from {last * 1e-9:.9g} to {time_ns * 1e-9:.9g} s"
                last = None
            shown = time_ns if last is None else self._shown(now)
            if last is None or now - self._heard > STILL_NS:
                shown = time_ns
            self._from, self._span = shown, now - self._heard
            self._last, self._heard = time_ns, now
            goes_on, self._still = self._still, False
        if goes_on:
            self._inform(f"/clock goes on at {time_ns * 1e-9:.9g} s")
        self._tick.set()

    def _shown(self, now: int) -> int:
        """Return the time of the clock that is due at the real time ``now``."""
        assert self._last is not None
        if not self._resampled or now - self._heard >= self._span:
            return self._last
        return self._from + (self._last - self._from) * (now - self._heard) // self._span

    # In the thread of the simulation.

    def wait(self, time_ns: int, interrupted: Callable[[], bool]) -> bool:
        """Wait until the clock has come to the simulated ``time_ns``.

        Returns
        -------
        bool
            False if ``interrupted()`` came first, or another offset, or nothing for a while:
            call again.
        """
        end = time.monotonic() + BEAT
        while True:
            self._tick.clear()
            if self._rejoin():
                return False
            left = self._left(time_ns)
            if left <= 0.0:
                self._at = time_ns
                return True
            if interrupted() or time.monotonic() > end:
                self._look()
                return False
            self._tick.wait(min(left * 1e-9, _PIECE))

    def join(self, time_ns: int, interrupted: Callable[[], bool]) -> bool:
        """Wait for the first tick, as `wait` does, with the state of ``time_ns`` at hand."""
        self._at = time_ns
        end = time.monotonic() + BEAT
        while self._rejoin() or self._left(time_ns) > 0.0:
            if interrupted() or time.monotonic() > end:
                self._look()
                return False
            self._tick.wait(_PIECE)
            self._tick.clear()
        return True

    def restart(self, time_ns: int) -> None:
        """Go on after a pause: the stamps leap over what has passed meanwhile."""
        self._at = time_ns
        with self._lock:
            if self.behind_ns > max(_GAP_NS, self._period) and not self._why:
                self._why = f"{self.behind_ns * 1e-9:.3g} s of /clock have passed meanwhile"

    def _left(self, time_ns: int) -> float:
        """Return the real ns until ``time_ns`` is due, as far as the clock says."""
        with self._lock:
            if self._last is None or self.offset_ns is None:
                return _NEVER
            due, now = time_ns + self.offset_ns, self._now()
            if due <= self._shown(now):
                return 0.0
            if due > self._last:
                return _NEVER
            share = (due - self._from) / (self._last - self._from)
            return max(1.0, share * self._span - (now - self._heard))

    def _rejoin(self) -> bool:
        """Find a new offset where one is needed; False where none is."""
        with self._lock:
            if self._last is None or not self._why:
                return False
            why, self._why = self._why, ""
            periods = -((self._at - self._last) // self._period)  # rounded up
            first = self.offset_ns is None
            self.offset_ns = periods * self._period
        self._moved(self.offset_ns)
        stamps = f"the arm's stamps go on at {(self._at + self.offset_ns) * 1e-9:.9g} s"
        if "jumped" in why:
            self._warn(f"{why}: {stamps}, its state stays; ~/reset gives the initial one", why[:18])
        else:
            self._inform(f"{why}: {stamps}" if not first else why)
        return True

    def _look(self) -> None:
        """Say once that the clock stands still, and now and then that the arm is too slow."""
        with self._lock:
            if self._still or self._now() - self._heard <= STILL_NS:
                return
            self._still, last = True, self._last
        if last is None:
            self._warn(
                "use_sim_time is true, so the arm waits for /clock, which nobody publishes; "
                "publish_clock:=true makes it the owner of time"
            )
        else:
            self._warn(f"/clock stands still at {last * 1e-9:.9g} s, and so does the arm")
