"""Dynamics and Simulation of any scene: numerics that it leaves free are chosen first.

Within core a scene is settled before it is compiled; this is the short form for everybody else.
"""

from __future__ import annotations

from soft_sim_ros.core.accuracy.contract import settle
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.mechanics import dynamics
from soft_sim_ros.core.simulation import simulation
from soft_sim_ros.core.simulation.state import SimulationState
from soft_sim_ros.scene import Scene


class Dynamics(dynamics.Dynamics):  # noqa: D101 - documented below
    __doc__ = dynamics.Dynamics.__doc__

    def __init__(self, scene: Scene | Compiled) -> None:
        super().__init__(settle(scene) if isinstance(scene, Scene) else scene)


class Simulation(simulation.Simulation):  # noqa: D101 - documented below
    __doc__ = simulation.Simulation.__doc__

    def __init__(
        self, model: Scene | Compiled, state: SimulationState | None = None, prune: bool = True
    ) -> None:
        super().__init__(settle(model) if isinstance(model, Scene) else model, state, prune)
