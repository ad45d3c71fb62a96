"""The accuracy contract: a scene names a tolerance, the solver chooses how to meet it.

Chosen is what the scene leaves free: the error of the integrator's steps, and for every rod its
elements, the order of every strain and the number of nodes. A run is made twice, with a choice and
with a finer *companion*: a tenth of the error of a step, two more orders, half as many segments
again. The largest distance of the two tips, over the length and with some safety, is the estimate:
of the motion, against the continuum, and no sum of local errors. Where it is beyond the tolerance,
each of the three is refined alone, which shows whose the error is, and the choice is refined there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..errors import SolverError, ToleranceMissed
from ..scene import STRAINS, Free, Numerics, Scene
from .drive import Drive, probe
from .dynamics import Dynamics
from .model import Floats
from .refinement import Refinement, source_with, words
from .simulation import Simulation

SAFETY = 1.25  # the companion is no continuum
SHARE = 0.25  # of the tolerance, for each of time, order and nodes
# Given up after so many refinements, or so many in a row that gain less than a factor GAIN: motion
# without damping may depend on everything.
ROUNDS, PATIENCE, GAIN = 12, 3, 1.5


@dataclass(frozen=True)
class Choice:
    """What meets a tolerance, and how well.

    scene : the scene with nothing left free, also in its source
    estimate : of the tip's largest error in the drive, over the length
    rounds : how often the choice was refined
    """

    scene: Scene
    estimate: float
    rounds: int


@dataclass(frozen=True)
class _Trial:
    """A run: its tips (looks, 3) in m, and what the highest orders of a strain may move."""

    tips: Floats
    top: dict[tuple[str, str], float]


def draft(scene: Scene) -> Scene:
    """Return a scene with a first guess of what it leaves free: its kernels are the same."""
    tolerance = scene.numerics.tolerance
    if not scene.numerics.free:
        return scene
    if tolerance is None:
        from .unwritten import first_guess  # which takes what is here

        return first_guess(scene)
    return replace(scene, numerics=replace(Refinement(scene, tolerance).first(), free=Free()))


def settled(scene: Scene) -> Scene:
    """Return a scene in which nothing is left free, chosen by a probe where something was."""
    if scene.numerics.free and scene.numerics.tolerance is None:
        from .unwritten import settle_unwritten  # which takes what is here

        return settle_unwritten(scene).scene
    return choose(scene).scene if scene.numerics.free else scene


def choose(
    scene: Scene, drive: Drive | None = None, say: Callable[[str], None] = lambda text: None
) -> Choice:
    """Choose what a scene with a tolerance leaves free.

    Parameters
    ----------
    scene : with ``numerics.tolerance``
    drive : the run to be made; None: a probe, for commands that nobody knows yet
    say : told in words what is tried

    Raises
    ------
    ToleranceMissed
        if the finest choice that makes sense, or what the scene fixes, does not meet it
    SolverError
        if the solver gives up, however fine the choice
    """
    tolerance = scene.numerics.tolerance
    if tolerance is None:
        raise ValueError(f"{scene.name} has no numerics.tolerance")
    search = _Search(scene, tolerance, drive)
    numerics, estimate, stuck = search.rules.first(), np.inf, 0
    for rounds in range(ROUNDS):
        before = estimate
        estimate = SAFETY * search.apart(numerics, search.rules.finer(numerics))
        say(f"{words(numerics)}: estimate {estimate:.2g} for {tolerance:g}")
        if estimate <= tolerance:
            fixed = replace(numerics, free=Free())
            chosen = replace(scene, numerics=fixed, source=source_with(scene, fixed))
            return Choice(chosen, estimate, rounds)
        stuck = stuck + 1 if estimate > before / GAIN else 0
        if stuck == PATIENCE:
            break
        refined = search.refined(numerics)
        if refined == numerics:
            break
        numerics = refined
    if search.failure is not None:
        raise search.failure
    raise ToleranceMissed(scene.file, tolerance, estimate, words(numerics))


class _Search:
    """Trials of one scene and drive, each made once."""

    def __init__(self, scene: Scene, tolerance: float, drive: Drive | None) -> None:
        self.rules = Refinement(scene, tolerance)
        self.failure: SolverError | None = None
        self._scene, self._goal = scene, SHARE * tolerance / SAFETY
        self._drive = drive
        self._trials: dict[str, _Trial | SolverError] = {}

    def trial(self, numerics: Numerics) -> _Trial | None:
        """Make the run, or remember it; None if the solver gave up."""
        key = repr((numerics.options, numerics.rods))
        if key not in self._trials:
            try:
                self._trials[key] = self._run(numerics)
            except SolverError as failure:
                self._trials[key] = failure
        result = self._trials[key]
        self.failure = result if isinstance(result, SolverError) else None
        return None if isinstance(result, SolverError) else result

    def _run(self, numerics: Numerics) -> _Trial:
        simulation = Simulation(replace(self._scene, numerics=replace(numerics, free=Free())))
        if self._drive is None:
            self._drive = probe(simulation)
        largest = np.zeros(simulation.n_coordinates)

        def see() -> None:
            np.maximum(largest, np.abs(simulation.q), out=largest)

        tips = self._drive.tips(simulation, see)
        return _Trial(tips / simulation.length, top_orders(simulation, largest))

    def apart(self, one: Numerics, other: Numerics) -> float:
        """Return the largest distance of two tips over the length; infinite without both runs."""
        runs = [self.trial(numerics) for numerics in (one, other)]
        if runs[0] is None or runs[1] is None:
            return float("inf")
        return float(np.linalg.norm(runs[0].tips - runs[1].tips, axis=1).max())

    def refined(self, numerics: Numerics) -> Numerics:
        """Return a choice refined where the error is; the same one if nothing there is free."""
        rules, goal = self.rules, self._goal
        parts = {
            "time": rules.finer_time(numerics),
            "space": rules.finer_space(numerics),
            "nodes": rules.finer_nodes(numerics),
        }
        if self.failure is not None:  # no run, no error to look at
            return rules.all_finer(numerics)
        excess = {name: self.apart(numerics, finer) / goal for name, finer in parts.items()}
        space = self.trial(parts["space"])
        most = max(excess.values())
        if most <= 1.0:  # each is within its share, but not all of them together
            excess = {name: 2.0 if value == most else value for name, value in excess.items()}
        if excess["time"] > 1.0:
            numerics = rules.more_time(numerics, excess["time"])
        if excess["nodes"] > 1.0:
            numerics = rules.more_nodes(numerics, excess["nodes"])
        if excess["space"] > 1.0 and space is not None:
            numerics = rules.more_space(numerics, {k: v / goal for k, v in space.top.items()})
        return numerics


def top_orders(simulation: Simulation | Dynamics, largest: Floats) -> dict[tuple[str, str], float]:
    """Return how far, over the length, the two highest orders of every strain may move the tip.

    largest : (n,) the largest size of every coordinate in a run
    """
    ways = largest * simulation.model.weight
    top: dict[tuple[str, str], float] = {}
    for name, rod in simulation.compiled.chain.rods.items():
        for element in rod.elements:
            for component, first, count in element.columns:
                key = name, STRAINS[component]
                way = float(ways[max(first, first + count - 2) : first + count].sum())
                top[key] = top.get(key, 0.0) + way
    return top
