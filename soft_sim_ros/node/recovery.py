"""Commands that make the solver fail are withdrawn, and the arm goes on."""

from __future__ import annotations

from collections.abc import Callable

from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import Diverged
from soft_sim_ros.node.commands import Throttle

RESET = "reset"
_SHAKEN_NS = 1_000_000_000  # simulated: so long a withdrawn command may be the cause of what comes


class Recovery:
    """Goes on without the commands in force when the solver gives up.

    First the wrench is withdrawn, then the efforts. Should what they did to the arm still be too
    much a moment later, it starts anew.

    Parameters
    ----------
    inputs : Inputs
        The commands in force.
    complain : callable
        Called with a message, once a second at most.

    Attributes
    ----------
    count : how often something was done
    said : what, the last time
    """

    def __init__(self, inputs: Inputs, complain: Callable[[str], None]):
        self._inputs, self._complain = inputs, Throttle(complain)
        self._shaken_until_ns = 0
        self.count, self.said = 0, ""

    def after(self, error: Diverged) -> str | None:
        """Do what can be done and return the event that tells of it; None: it is not commands."""
        time_ns = self._inputs.simulation.time_ns
        if dropped := ", ".join(self._inputs.withdraw()):
            event = done = f"withdrawn: {dropped}"
            self._shaken_until_ns = time_ns + _SHAKEN_NS
        elif time_ns < self._shaken_until_ns:
            event, done = RESET, "back to the initial state"
            self._inputs.reset()
            self._shaken_until_ns = 0
        else:
            return None
        self.count += 1
        self.said = f"{error}; {done}"
        self._complain(f"the solver gave up {self.said}", event.partition(":")[0])
        return event
