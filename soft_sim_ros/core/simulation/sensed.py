"""The sensors of a Simulation."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from .payload import Carrying

if TYPE_CHECKING:  # scenes without sensors need none of it
    from soft_sim_ros.core.mechanics.instant import Instant

    from .reading import Reading
    from .seen import Seen
    from .sensing import Sensing

NEVER = 2**62  # steps


class Sensed(Carrying):
    """A Simulation that is looked at by the sensors of its scene. Without any it does nothing."""

    def sensors(self) -> dict[str, Reading]:
        """Return the newest reading of every sensor, by its name, in the order of the scene.

        Between two instants at which a sensor measures that of the last one stays; with a latency
        it is there so much later. Of a sensor that has not said anything yet the numbers are NaN.
        """
        if self._sensing is None:
            return {}
        self._sense(self._sensing)
        return self._sensing.readings(self.step_index)

    def steps_to_reading(self) -> int:
        """Return how many steps on the next reading gets out of a sensor; 2⁶² without sensors."""
        if self._sensing is None:
            return NEVER
        self._sense(self._sensing)
        return self._sensing.delivers_after(self.step_index) - self.step_index

    def _until_sensed(self, sensing: Sensing) -> int:
        """Return the next step at which a sensor measures, those of the present one done."""
        self._sense(sensing)
        return sensing.next

    def _sense(self, sensing: Sensing, made: bool = True) -> None:
        """Let the sensors measure that are due: an interrupt may have kept them from it.

        made : whether the state is the end of a step
        """
        if sensing.next <= self.step_index:
            sensing.measure(self._instant(sensing, made), self.step_index)

    def _sense_anew(self) -> None:
        if self._sensing is not None:
            self._sensing.clear()
            self._sense(self._sensing, made=False)

    def _instant(self, sensing: Sensing, made: bool) -> Instant:
        ports = None
        if sensing.ported:
            self._entry.take_stock()
            ports = self._state.position, self._state.rate, self._state.acting
        return self._seen.instant(self, self._problem, made)._replace(ports=ports)

    @cached_property
    def _seen(self) -> Seen:
        from .seen import Seen

        assert self._sensing is not None
        return Seen(self.compiled, self._sensing.gauges)
