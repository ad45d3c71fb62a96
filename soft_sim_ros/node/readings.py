"""Sends readings of sensors when they get out of them."""

from __future__ import annotations

from collections.abc import Collection

from soft_sim_ros.core.simulation.simulation import Simulation
from soft_sim_ros.node.clock import Grid
from soft_sim_ros.node.outlet import Outlet
from soft_sim_ros.recording.sensors import SensorMessages


class Readings:
    """The readings of a simulation on their topics, and in its recording.

    Parameters
    ----------
    simulation : Simulation
        The arm.
    messages : SensorMessages
        Builds the bytes.
    outlet : Outlet
        Publishes bytes.
    log : BagWriter or None
        Records bytes.
    grid : Grid
        When else something happens.
    """

    def __init__(
        self, simulation: Simulation, messages: SensorMessages, outlet: Outlet, log, grid: Grid
    ):
        self._simulation, self._messages, self._grid = simulation, messages, grid
        self._outlet, self._log = outlet, log
        self._any = bool(messages.topics)

    def steps(self) -> int:
        """Count the steps from now to the next instant of any kind."""
        steps = self._grid.steps_from(self._simulation.step_index)
        return min(steps, self._simulation.steps_to_reading()) if self._any else steps

    def send(self) -> None:
        """Send and record the readings that got out just now."""
        if not self._any:
            return
        for key, data in self._messages.new():
            if self._outlet.wanted(key):
                self._outlet.send(key, data)
            if self._log is not None:
                self._log.write(key, self._simulation.time_ns, data)

    def send_again(self, keys: Collection[str]) -> None:
        """Send the newest readings on some topics, to who came late; record nothing."""
        for key, data in self._messages.newest() if self._any else ():
            if key in keys:
                self._outlet.send(key, data)
