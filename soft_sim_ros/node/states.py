"""Sends the states of a run: on their grid, at once when asked, and again for who comes late."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection

from soft_sim_ros.node.clock import Grid
from soft_sim_ros.node.outlet import VIEWS, Outlet

BEAT = 0.25  # s between two looks for who is new while nothing moves
TIMES = 4  # so often they are sent the state: finding each other takes DDS a moment


class States:
    """Sends and records the states of a simulation.

    Parameters
    ----------
    simulation : Simulation
        The arm.
    telemetry : Telemetry
        Builds the bytes of every outgoing message.
    outlet : Outlet
        Publishes bytes.
    log : BagWriter or None
        Records bytes.
    grid : Grid
        When to send.
    again : callable
        Sends on other topics, of these keys, what was sent last.
    """

    def __init__(
        self,
        simulation,
        telemetry,
        outlet: Outlet,
        log,
        grid: Grid,
        again: Callable[[Collection[str]], None] = lambda keys: None,
    ):
        self._again = again
        self._simulation, self._outlet, self._log, self._grid = simulation, outlet, log, grid
        self._telemetry = telemetry
        self._builders = list(telemetry.builders.items())
        self._sent = self._ticked = -1  # index of the step whose state, or time, was sent last
        self._known: dict[str, int] = {}
        self._owed: dict[str, int] = {}
        self._next_look = 0.0

    @property
    def up_to_date(self) -> bool:
        """Whether the present state was sent."""
        return self._simulation.step_index == self._sent

    @property
    def due(self) -> bool:
        """Whether the present state is on the grid and was not sent yet."""
        on_grid = self._simulation.step_index % self._grid.publish == 0
        return on_grid and not self.up_to_date

    def send(self) -> None:
        """Send and record the present state: build nothing that nobody wants."""
        index, time_ns = self._simulation.step_index, self._simulation.time_ns
        self._sent = index
        self._known, self._owed = self._outlet.joined(), {}  # whoever is there hears this one
        for key, build in self._builders:
            wanted = self._outlet.wanted(key)
            if wanted or self._log is not None:
                data = build()
                if wanted:
                    self._outlet.send(key, data)
                if self._log is not None:
                    self._log.write(key, time_ns, data)
        self._outlet.tick(self._telemetry.stamp_ns)
        clock = self._grid.clock
        if not clock or index % clock == 0 or index % self._grid.publish:
            self._ticked = index
            self._outlet.clock(self._telemetry.stamp_ns)

    def tick(self) -> None:
        """Send the time alone where the clock has a grid of its own."""
        index, clock = self._simulation.step_index, self._grid.clock
        if clock and index % clock == 0 and index != self._ticked:
            self._ticked = index
            self._outlet.clock(self._telemetry.stamp_ns)

    def look_for_latecomers(self) -> None:
        """Send the present state to topics with new listeners; record nothing."""
        if (now := time.monotonic()) < self._next_look:
            return
        self._next_look = now + BEAT
        joined = self._outlet.joined()
        for key, count in joined.items():
            if count > self._known.get(key, 0):
                self._owed[key] = TIMES
        self._known = joined
        if not self._owed:
            return
        for key, build in self._builders:
            if key in self._owed:
                self._outlet.send(key, build())
        self._again(self._owed.keys())
        if VIEWS & self._owed.keys():
            self._outlet.tick(self._telemetry.stamp_ns)
        if "clock" in self._owed:
            self._outlet.clock(self._telemetry.stamp_ns)
        self._owed = {key: left - 1 for key, left in self._owed.items() if left > 1}
