"""The state that a scene begins in."""

from __future__ import annotations

from soft_sim_ros.core.arguments import vector, vector_or_zeros
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import BadArgument

from .state import SimulationState
from .stepper import Stepper


def initial_state(
    model: Compiled, q: Floats | None = None, v: Floats | None = None, prune: bool = True
) -> SimulationState:
    """Return a state to begin in: by default that of the scene, under safe efforts.

    Parameters
    ----------
    model : what `compile_scene` returned
    q, v : (n,) coordinates to begin in instead of those of the scene, and their rates, zero by
        default; dashpots of Maxwell branches are relaxed
    prune : whether a planar motion is computed in its plane, as for ``Simulation``

    Raises
    ------
    StaticsFailed
        if the scene begins in an equilibrium, and none is found
    SceneError
        if a coordinate moves no mass, or the energies are no numbers
    BadArgument
        if rates are given without coordinates, or either is not n finite numbers
    """
    stepper = Stepper(model, prune)
    if q is None:
        if v is not None:
            raise BadArgument("v", v, "left out, or given with q")
        stepper._to_start()
    else:
        n = stepper.n_coordinates
        given = vector("q", q, n, finite=True), vector_or_zeros("v", v, n, finite=True)
        stepper._to_shape(*given)
    return stepper.state()
