"""The state that a scene begins in."""

from __future__ import annotations

from soft_sim_ros.core.compile.overflow import refuse_energy
from soft_sim_ros.core.compile.scene import Compiled

from .initial import check_mass, initial_coordinates
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
    begin(stepper)
    return stepper.state()


def begin(stepper: Stepper) -> None:
    """Bring what steps a scene to the state that the scene begins in."""
    q, v = initial_coordinates(stepper.dynamics, stepper.safe_efforts())
    check_mass(stepper.dynamics, q)
    stepper.begin(q, v)
    refuse_energy(stepper.scene, stepper.ledger())
