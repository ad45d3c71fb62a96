"""How far off the tip is in space where loads and actuators can take an arm, and in a motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .cases import cases, error_of
from .drive import probe
from .prolong import finer
from .simulation import Simulation
from .space_error import static_error
from .space_watch import acting
from .unwritten import MOST, companions_apart, short


@dataclass(frozen=True)
class Survey:
    """Estimates of the tip's error in space, over the length; infinite where there is none.

    rest : in the state of rest that was given
    corners : in all states of rest of cases.py that the arm's loads and actuators can cause
    motion : in a short motion (drive.probe), against a finer companion of the same steps
    """

    rest: float
    corners: float
    motion: float

    @property
    def worst(self) -> float:
        """The largest of them."""
        return max(self.rest, self.corners, self.motion)


def survey(simulation: Simulation, q: np.ndarray | None) -> Survey | None:
    """Look at an arm; None if it has too many coordinates for a look that is short.

    q : (n,) the equilibrium with safe efforts, if there is one
    """
    dynamics = simulation.dynamics
    if not dynamics.compiled.chain.rods or not 0 < dynamics.n <= MOST:
        return None
    # known pushes only: a wrench that nobody has announced is judged when it comes
    known = [forcing for forcing in cases(dynamics) if forcing.tip is None]
    corners = max((error_of(dynamics, forcing)[0] for forcing in known), default=0.0)
    rest = 0.0 if q is None else static_error(dynamics, q, acting(simulation))
    one = Simulation(simulation.scene)
    other = Simulation(finer(simulation.dynamics).compiled.scene)
    motion, _ = companions_apart(one, other, short(probe(one), one))
    return Survey(rest, corners, motion)
