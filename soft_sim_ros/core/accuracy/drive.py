"""A run known beforehand: efforts over steps, and when the arm is compared."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from soft_sim_ros.core.analysis.modes import complex_modes
from soft_sim_ros.core.floats import Floats, Ints
from soft_sim_ros.core.mechanics.tips import tip_ways
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.core.simulation.simulation import Simulation

# A test run takes two periods of the slowest motion, within these bounds in s. It holds the arm at
# corners of what its actuators can do, then shakes it.
SHORTEST, LONGEST = 0.4, 4.0
CORNERS, PUSHES = 3, 8
HOLDING = 0.6  # of its time
MODES_CHECKED = 300  # coordinates beyond which their period is not looked for
LOOKS = 50000
SWAY = 0.3  # displacement of a tip, over the length, by an effort without limits


@dataclass(frozen=True)
class Drive:
    """Efforts that are held from a step on, until the next.

    Parameters
    ----------
    steps : (T,) step at whose start each row is taken up, never falling
    efforts : (T, A) in scene order, N·m, N or Pa (m: tendons by length)
    last : number of steps of the run
    every : steps between two looks
    """

    steps: Ints
    efforts: Floats
    last: int
    every: int

    def stretches(self) -> Iterator[tuple[list[Floats], int]]:
        """Yield (efforts to take up, step to go on to), so that every look is an end."""
        due = list(zip(self.steps.tolist(), self.efforts, strict=True))[::-1]
        index = 0
        while index < self.last:
            taken = []
            while due and due[-1][0] <= index:
                taken.append(due.pop()[1])
            stop = min(self.last, index + self.every - index % self.every)
            if due:
                stop = min(stop, due[-1][0])
            yield taken, stop
            index = stop

    def looks(self, step: int) -> bool:
        """Whether the arm is compared after this many steps."""
        return step % self.every == 0 or step == self.last

    def looking(self) -> Drive:
        """Return the same run, looked at after every step, or LOOKS times if it has more steps."""
        return replace(self, every=max(1, -(-self.last // LOOKS)))

    def tip(self, simulation: Simulation, see: Callable[[], None] = lambda: None) -> Floats:
        """Make the run; return the tip, of several the last, (looks, 3) in m in the world."""
        return self.poses(simulation, see)[:, -1, :3]

    def poses(self, simulation: Simulation, see: Callable[[], None] = lambda: None) -> Floats:
        """Make the run; return poses (looks, T, 7) of all tips in the world.

        ``see`` sees every look.

        Raises
        ------
        Diverged
            if the solver gives up
        """
        inputs, tips = Inputs(simulation, command_timeout=0.0, ramp=0.0), simulation.tips()
        poses: list[Floats] = []

        def look() -> None:
            poses.append(tips.poses().copy())
            see()

        look()
        index = 0
        for taken, stop in self.stretches():
            for efforts in taken:
                inputs.command(efforts)
            inputs.advance(stop - index)
            index = stop
            if self.looks(stop):
                look()
        return np.array(poses)


def probe(simulation: Simulation) -> Drive:
    """Return a test run for an arm with unknown commands: its actuators bend and shake it.

    All go to their upper limits, then to corners drawn between both, then to efforts drawn between
    the limits; the same ones at every call. Without a limit, it is what would move the tip by SWAY
    in the time of the probe, by small motion.
    """
    actuators = simulation.scene.actuators
    duration = _duration(simulation)
    last = max(1, round(duration * 1e9 / simulation.step_ns))
    reach = _sway(simulation, duration)
    drawn = np.random.default_rng(1).uniform(0.0, 1.0, (CORNERS + PUSHES, len(actuators)))
    rows = np.where(np.arange(len(drawn))[:, None] < CORNERS, np.round(drawn), drawn)
    rows[0] = 1.0
    starts = [HOLDING * np.arange(CORNERS) / CORNERS]
    starts += [HOLDING + (1.0 - HOLDING) * np.arange(PUSHES) / PUSHES]
    for i, actuator in enumerate(actuators):
        bounds = zip(actuator.limits, (-reach[i], reach[i]), strict=True)
        low, high = (limit if np.isfinite(limit) else sway for limit, sway in bounds)
        rows[:, i] = low + (high - low) * rows[:, i]
    steps = (last * np.concatenate(starts)).astype(np.int64)
    return Drive(steps, rows, last, max(1, last // 100))


def _duration(simulation: Simulation) -> float:
    """Return two periods in s of the slowest motion about the initial state, within bounds."""
    if not 0 < simulation.n_coordinates <= MODES_CHECKED:
        return LONGEST
    rates = np.abs(complex_modes(simulation.dynamics, simulation.q).values)
    moving = rates[rates > 0.0]
    slowest = float(moving.min()) if len(moving) else 0.0
    return float(np.clip(4.0 * np.pi / max(slowest, 1e-9), SHORTEST, LONGEST))


def _sway(simulation: Simulation, duration: float) -> Floats:
    """Return the effort (A,) of every actuator that moves the tip by SWAY in small motion."""
    dynamics, q = simulation.dynamics, simulation.q
    if not simulation.n_actuators or not simulation.n_coordinates:
        return np.zeros(simulation.n_actuators)
    # for so short a time, coordinates without stiffness are held by inertia
    held = dynamics.stiffness_matrix() + dynamics.mass_matrix(q) * (2.0 * np.pi / duration) ** 2
    free, efforts = dynamics.free, dynamics.effort_matrix(q)
    moves = np.zeros(efforts.shape)
    moves[free] = np.linalg.solve(held[np.ix_(free, free)], efforts[free])
    turns, ways = (np.linalg.norm(x, axis=1).max(axis=0) for x in tip_ways(dynamics, moves, q))
    turns = turns * simulation.length
    return SWAY * simulation.length / np.maximum(np.maximum(ways, turns), 1e-300)
