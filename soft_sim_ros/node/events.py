"""Events: short texts about what happens to a run, published and recorded."""

from __future__ import annotations

from soft_sim_ros.core.simulation.simulation import Simulation
from soft_sim_ros.node.outlet import Outlet
from soft_sim_ros.recording.cdr import encode_string


class Events:
    """Sends events of a simulation.

    Parameters
    ----------
    simulation : Simulation
        Gives their time.
    outlet : Outlet
        Publishes them.
    log : BagWriter or None
        Records them.
    """

    def __init__(self, simulation: Simulation, outlet: Outlet, log):
        self._simulation, self._outlet, self._log = simulation, outlet, log

    def say(self, text: str, time_ns: int | None = None) -> None:
        """Send an event of now, or of ``time_ns``."""
        data = encode_string(text)
        self._outlet.send("events", data)
        if self._log is not None:
            self._log.write(
                "events", self._simulation.time_ns if time_ns is None else time_ns, data
            )
