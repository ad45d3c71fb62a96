"""Load paths: the parameter λ along a branch of equilibria, and the forcing it stands for.

A load path is a function λ → scratch with gravity, loads, efforts and tip wrench set, as
``Dynamics.forcing`` returns it. These are the usual ones; any function of that kind will do.
"""

from __future__ import annotations

from collections.abc import Callable

from soft_sim_ros.core.arguments import vector, vector_or_zeros
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.model.model import Data
from soft_sim_ros.core.terms.forcing import schedule_factor
from soft_sim_ros.errors import CommandError

LoadPath = Callable[[float], Data]


def whole_load(
    dynamics: Dynamics,
    efforts: Floats | None = None,
    time: float = 0.0,
    tip: Floats | None = None,
    tip_follows: bool = False,
) -> LoadPath:
    """Return the path on which weight, loads, efforts and tip wrench are all λ times theirs."""
    return lambda load: dynamics.forcing(efforts, time, load, tip, tip_follows)


def tip_wrench(
    dynamics: Dynamics,
    wrench: Floats,
    tip_follows: bool = False,
    *,
    efforts: Floats | None = None,
    time: float = 0.0,
    held: Floats | None = None,
) -> LoadPath:
    """Return the path on which the tip carries ``held`` + λ · ``wrench`` (6,), moment and force.

    Both along world axes, or (``tip_follows``) along those of the tip; all else acts in full.
    """
    wrench = vector("wrench", wrench, 6)
    rest = vector_or_zeros("held", held, 6)
    return lambda load: dynamics.forcing(efforts, time, 1.0, rest + load * wrench, tip_follows)


def one_effort(
    dynamics: Dynamics,
    name: str,
    efforts: Floats | None = None,
    time: float = 0.0,
    tip: Floats | None = None,
    tip_follows: bool = False,
) -> LoadPath:
    """Return the path on which the effort of actuator ``name`` is λ, in the unit of its command.

    Raises
    ------
    CommandError
        if the scene has no such actuator.
    """
    names = [actuator.name for actuator in dynamics.compiled.scene.actuators]
    index = _index(name, names, "actuator")
    level = vector_or_zeros("efforts", efforts, len(names)).copy()

    def forcing(load: float) -> Data:
        level[index] = load
        return dynamics.forcing(level, time, 1.0, tip, tip_follows)

    return forcing


def one_load(
    dynamics: Dynamics, name: str, efforts: Floats | None = None, time: float = 0.0
) -> LoadPath:
    """Return the path on which load ``name`` is λ times what the scene says at ``time``.

    Raises
    ------
    CommandError
        if the scene has no such load, or its schedule leaves nothing of it at ``time``.
    """
    loads = dynamics.compiled.loads
    index = _index(name, [load.name for load in dynamics.compiled.scene.scheduled_loads], "load")
    begin, end = loads.ptr[index], loads.ptr[index + 1]
    begins, ends, ramp = (float(x) for x in loads.schedule[index])
    factor = schedule_factor(begins, ends, ramp, time)
    if factor == 0.0:
        raise CommandError("load path", f"load {name!r} does not act at t = {time:g} s")

    def forcing(load: float) -> Data:
        data = dynamics.forcing(efforts, time)
        target, kind = (data.follower, 1) if loads.follows[index] else (data.dead, 0)
        data.active[kind] = 1
        for p in range(begin, end):
            target[loads.node[p]] += (load - 1.0) * factor * loads.wrench[p]
        return data

    return forcing


def _index(name: str, names: list[str], what: str) -> int:
    if name not in names:
        known = ", ".join(names) or "none in this scene"
        raise CommandError("load path", f"unknown {what} {name!r}: expected one of {known}")
    return names.index(name)
