"""Property 1.1 of C over a run: no more energy is stored than has been supplied."""

from __future__ import annotations

from typing import Any

import numpy as np

from soft_sim_ros.core.analysis.discrete_gradient import DiscreteGradient
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import SolverError

from .scenes import Case


class Passivity:
    """Looks at ∫ τᵀq̇ dt − (H(t) − H(0)) at every instant.

    Parameters
    ----------
    energies : kinetic, elastic and gravity energy in J at the start, together H

    Attributes
    ----------
    least : the smallest value so far in J, that of the start, 0, included
    turned : energy turned over so far in J: the work without regard to sign, the heat, and the
        largest change of what is stored
    """

    def __init__(self, energies: Floats) -> None:
        self.least = self.turned = 0.0
        self._start, self._work, self._stored, self._supplied = energies, 0.0, 0.0, 0.0

    def look(self, energies: Floats, supplied: float, dissipated: float) -> None:
        """Take the energies of an instant more, and what was supplied and lost since the start."""
        change = energies - self._start
        self.least = min(self.least, supplied - float(change.sum()))
        self._work += abs(supplied - self._supplied)
        self._stored = max(self._stored, float(np.abs(change).sum()))
        self._supplied = supplied
        self.turned = self._work + self._stored + dissipated

    @property
    def rel(self) -> float:
        """``least`` over ``turned``: 0 where the property was never violated."""
        return self.least / self.turned if self.turned > 0.0 else 0.0


def by_discrete_gradient(case: Case) -> dict[str, Any]:
    """Run a case by the discrete gradient, at its own steps; say how its balance came out.

    What is lacking to passivity, and the largest violation of the balance (1.45), over the energy
    turned over.
    """
    motion, worst, outcome = DiscreteGradient(case.scene()), 0.0, "completed"

    def energies() -> Floats:
        return np.array(motion.system.dynamics.energies(motion.q, motion.v))

    passivity = Passivity(energies())
    try:
        for row in case.efforts():
            motion.step(case.step, row)
            stored, supplied, dissipated = motion.balance
            passivity.look(energies(), supplied, dissipated)
            worst = max(worst, abs(supplied - dissipated - stored))
    except SolverError as error:
        outcome = type(error).__name__
    return {
        "gradient_outcome": outcome,
        "gradient_balance_rel": worst / passivity.turned if passivity.turned > 0.0 else 0.0,
        "gradient_passivity_rel": passivity.rel,
    }
