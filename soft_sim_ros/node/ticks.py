"""What the node hears of ``/clock``: all of it to follow, or now and then to compare."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.event_handler import SubscriptionEventCallbacks
from rosgraph_msgs.msg import Clock

from soft_sim_ros.node.parameters import LOCK_STEP, OWN, Settings
from soft_sim_ros.node.quality import OVERRIDABLE, qos_profile
from soft_sim_ros.recording.axis import stamp_of
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.recording.topics import Qos

CLOCK = "/clock"
APART = 0.1  # s between a stamp and the clock that nobody can overlook
_EVERY = 5  # looks between two comparisons while nothing is wrong
_PATIENCE = 10  # looks at most for something to come
_DEPTH = 100


class Ticks:
    """Hears every tick of ``/clock``.

    In lock step none may be lost, so the subscription is reliable. A publisher that offers no
    more than best effort, such as a player of bags, is heard through a second one.

    Parameters
    ----------
    node : rclpy.node.Node
        Owner of the subscriptions.
    hear : callable
        Told each time, in ns.
    inform : callable
        Told in words.
    mode : str
        How the clock is followed.
    """

    def __init__(self, node, hear: Callable[[int], None], inform: Callable[[str], None], mode: str):
        self._node, self._hear, self._inform = node, hear, inform
        self._second = None
        reliable = Qos(_DEPTH, "reliable" if mode == LOCK_STEP else "best_effort")
        self._first = node.create_subscription(
            Clock,
            CLOCK,
            self._take,
            qos_profile(reliable),
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=self._incompatible),
            qos_overriding_options=OVERRIDABLE,
            raw=True,
        )

    def _take(self, data: bytes) -> None:
        if (time_ns := stamp_of(data)) is not None:  # bytes that are no time move nobody
            self._hear(time_ns)

    def _incompatible(self, _) -> None:
        if self._second is None:
            self._inform(f"{CLOCK} is published as best effort: ticks may be lost")
            self._second = self._node.create_subscription(
                Clock, CLOCK, self._take, qos_profile(Qos(_DEPTH, "best_effort")), raw=True
            )


class OtherClocks:
    """Compares the stamps of an arm that has its own time with the ``/clock`` of another node.

    Everybody who follows that clock would see the arm in the past or in the future. The clock is
    listened to for a moment only, when it appears and every few seconds after that: hearing all
    of it would cost more than the arm.

    Parameters
    ----------
    node : rclpy.node.Node
        Owner of the subscription.
    telemetry : Telemetry
        Knows the stamps.
    settings : Settings
        Whose time it is, and how fast it should go.
    warn : callable
        Told once, when they differ, and again when they do so after they agreed.
    """

    def __init__(self, node, telemetry: Telemetry, settings: Settings, warn: Callable[[str], None]):
        self._node, self._telemetry, self._warn = node, telemetry, warn
        self._own = 1 if settings.publish_clock else 0
        self._silent = settings.time != OWN
        self._apart = APART * max(1.0, settings.real_time_factor)
        self._subscription = None
        self._heard: list[float] = []
        self._next = self._left = 0
        self._found: str | None = None

    def look(self) -> str | None:
        """Return what is wrong, in a sentence; warn if it is new. Called once a second."""
        if self._silent:
            return None
        if self._node.count_publishers(CLOCK) <= self._own:
            self._found, self._next = None, 0
            self._stop()
        elif self._subscription is not None:
            self._left -= 1
            if self._heard or self._left <= 0:
                self._stop()
                self._next = _EVERY
                self._judge()
        elif self._next > 0:
            self._next -= 1
        else:
            self._listen()
        return self._found

    def _listen(self) -> None:
        self._heard, self._left = [], _PATIENCE
        try:
            self._subscription = self._node.create_subscription(
                Clock, CLOCK, self._compare, qos_profile(Qos(1, "best_effort")), raw=True
            )
        except RuntimeError as error:  # a policy of SROS2 may forbid it
            self._silent = True
            self._warn(f"cannot compare times with {CLOCK}: {error}")

    def _compare(self, data: bytes) -> None:
        if (time_ns := stamp_of(data)) is not None:
            self._heard.append((self._telemetry.stamp_ns - time_ns) * 1e-9)
            if not self._own and len(self._heard) == 1:  # of several, one may be its own
                self._judge()

    def _judge(self) -> None:
        apart = max(self._heard, key=abs, default=0.0)
        if abs(apart) <= self._apart:
            self._found = None
            return
        side = "behind" if apart < 0.0 else "ahead of"
        text = f"stamps are {abs(apart):.3g} s {side} another node's {CLOCK}"
        if self._found is None:
            advice = "use_sim_time:=true follows it"
            if self._own:
                advice += ", publish_clock:=false of the other leaves time to this one"
            self._warn(f"{text}: {advice}")
        self._found = text

    def _stop(self) -> None:
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None
