"""A companion that watches a run whose commands are not known beforehand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from soft_sim_ros.core.arguments import whole
from soft_sim_ros.core.refine.refinement import Refinement
from soft_sim_ros.core.simulation.bounds import Bounds
from soft_sim_ros.core.simulation.inputs import MOST_STEPS, Inputs
from soft_sim_ros.core.simulation.orders import Order
from soft_sim_ros.core.simulation.simulation import Simulation
from soft_sim_ros.errors import SolverError
from soft_sim_ros.scene import Numerics

from .convergence import ASSUMED, accuracy, distances, factor
from .space_watch import LookedInputs, has_space

LOOK_NS, LOOK_STEPS = 4_000_000, 4  # between two looks, but always after a step


class WatchedInputs(Inputs):
    """Inputs of a simulation that are given to a finer companion, too.

    Parameters
    ----------
    simulation, command_timeout, ramp, bounds : as for Inputs; the scene has a tolerance
    complain : receives one message when the estimate exceeds the tolerance

    Attributes
    ----------
    companion : the finer simulation (core/accuracy/contract.py), of the same steps
    error_rel : estimate of the tips' largest error since the last reset, over the length; infinite
        from where the companion gave up
    error_rad : the same of the tip's orientation, in rad
    orientation : its tolerance in rad; None if the scene has none
    trust : factor from the distance of the two to the estimate, measured by the search that chose
        the numerics; assumed if there was no search
    """

    def __init__(
        self,
        simulation: Simulation,
        command_timeout: float,
        ramp: float,
        complain: Callable[[str], None] = lambda text: None,
        bounds: Bounds | None = None,
    ) -> None:
        scene = simulation.scene
        tolerance = scene.numerics.tolerance
        if tolerance is None:
            raise ValueError(f"{scene.name} has no numerics.tolerance")
        super().__init__(simulation, command_timeout, ramp, bounds)
        finer: Numerics = Refinement(scene, tolerance).finer(scene.numerics)
        self.companion = Simulation(replace(scene, numerics=finer, sensors=()))
        self.tolerance, self.error_rel = tolerance, 0.0
        self.orientation, self.error_rad = scene.numerics.orientation, 0.0
        self.trust = factor(ASSUMED) if scene.numerics.trust is None else scene.numerics.trust
        self._shadow = Inputs(self.companion, command_timeout, ramp)
        self._complain = complain
        self._every = max(1, min(LOOK_STEPS, LOOK_NS // simulation.step_ns))
        self._tips = [s.tips() for s in (simulation, self.companion)]

    def take(self, order: Order) -> None:
        """Hold the values of ``order`` from the next `update` on."""
        if self.companion.step_index < self.simulation.step_index:
            self._follow()
        super().take(order)
        self._shadow.take(order)

    def carry(self, name: str, attached: bool) -> None:
        """Attach or drop a payload of both; the companion first comes to where the other is."""
        self._follow()
        super().carry(name, attached)
        self._shadow.carry(name, attached)

    def advance(self, steps: int) -> None:
        """Advance both by ``steps``, and compare their tips every few steps.

        Those are the same steps however many are made at once.
        """
        steps = whole("steps", steps, 0, MOST_STEPS)
        while steps > 0:
            some = min(steps, self._every - self.simulation.step_index % self._every)
            super().advance(some)
            self._follow()
            steps -= some

    def _follow(self) -> None:
        """Bring the companion to where the simulation is, and compare if it is time to.

        An interrupt may have kept it behind.
        """
        if self.error_rel == np.inf:
            return
        before = self.missed
        try:
            self._shadow.advance(self.simulation.step_index - self.companion.step_index)
            if self.simulation.step_index % self._every == 0:
                one, other = (tips.poses()[None] for tips in self._tips)
                away, angle = distances(one, other, self.simulation.compiled)[-1].tolist()
                self.error_rel = max(self.error_rel, self.trust * away)
                self.error_rad = max(self.error_rad, self.trust * angle)
        except SolverError:
            self.error_rel = self.error_rad = np.inf
        if not before and self.missed:
            self._complain(f"at t = {self.simulation.time:.9g} s {self.doubt()}")

    @property
    def missed(self) -> bool:
        """Whether an estimate is beyond its tolerance."""
        turned = self.orientation is not None and self.error_rad > self.orientation
        return self.error_rel > self.tolerance or turned

    def accuracy(self) -> dict[str, float]:
        """Return tolerances and estimates by their keys in summary.json."""
        return accuracy(self.tolerance, self.error_rel, self.orientation, self.error_rad)

    def doubt(self) -> str:
        """Say how far off the tip may be; empty while it is within the tolerances."""
        if not self.missed:
            return ""
        if self.error_rel > self.tolerance:
            return (
                f"the tip may be off by {self.error_rel:.2g} of the length, more than the "
                f"tolerance {self.tolerance:g}"
            )
        return (
            f"the tip may be turned by {self.error_rad:.2g} rad, more than the "
            f"tolerance {self.orientation:g}"
        )

    def withdraw(self) -> list[str]:
        """Withdraw the inputs of both; the companion first advances to where the other failed."""
        dropped = super().withdraw()
        if dropped and self.error_rel < np.inf:
            try:
                self._shadow.advance(self.simulation.step_index - self.companion.step_index)
                self._shadow.withdraw()
            except SolverError:
                self.error_rel = np.inf
        return dropped

    def reset(self) -> None:
        """Go back to the initial state, both; the estimate begins anew."""
        super().reset()
        self._shadow.reset()
        self.companion.step_index = self.simulation.step_index  # it may have given up, or not
        self.error_rel = self.error_rad = 0.0


def inputs_of(
    simulation: Simulation,
    command_timeout: float,
    ramp: float,
    complain: Callable[[str], None] = lambda text: None,
    bounds: Bounds | None = None,
) -> Inputs:
    """Return inputs with a companion if the scene has a tolerance, with looks otherwise.

    Checks are made by the caller of `catch_up`.
    """
    if simulation.scene.numerics.tolerance is None:
        if not has_space(simulation):
            return Inputs(simulation, command_timeout, ramp, bounds)
        return LookedInputs(simulation, command_timeout, ramp, complain, bounds, later=True)
    return WatchedInputs(simulation, command_timeout, ramp, complain, bounds)
