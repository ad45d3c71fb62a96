"""What all simulations of one model share: made once, and dropped with the model."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from soft_sim_ros.core.backend.structs import Packed
from soft_sim_ros.core.compile.overflow import whole_nanoseconds
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.integrators.problem import Method
from soft_sim_ros.core.integrators.tableaus import method_of
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.model.model import Model, in_its_plane

from .mark import ModelMark
from .state import SimulationState


@dataclass
class Shared:
    """What is the same for all simulations of a model.

    Attributes
    ----------
    model : as steps see it; what is read off sees all of space
    method : by which it is stepped
    packed : what of these never changes, packed for kernels
    mark : of its states
    initial : the state that the scene begins in, once it is known
    """

    model: Model
    method: Method
    packed: tuple[Packed, ...]
    mark: ModelMark
    initial: SimulationState | None = None


_shared: WeakKeyDictionary[Compiled, dict[bool, Shared]] = WeakKeyDictionary()


def shared_by(compiled: Compiled, prune: bool) -> Shared:
    """Return what simulations of a compiled scene share; ``prune`` as for ``Simulation``."""
    found = _shared.setdefault(compiled, {})
    if prune not in found:
        found[prune] = _made(compiled, prune)
    return found[prune]


def _made(compiled: Compiled, prune: bool) -> Shared:
    model, weight = compiled.model, compiled.model.weight.copy()
    # what a driven coordinate is told is no matter of Newton's method, nor of its errors
    weight[model.driven[:, 0]] = 0.0
    if len(model.branch):
        # dashpots of Maxwell branches follow the coordinates in all that a step moves
        held = np.diag(Dynamics(compiled).branch_matrix()) > 0.0
        weight = np.concatenate([weight, weight * held])
    stepped = model._replace(weight=weight)
    stepped = in_its_plane(stepped) if prune else stepped
    method = method_of(compiled.scene)
    parts = Packed(stepped), Packed(compiled.loads), Packed(method)
    mark = ModelMark.of(compiled, stepped, method, whole_nanoseconds(compiled.scene))
    return Shared(stepped, method, parts, mark)
