"""Error of the tip by the discretisation in space, estimated with a finer model.

A state of one discretisation is mapped to a finer one, where it is no longer a solution. Newton's
method, or one step of it, gives the distance of the tip to the solution there. Errors in time are
not included.
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.closing import Closing
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.tips import apart, tip_ways
from soft_sim_ros.core.model.model import Live
from soft_sim_ros.errors import NotResolved
from soft_sim_ros.scene.numerics import FIXED_ORDER

from .prolong import finer, prolong, reference_turn

STEPS = 12  # of Newton's method
FOUND = 1e-7  # its last correction, as a displacement of the tip in arm lengths
LONGEST = 0.5  # arm lengths that one correction may move the tip
# Errors over the length above which a warning is given: with written numerics, and without.
WRITTEN, UNWRITTEN = 1e-2, 1e-3
# What is left beyond a finer model: little with two more orders, a third of the way or more where
# elements are halved, whose error falls with their square at best.
SAFETY, HALVED = 1.25, 1.6
STILL = 1e-3  # of the length: a way that is no motion yet
MEMORY = 1.0  # s for which a motion gathers the errors of its forces, at most


class Forcing(NamedTuple):
    """What acts on an arm, as the arguments of `Equations.forcing`."""

    efforts: Floats | None = None
    time: float = 0.0
    share: float = 1.0
    tip: Floats | None = None
    tip_follows: bool = False
    live: Live | None = None


def newton(
    dynamics: Dynamics, q: Floats, forcing: Forcing, free: NDArray[np.bool_] | None = None
) -> Floats | None:
    """Return the equilibrium (n,) that Newton's method finds from q, or None."""
    mask = dynamics.free if free is None else free & dynamics.free
    told, rates, accelerations = dynamics.guided(forcing.time, forcing.live)
    weight = dynamics.model.weight[mask]
    q = np.where(dynamics.free, q, told)
    closing = Closing(dynamics, q, forcing.time) if len(dynamics.constraints) else None
    if closing is not None:
        closing.at(1.0)
    for _ in range(STEPS):
        data = dynamics.forcing(*forcing)
        if closing is not None:
            closing.push()
        residual = dynamics.residual(q, rates, accelerations, data)
        matrix = dynamics.last_tangent((1.0, 0.0, 0.0))[np.ix_(mask, mask)]
        try:
            if closing is None:
                step = np.linalg.solve(matrix, residual[mask])
            else:
                step = closing.step(matrix, residual[mask], mask, 1.0)[0]
        except np.linalg.LinAlgError:
            return None
        size = float(np.max(np.abs(step) * weight, initial=0.0))
        if not np.isfinite(size):
            return None
        q[mask] -= min(1.0, LONGEST / size) * step if size > 0.0 else 0.0
        if size <= FOUND:
            return q
    return None


def static_error(
    dynamics: Dynamics, q: Floats, forcing: Forcing, free: NDArray[np.bool_] | None = None
) -> float:
    """Return how far off the tip of an equilibrium q (n,) is in space, over the length.

    It is the way to the equilibrium of `finer`; infinite if there is none near.

    free : (n,) bool, coordinates that were to be found; the others are held
    """
    if not dynamics.compiled.chain.rods:
        return 0.0
    fine = finer(dynamics, reference_turn(dynamics.compiled, q))
    start = prolong(dynamics.compiled, fine.compiled, q)
    held = None
    if free is not None and not free.all():
        held = prolong(dynamics.compiled, fine.compiled, np.logical_not(free).astype(float)) == 0.0
    found = newton(fine, start, forcing, held)
    if found is None:
        return float("inf")
    return trust(dynamics) * tips_apart(dynamics, q, fine, found)


def trust(dynamics: Dynamics) -> float:
    """Return the ratio of the error to the distance to the finer model, which is not exact."""
    bases = dynamics.compiled.scene.numerics.rods.values()
    return HALVED if any(basis.kind in FIXED_ORDER for basis in bases) else SAFETY


def tips_apart(one: Dynamics, q: Floats, other: Dynamics, p: Floats) -> float:
    """Return the largest distance of two models' tips over the length."""
    ends = [
        model.node_poses(x)[list(model.compiled.tips), :3, 3] for model, x in ((one, q), (other, p))
    ]
    return float(apart(ends[0], ends[1], one.compiled))


def motion_error(
    dynamics: Dynamics,
    q: Floats,
    v: Floats,
    forcing: Forcing,
    elapsed: float,
    moved: float = np.inf,
) -> float:
    """Return how far off the tip of a motion is in space by the forces of this moment.

    The forces that the finer model lacks for this motion, taken as lasting as long as the motion
    takes: √(way of the tip / its acceleration), way / speed, ``elapsed`` or MEMORY, the shortest of
    them. What resists them is the stiffness, and the inertia of that time. It sees what the basis
    cannot show now; errors that a swinging arm has gathered before, in phase for instance, it does
    not.

    Parameters
    ----------
    q, v : (n,) coordinates and rates
    forcing : what acts now
    elapsed : s since the motion began
    moved : m, by which a tip has been away from where it began
    """
    if not dynamics.compiled.chain.rods:
        return 0.0
    fine = finer(dynamics)
    free, a = dynamics.free, dynamics.guided(forcing.time, forcing.live)[2]
    still = dynamics.residual(q, v, a, dynamics.forcing(*forcing))
    mass = dynamics.last_tangent((0.0, 0.0, 1.0))
    if len(dynamics.constraints):
        a = dynamics.accelerations(q, v, dynamics.forcing(*forcing), forcing.time)
    else:
        a[free] -= np.linalg.solve(mass[np.ix_(free, free)], still[free])
    up, rate, push = prolong(dynamics.compiled, fine.compiled, np.array([q, v, a]))
    moving = tip_ways(dynamics, np.stack([v, a], axis=1), q)[1]
    speed, rise = np.linalg.norm(moving, axis=1).max(axis=0).tolist()
    moved = max(moved, STILL * dynamics.compiled.length)
    lasting = min(elapsed, MEMORY, moved / max(speed, 1e-300), np.sqrt(moved / max(rise, 1e-300)))
    closing = Closing(fine, up, forcing.time) if len(fine.constraints) else None
    if closing is not None:
        closing.at(1.0)
    residual = fine.residual(up, rate, push, fine.forcing(*forcing))
    inertia = 1.0 / max(1e-9, lasting) ** 2
    matrix = fine.last_tangent((1.0, 0.0, inertia))
    found, own = up.copy(), np.ix_(fine.free, fine.free)
    try:
        if closing is None:
            found[fine.free] -= np.linalg.solve(matrix[own], residual[fine.free])
        else:
            step = closing.step(matrix[own], residual[fine.free], fine.free, 1.0)[0]
            found[fine.free] -= step
    except np.linalg.LinAlgError:
        return float("inf")
    way = np.abs(up - found) * fine.model.weight
    if not np.isfinite(found).all() or way.max() > 2.0:
        return float("inf")
    return trust(dynamics) * tips_apart(dynamics, q, fine, found)


def limit_of(dynamics: Dynamics) -> float:
    """Return the error in space over the length beyond which a warning is given."""
    return WRITTEN if dynamics.compiled.scene.numerics.written else UNWRITTEN


def tell_if_coarse(
    dynamics: Dynamics,
    q: Floats,
    forcing: Forcing,
    free: NDArray[np.bool_] | None = None,
    *,
    stacklevel: int = 3,
) -> None:
    """Warn with NotResolved where an equilibrium q (n,) is beyond `limit_of`."""
    error, limit = static_error(dynamics, q, forcing, free), limit_of(dynamics)
    if not error <= limit:
        warnings.warn(NotResolved(dynamics.compiled.scene.name, error, limit), None, stacklevel)
