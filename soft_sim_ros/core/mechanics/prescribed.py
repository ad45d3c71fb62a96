"""Inverse dynamics where only some coordinates are driven, at linear cost.

Boyer & Primault 2005 (3.34)–(3.36).

For a manipulator with elastic links the motion of the hinges is given and the bending of the links
follows. So the accelerations of the driven coordinates are inputs; those of the free coordinates
and the torques of the driven ones are results. One elimination does both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.recursion.elimination import factor, solve
from soft_sim_ros.core.recursion.tangent import tangent
from soft_sim_ros.core.terms.driven import HELD

from .dynamics import Dynamics
from .history import refuse_constraints


class PrescribedMotion(NamedTuple):
    """Accelerations (n,), the generalised forces (n,) that drive them, reactions at the joints.

    forces is zero except for driven coordinates: there it is what motors must add to efforts,
    springs and dampers, in N·m or N. reactions: joint → wrench (6,), see ``Dynamics.reactions``.
    """

    accelerations: Floats
    forces: Floats
    reactions: dict[str, Floats]


def prescribed_motion(
    dynamics: Dynamics,
    q: Floats,
    v: Floats,
    a: Floats,
    driven: NDArray[np.bool_],
    efforts: Floats | None = None,
    time: float = 0.0,
) -> PrescribedMotion:
    """Return the forces that accelerate the driven coordinates as given, all others being free.

    Parameters
    ----------
    q, v : (n,) state
    a : (n,) accelerations; only those of driven coordinates are read
    driven : (n,) which coordinates are driven; all: inverse dynamics, none: forward dynamics
    efforts : (A,) in scene order, zero by default
    time : s at which scheduled loads are taken

    Raises
    ------
    numpy.linalg.LinAlgError
        if a free coordinate moves no mass
    """
    refuse_constraints(dynamics.compiled.scene, "prescribed motions")
    model, system = dynamics.model, dynamics._system
    found = np.where(driven, a, 0.0)
    missing = dynamics.inverse_dynamics(q, v, found, efforts, time)
    if not driven.all():
        tangent(model, dynamics._data, (0.0, 0.0, 1.0), system)
        system.diagonal[_diagonal(dynamics)[driven]] *= HELD
        if not factor(model, system):
            raise np.linalg.LinAlgError("a free coordinate moves no mass")
        solve(model, system, missing)
        found = np.where(driven, a, -missing)
    forces = np.where(driven, dynamics.inverse_dynamics(q, v, found, efforts, time), 0.0)
    return PrescribedMotion(found, forces, dynamics.reactions(q, v, found, time))


def _diagonal(dynamics: Dynamics) -> NDArray[np.int64]:
    """Return where the diagonal (n,) of the matrix stands in ``System.diagonal``."""
    begin, offset = dynamics.model.block_col, dynamics._system.offset
    places = [at + np.arange(m) * (m + 1) for at, m in zip(offset, np.diff(begin), strict=False)]
    return np.concatenate(places).astype(np.int64)
