"""Compile, before the run, every kernel that the run will need."""

from __future__ import annotations

from soft_sim_ros.commands.progress import compiling
from soft_sim_ros.core.accuracy.contract import draft
from soft_sim_ros.core.settled import Simulation
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.scene import Scene
from soft_sim_ros.scene.limbs import limbs_of


def warm_up(scene: Scene) -> None:
    """Make a step and every message of an arm that is thrown away; show what is compiled."""
    with compiling():
        simulation = Simulation(draft(scene))
        simulation.advance(1)
        telemetry = Telemetry(simulation, 2, "world", "/warm_up", limbs=limbs_of(scene))
        for build in telemetry.builders.values():
            build()
