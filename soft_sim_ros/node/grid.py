"""The rates that parameters ask for, as whole numbers of steps."""

from __future__ import annotations

from collections.abc import Callable

from soft_sim_ros.node.clock import Grid
from soft_sim_ros.node.parameters import Settings


def asked_grid(asked: Settings, step_ns: int, say: Callable[[str], None]) -> Grid:
    """Return when to publish and to take up orders, for a step in ns.

    ``say`` is told in words of rates that are not a whole number of steps.
    """
    grid = Grid.of(step_ns, asked.publish_rate, asked.control_rate, asked.clock_rate)
    for name, rate, steps in (
        ("clock_rate", asked.clock_rate, grid.clock),
        ("publish_rate", asked.publish_rate, grid.publish),
        ("control_rate", asked.control_rate, grid.control),
    ):
        got = 1e9 / (max(1, steps) * step_ns)
        if rate and abs(got - rate) > 1e-6 * rate:
            say(
                f"{name} = {rate:g} Hz is not a whole number of steps of {step_ns * 1e-9:g} s: "
                f"using {got:.6g} Hz"
            )
    return grid
