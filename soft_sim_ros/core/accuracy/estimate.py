"""Estimate of the error of a run in time.

A step may resolve a motion inaccurately, or not at all. A companion with another method and a
quarter of the step reveals the first error. It does not reveal the second: two runs that both damp
out a fast vibration agree with each other. But the energy of a vibration that the method damped out
(or generated) is missing (or in excess) in the energy ledger, and this energy bounds the motion of
the tip (``Balance``). The estimate is the sum of both, relative to the limit of small steps; errors
of basis and nodes are not included.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import eigvals

from soft_sim_ros.core.analysis.small_motion import real_modes, unit_scale
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.mechanics.tips import apart
from soft_sim_ros.core.simulation.simulation import Simulation
from soft_sim_ros.errors import EnergyGained, Inaccurate

# The companion's part of a step, and its method. Inputs that jump leave errors which hardly depend
# on the step until fast motion is resolved, but do depend on the method.
PART = 4
COMPANION = {"sdirk3": "sdirk4"}
OTHERS = "sdirk3"
# Twice their difference: enough even if the error falls only with the square root of the step.
SAFETY = 2.0
# A motion of angular frequency ω is shown, at least by the companion, while ω h is below this.
SHOWN = 2.0
GAIN_ALLOWED = 0.1
MODES_CHECKED = 300  # with more coordinates, all motion is taken as slow and undamped


def hidden_motion(dynamics: Dynamics, q: Floats, step: float) -> tuple[float, float]:
    """Return reach in m/√J and decay in 1/s of motion that is too fast for ``step`` in s.

    Of free motion about q without loads, M ẍ + R ẋ + K x = 0. The reach is the largest displacement
    J Σ φᵢ aᵢ of a tip with ½ Σ ωᵢ² aᵢ² = 1 over the modes with ω h ≥ SHOWN: √(2 λ), λ the largest
    eigenvalue of Σ (J φᵢ)(J φᵢ)ᵀ/ωᵢ². The decay is the slowest at which any of the fast motions
    loses energy: twice that of its amplitude.
    """
    free = np.flatnonzero(dynamics.free)  # what is driven is known
    n = len(free)
    if n == 0:
        return 0.0, 0.0
    mass, stiffness, damping = (
        matrix[np.ix_(free, free)]
        for matrix in (
            dynamics.mass_matrix(q),
            dynamics.stiffness_matrix(),
            dynamics.damping_matrix(),
        )
    )
    tips = dynamics.tip_jacobians(q)[:, 3:, free] * dynamics.compiled.tip_scale[:, None, None]
    if n > MODES_CHECKED:
        held = np.flatnonzero(np.diag(stiffness))
        soft = np.linalg.inv(stiffness[np.ix_(held, held)])
        return _reach(tips[:, :, held] @ soft @ tips[:, :, held].transpose(0, 2, 1)), 0.0
    scale = unit_scale(stiffness, np.diag(stiffness), dynamics.model.weight[free])
    omega, shapes = real_modes(stiffness, mass, scale)
    omega = np.abs(omega)
    hidden = omega * step >= SHOWN
    if not hidden.any():
        return 0.0, 0.0
    moves = (tips @ shapes)[:, :, hidden] / omega[hidden]
    reach = _reach(moves @ moves.transpose(0, 2, 1))
    # by modes, in units of the step: so no motion is round-off of another
    flow = np.zeros((2 * n, 2 * n))
    flow[:n, n:] = step * np.diag(omega)
    flow[n:, :n] = -flow[:n, n:]
    flow[n:, n:] = -step * (shapes.T @ damping @ shapes)
    rates = eigvals(flow)
    fast = np.abs(rates) >= SHOWN
    return reach, max(0.0, float(-2.0 * rates[fast].real.max() / step)) if fast.any() else 0.0


def _reach(yields: Floats) -> float:
    """Return √(2 λ), λ the largest eigenvalue of symmetric matrices (T, 3, 3)."""
    return float(np.sqrt(2.0 * np.linalg.eigvalsh(yields)[:, -1].max()))


class Balance:
    """Error estimate from the energy ledger.

    Energy missing from the ledger belongs to motion too fast for the step. That motion would have
    decayed at least as fast as its slowest mode, so the estimate is forgotten at that rate.

    Parameters
    ----------
    simulation : Simulation, at its start

    Attributes
    ----------
    hidden : bound in m on what the tip lacks (or has too much) of motion too fast for the step
    gain : largest rise of the residual so far, in J
    turned : all energy turned over, in J: the work of actuators and loads without regard to sign,
        the heat, and the largest change of what is stored
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        step = simulation.step_ns * 1e-9
        self._reach, self._decay = hidden_motion(simulation.dynamics, simulation.q, step)
        self._time = simulation.time
        self._start = self._last = simulation.ledger()
        self._missing = self._low = self._high = 0.0
        self._least = self._work = self._stored = 0.0
        self.hidden = self.gain = self.turned = 0.0

    def update(self) -> None:
        """Read the ledger. More frequent calls also see work that is returned later."""
        time, ledger = self._simulation.time, self._simulation.ledger()
        change = ledger - self._last
        fading = float(np.exp(-self._decay * (time - self._time)))
        self._missing = self._missing * fading + change[-1]
        self._low, self._high = min(self._low, self._missing), max(self._high, self._missing)
        # the arm is nowhere further from itself than twice its length
        most = 2.0 * self._simulation.length
        spread = self._high - self._low
        self.hidden = min(most, self._reach * float(np.sqrt(spread))) if spread > 0.0 else 0.0
        self._work += float(np.abs(change[3:5]).sum())
        self._stored = max(self._stored, float(np.abs(ledger[:3] - self._start[:3]).sum()))
        self._least = min(self._least, float(ledger[-1]))
        self.gain = max(self.gain, float(ledger[-1]) - self._least)
        self.turned = self._work + self._stored + float(ledger[5])
        self._time, self._last = time, ledger


class Estimated:
    """A simulation with a companion of smaller steps, which together know their error in time.

    The companion follows the efforts of the simulation, not a wrench at its tip.

    Parameters
    ----------
    simulation : Simulation, at its start; its step is a multiple of 4 ns
    limit : of the estimate, over the length; infinite: never refused

    Attributes
    ----------
    error_rel : largest estimate so far of the tip's error over the length: twice
        ``difference_rel``, the distance of the two tips, and ``hidden_rel``, that of Balance
    gained_rel : spurious energy over the energy turned over: the rise of the ledger's residual,
        as far as the arm did hold more energy than the companion's (the rest is the ledger's own
        error, of heat within a step for instance)
    ledger_gain_rel : the same without regard to the companion
    """

    def __init__(self, simulation: Simulation, limit: float = float("inf")) -> None:
        self.simulation, self.limit = simulation, limit
        scene = simulation.scene
        numerics = replace(
            scene.numerics,
            step=scene.numerics.step / PART,
            integrator=COMPANION.get(scene.numerics.integrator, OTHERS),
            options={},
        )
        self.companion = Simulation(replace(scene, numerics=numerics, sensors=()))
        self._tips = [s.tips() for s in (simulation, self.companion)]
        self._balance = Balance(simulation)
        self._excess = 0.0
        self.difference_rel = self.hidden_rel = self.error_rel = self.gained_rel = 0.0
        self.ledger_gain_rel = 0.0

    def follow(self, steps: int) -> None:
        """Advance the companion by ``steps`` steps that the simulation has made, and compare.

        The efforts that the simulation holds now must have acted in all of them.

        Raises
        ------
        Diverged
            if the companion gives up
        Inaccurate
            if the estimate is beyond the limit
        EnergyGained
            if there is a limit, and more than GAIN_ALLOWED of the energy is spurious
        """
        self.companion.set_efforts(self.simulation.ports()[2])
        self.companion.advance(PART * steps)
        length, time = self.simulation.length, self.simulation.time
        one, other = (tips.poses()[:, :3] for tips in self._tips)
        away = float(apart(one, other, self.simulation.compiled))
        self._balance.update()
        self.difference_rel = max(self.difference_rel, away)
        self.hidden_rel = self._balance.hidden / length
        self.error_rel = SAFETY * self.difference_rel + self.hidden_rel
        stored = [float(s.ledger()[:3].sum()) for s in (self.simulation, self.companion)]
        self._excess = max(self._excess, stored[0] - stored[1])
        gain, turned = self._balance.gain, self._balance.turned
        self.gained_rel = min(gain, self._excess) / turned if turned > 0.0 else 0.0
        self.ledger_gain_rel = gain / turned if turned > 0.0 else 0.0
        if not self.error_rel <= self.limit:
            raise Inaccurate(time, self.error_rel, self.limit)
        if self.limit < float("inf") and not self.gained_rel <= GAIN_ALLOWED:
            raise EnergyGained(time, self.gained_rel, GAIN_ALLOWED)

    def summary(self) -> dict[str, float]:
        """Return the estimate and its parts, over the length, and the gain of energy."""
        return {
            "error_rel": self.error_rel,
            "difference_rel": self.difference_rel,
            "hidden_rel": self.hidden_rel,
            "gained_rel": self.gained_rel,
        }
