"""The state that a scene begins in."""

from __future__ import annotations

from soft_sim_ros.core.compile.scene import Compiled

from .state import SimulationState
from .stepper import Stepper


def initial_state(model: Compiled, prune: bool = True) -> SimulationState:
    """Return the state that a scene begins in: ``initial`` of its file, under safe efforts.

    Parameters
    ----------
    model : what `compile_scene` returned
    prune : whether a planar motion is computed in its plane, as for ``Simulation``

    Raises
    ------
    StaticsFailed
        if it is an equilibrium, and none is found
    SceneError
        if a coordinate moves no mass, or the energies are no numbers
    """
    stepper = Stepper(model, prune)
    stepper._to_start()
    return stepper.state()
