"""The simulator node with an arm that fails on purpose: ``FAULT`` says how, ``AFTER`` when (s)."""

from __future__ import annotations

import os
import sys
import time

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.errors import Diverged
from soft_sim_ros.node import prepare, simulate

FAULT, AFTER = os.environ["FAULT"], float(os.environ.get("AFTER", "0.2"))


class FaultyArm(Simulation):
    """Diverges once, raises something unexpected, or takes its time, from ``AFTER`` on."""

    diverged = False

    def advance(self, steps: int) -> None:
        """Advance, unless it is time for the fault."""
        left = round(AFTER * 1e9 - self.time_ns) // self.step_ns
        if FAULT == "diverge" and not self.diverged and left < steps:
            super().advance(max(0, left))
            FaultyArm.diverged = True
            raise Diverged(self.time, "made to fail by the test")
        if FAULT == "raise" and left < steps:
            raise ZeroDivisionError("made to fail by the test")
        if FAULT == "slow":
            time.sleep(steps * 0.004)
        super().advance(steps)


prepare.Simulation = FaultyArm
sys.exit(simulate.main())
