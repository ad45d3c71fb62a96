"""A companion that watches a run whose commands are not known beforehand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..errors import SolverError
from ..scene import Numerics
from .contract import SAFETY
from .inputs import Inputs, Order
from .refinement import Refinement
from .simulation import Simulation
from .space_watch import LookedInputs, has_space


class WatchedInputs(Inputs):
    """Inputs of a simulation that are given to a finer companion, too.

    Parameters
    ----------
    simulation, command_timeout, ramp : as for Inputs; the scene has a tolerance
    complain : told once in words when the estimate is beyond the tolerance

    Attributes
    ----------
    companion : the finer simulation (core/contract.py), of the same steps
    error_rel : estimate of the tip's largest error since the last reset, over the length; infinite
        from where the companion gave up
    """

    def __init__(
        self,
        simulation: Simulation,
        command_timeout: float,
        ramp: float,
        complain: Callable[[str], None] = lambda text: None,
    ) -> None:
        scene = simulation.scene
        tolerance = scene.numerics.tolerance
        if tolerance is None:
            raise ValueError(f"{scene.name} has no numerics.tolerance")
        super().__init__(simulation, command_timeout, ramp)
        finer: Numerics = Refinement(scene, tolerance).finer(scene.numerics)
        self.companion = Simulation(replace(scene, numerics=finer))
        self.tolerance, self.error_rel = tolerance, 0.0
        self._shadow = Inputs(self.companion, command_timeout, ramp)
        self._complain = complain
        self._tips = [s.sampler(2) for s in (simulation, self.companion)]

    def take(self, order: Order) -> None:
        """Hold the values of ``order`` from the next `update` on."""
        super().take(order)
        self._shadow.take(order)

    def advance(self, steps: int) -> None:
        """Advance both by ``steps``, and compare their tips."""
        super().advance(steps)
        if self.error_rel == np.inf:
            return
        before = self.error_rel
        try:
            self._shadow.advance(steps)
            tips = [sampler.poses()[-1, :3] for sampler in self._tips]
            apart = float(np.linalg.norm(tips[0] - tips[1])) / self.simulation.length
            self.error_rel = max(before, SAFETY * apart)
        except SolverError:
            self.error_rel = np.inf
        if before <= self.tolerance < self.error_rel:
            self._complain(
                f"at t = {self.simulation.time:.9g} s the tip may be off by "
                f"{self.error_rel:.2g} of the length, more than the tolerance {self.tolerance:g}"
            )

    def reset(self) -> None:
        """Go back to the initial state, both; the estimate begins anew."""
        super().reset()
        self._shadow.reset()
        self.companion.step_index = self.simulation.step_index  # it may have given up, or not
        self.error_rel = 0.0


def inputs_of(
    simulation: Simulation,
    command_timeout: float,
    ramp: float,
    complain: Callable[[str], None] = lambda text: None,
) -> Inputs:
    """Return inputs with a companion if the scene has a tolerance, with looks otherwise."""
    if simulation.scene.numerics.tolerance is None:
        if not has_space(simulation):
            return Inputs(simulation, command_timeout, ramp)
        return LookedInputs(simulation, command_timeout, ramp, complain)
    return WatchedInputs(simulation, command_timeout, ramp, complain)
