"""The loop of the node's physics by itself: unpaced, in this process, and without ROS.

What it costs per simulated second is what computing costs a core that is never left. The node
sleeps between its instants; what it costs beyond this are DDS, the executor, waking up, and caches
that other programs have filled meanwhile.
"""

from __future__ import annotations

import math
import threading
import time
from pathlib import Path

from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.node.clock import Grid, Pacer
from soft_sim_ros.node.physics import Physics
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.scene import load_scene

from .peer import AMPLITUDES, RATE


class Wire:
    """Takes what the loop sends, and sends the next command when it hears of the time."""

    def __init__(self, heard: tuple[str, ...], commanded: bool, until_ns: int) -> None:
        self._heard, self._commanded, self._until_ns = heard, commanded, until_ns
        self.physics: Physics | None = None
        self.over = threading.Event()

    def wanted(self, key: str) -> bool:
        """Whether anybody listens."""
        return key in self._heard

    def send(self, key: str, data: bytes) -> None:
        """Drop a message."""

    def tick(self, time_ns: int) -> None:
        """Send the next command."""
        physics = self.physics
        assert physics is not None
        if time_ns >= self._until_ns:
            self.over.set()
        if self._commanded:
            t = time_ns * 1e-9
            efforts = [a * math.sin(math.pi * t + i) for i, a in enumerate(AMPLITUDES)]
            physics.submit("command", physics.inputs.effort_order(efforts), b"")

    def clock(self, time_ns: int) -> None:
        """Move no clock."""

    def joined(self) -> dict[str, int]:
        """Say that nobody comes later."""
        return {}


def share(scene: Path, heard: tuple[str, ...], commanded: bool, seconds: float) -> float:
    """Return the CPU time per simulated time over ``seconds`` simulated."""
    simulation = Simulation(load_scene(scene))
    inputs = Inputs(simulation, command_timeout=1.0, ramp=0.5)
    wire = Wire(heard, commanded, round(seconds * 1e9))
    telemetry = Telemetry(simulation, 51, "world", "/soft_arm")
    grid = Grid.of(simulation.step_ns, RATE, 250.0)
    physics = wire.physics = Physics(inputs, telemetry, wire, None, grid, Pacer(0.0))
    begin = time.process_time()
    physics.start()
    wire.over.wait()
    physics.stop()
    physics.join()
    if physics.failure or physics.diverged:
        raise RuntimeError(physics.failure or physics.diverged)
    return (time.process_time() - begin) / simulation.time
