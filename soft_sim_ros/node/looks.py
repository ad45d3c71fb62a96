"""What is looked at now and then while a simulation runs: its energy ledger, and its recording."""

from __future__ import annotations

import time
from collections.abc import Callable

from soft_sim_ros.core.simulation.simulation import Simulation
from soft_sim_ros.node.log_trouble import LogTrouble
from soft_sim_ros.recording.telemetry import LEDGER

_RESIDUAL = LEDGER.index("residual")
_PERIOD_NS = 500_000_000  # of real time


class Looks:
    """Looks at a simulation and its recording.

    Parameters
    ----------
    simulation : Simulation
    log : BagWriter or None
    complain : callable
        Told in words what goes wrong with the recording.

    Attributes
    ----------
    residual : float
        Of the ledger, in J, at the last look.
    """

    def __init__(self, simulation: Simulation, log, complain: Callable[[str], None]):
        self._simulation = simulation
        self._trouble = LogTrouble(log, complain)
        self._due_ns = 0
        self.residual = 0.0

    def now_and_then(self) -> None:
        """Look at both if it is time to."""
        now = time.monotonic_ns()
        if now >= self._due_ns:
            self._due_ns = now + _PERIOD_NS
            self.at_ledger()
            self._trouble.look()

    def at_ledger(self) -> None:
        """Take the residual of now."""
        self.residual = float(self._simulation.ledger()[_RESIDUAL])
