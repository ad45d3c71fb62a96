"""What a state must know of its model, to be refused by any other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.integrators.problem import Method
from soft_sim_ros.core.model.model import Model

from .value import Value

# Machines differ in the last bits of what they compile, and so may the sums over it.
SAME = 1e-9


@dataclass(frozen=True, eq=False)
class ModelMark(Value):
    """The names of a model, and a few numbers of each of its arrays.

    Attributes
    ----------
    scene : its name; another name alone makes no other model
    coordinates, actuators : their names
    sensors : what they are and when they measure, in words
    integrator, space : how it is stepped, and in which directions anything moves
    step_ns : size of a step in ns
    arrays : names of the arrays of the model
    sums : (len(arrays), 4) of each array (compile/fingerprint.py)
    """

    scene: str
    coordinates: tuple[str, ...]
    actuators: tuple[str, ...]
    sensors: tuple[str, ...]
    integrator: str
    space: str
    step_ns: int
    arrays: tuple[str, ...]
    sums: Floats

    @classmethod
    def of(cls, compiled: Compiled, stepped: Model, method: Method, step_ns: int) -> ModelMark:
        """Return the mark of a compiled scene; ``stepped`` is its model as steps see it."""
        scene, sums = compiled.scene, compiled.fingerprint
        options = np.array([method.rho, method.error, method.tolerance, method.limit])
        return cls(
            scene=scene.name,
            coordinates=compiled.coordinate_names,
            actuators=tuple(actuator.name for actuator in scene.actuators),
            sensors=tuple(
                f"{one.kind} {one.name} of {one.of}, {one.rate!r} Hz, {one.latency!r} s late"
                for one in scene.sensors
            ),
            integrator=scene.numerics.integrator,
            space=type(stepped.space).__name__,
            step_ns=step_ns,
            arrays=(*sums, *(f"numerics[{i}]" for i in range(len(options)))),
            sums=np.array([*sums.values(), *([x, abs(x), 1.0, 0.0] for x in options)]),
        )

    def difference(self, other: ModelMark) -> str:
        """Say in what another model differs from this one; empty if in nothing that matters."""
        if self is other:
            return ""
        for what in ("coordinates", "actuators", "sensors"):
            mine, theirs = getattr(self, what), getattr(other, what)
            if len(mine) != len(theirs):
                return f"it has {len(theirs)} {what}, not {len(mine)}"
            for one, two in zip(mine, theirs, strict=True):
                if one != two:
                    return f"it has {what} {two!r} where {one!r} is expected"
        for what in ("integrator", "step_ns", "space"):
            mine, theirs = getattr(self, what), getattr(other, what)
            if mine != theirs:
                return f"its {what} is {theirs!r}, not {mine!r}"
        if self.arrays != other.arrays or self.sums.shape != other.sums.shape:
            return "it was made by another version of the package"
        size = np.maximum(self.sums[:, 1], other.sums[:, 1])
        slack = SAME * np.stack([size, size, 0.1 + 0.0 * size, 1.0 + 0.0 * size], axis=1)
        with np.errstate(invalid="ignore"):  # a file may hold anything
            near = np.all(np.abs(self.sums - other.sums) <= slack, axis=1).tolist()
        if not all(near):
            names = [name for name, same in zip(self.arrays, near, strict=True) if not same]
            return f"its numbers are others ({', '.join(names)})"
        return ""
