"""Spatial error of the tip in the load cases of an arm and in a short motion."""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np

from soft_sim_ros.core.refine.prolong import finer
from soft_sim_ros.core.refine.space_error import static_error
from soft_sim_ros.core.simulation.simulation import Simulation

from .cases import cases, error_of
from .drive import Drive
from .space_watch import acting
from .unwritten import MOST, SHORT, companions_apart


@dataclass(frozen=True)
class Survey:
    """Estimates of the tip's error in space, over the length; infinite where there is none.

    rest : in the state of rest that was given
    corners : in all states of rest of cases.py that the arm's loads and actuators can cause
    motion : in a second from the initial state with safe efforts, against a finer companion
    missed : states of rest at the corners that were not found, and are in no estimate
    """

    rest: float
    corners: float
    motion: float
    missed: int = 0

    @property
    def certain(self) -> float:
        """The largest estimate of those that need no command."""
        return max(self.rest, self.motion)


def survey(simulation: Simulation, q: np.ndarray | None) -> Survey | None:
    """Estimate the errors for an arm; None if it has too many coordinates to be quick.

    q : (n,) the equilibrium with safe efforts, if there is one
    """
    dynamics = simulation.dynamics
    if not dynamics.compiled.chain.rods or not 0 < dynamics.n <= MOST:
        return None
    # known forces only: other wrenches are judged during the run
    known = [forcing for forcing in cases(dynamics) if forcing.tip is None]
    looked = [error_of(dynamics, forcing) for forcing in known]
    corners = max((error for error, state in looked if state is not None), default=0.0)
    missed = sum(state is None for _, state in looked)
    rest = 0.0 if q is None else static_error(dynamics, q, acting(simulation))
    one = copy.copy(simulation)
    one.reset()
    other = Simulation(finer(simulation.dynamics).compiled)
    steps = max(1, round(SHORT * 1e9 / one.step_ns))
    free = Drive(np.zeros(0, np.int64), np.zeros((0, one.n_actuators)), steps, max(1, steps // 50))
    motion, _ = companions_apart(one, other, free)
    return Survey(rest, corners, motion, missed)
