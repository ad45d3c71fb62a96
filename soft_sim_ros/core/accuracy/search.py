"""The runs of a search for numerics: each made once, compared, and their work counted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.core.refine.refinement import Refinement, words
from soft_sim_ros.core.simulation.simulation import Simulation
from soft_sim_ros.errors import SolverError
from soft_sim_ros.scene import STRAINS, Free, Numerics, Scene

from .convergence import NOISE, SAFETY, bound, contraction, distances
from .drive import Drive, probe

SHARE = 0.25  # of the tolerance, for each of time, order and nodes
# What all runs of a search may cost: evaluations of the residual, times segments, times degrees of
# freedom and those of a rigid body. Independent of the clock, so a scene gets the same numerics on
# any machine. About 5e7 to 1e8 per second, so a minute or two; a comparison of tips counts LOOK.
LIMIT, LOOK = 5.0e9, 2000.0


@dataclass(frozen=True)
class Verdict:
    """The estimates for a choice of numerics.

    error, angle : estimates of the tip's error, over the length and in rad
    excess : the larger one, over what is allowed
    holds, end : simulated time in s up to which they are allowed, and at the end of the run
    contraction : from one companion to the next; None if only one was asked
    """

    numerics: Numerics
    error: float = float("inf")
    angle: float = float("inf")
    excess: float = float("inf")
    holds: float = 0.0
    end: float = 0.0
    contraction: float | None = None


@dataclass(frozen=True)
class _Trial:
    """A run: poses (looks, 7) of its tip, and the effect of the highest orders of each strain."""

    poses: Floats
    top: dict[tuple[str, str], float]


class Spent(Exception):
    """The search has used up its budget."""


class Search:
    """Trials of one scene and drive.

    Parameters
    ----------
    scene : with a tolerance
    drive : the run to be made; None: a probe
    say : receives messages about the search
    limit : of the work of all trials

    Attributes
    ----------
    work : of all trials so far
    failure : of the last trial, if the solver gave up in it
    """

    def __init__(
        self, scene: Scene, drive: Drive | None, say: Callable[[str], None], limit: float = LIMIT
    ) -> None:
        tolerance, orientation = scene.numerics.tolerance, scene.numerics.orientation
        assert tolerance is not None
        self.rules = Refinement(scene, tolerance)
        self.failure: SolverError | None = None
        self.work, self.limit = 0.0, limit
        self._scene, self._say = scene, say
        self._allowed = np.array([tolerance, np.inf if orientation is None else orientation])
        self._drive = None if drive is None else drive.looking()
        self._times = np.zeros(0)
        self._trials: dict[str, _Trial | SolverError] = {}

    def judge(self, numerics: Numerics, thoroughly: bool = False) -> Verdict:
        """Compare a choice with its companion, or ``thoroughly`` with that one's, too."""
        finer = self.rules.finer(numerics)
        near = self._apart(numerics, finer)
        if near is None:
            return Verdict(numerics)
        estimate, ratio = SAFETY * near, None
        if thoroughly:
            finest = self.rules.finest(numerics)
            far, between = self._apart(numerics, finest), self._apart(finer, finest)
            if far is None or between is None:
                return Verdict(numerics)
            estimate = bound(near, far, between)
            ends = np.maximum(near[-1], NOISE * self._allowed)
            known = np.isfinite(self._allowed)
            ratio = float(contraction(ends, between[-1])[known].max())
        excess = (estimate / self._allowed).max(axis=1)
        # one companion alone may show half of the error
        late = np.flatnonzero(excess > (1.0 if thoroughly else 0.5))
        first = int(late[0]) if len(late) else len(excess)
        holds = self._times[first - 1] if first > 0 else 0.0
        error, angle = estimate[-1].tolist()
        worst, end = float(excess[-1]), float(self._times[-1])
        return Verdict(numerics, error, angle, worst, float(holds), end, ratio)

    def refined(self, verdict: Verdict, slow: bool = False) -> Numerics:
        """Return a choice refined where the error is; the same one if nothing there is free.

        slow : the refinement before gained little
        """
        rules, numerics = self.rules, verdict.numerics
        parts = {
            "time": rules.finer_time(numerics),
            "space": rules.finer_space(numerics),
            "nodes": rules.finer_nodes(numerics),
        }
        if self.failure is not None:  # no run, no error to look at
            return rules.all_finer(numerics)
        # with slow contraction the companion shows only a part of the error
        hidden = 1.0 / (1.0 - min(0.8, verdict.contraction or 0.0))
        excess = {name: hidden * self._excess(numerics, finer) for name, finer in parts.items()}
        space = self._trial(parts["space"])
        most = max(excess.values())
        if most <= 1.0:  # each is within its share, but not all of them together
            excess = {name: 2.0 if value == most else value for name, value in excess.items()}
        if excess["time"] > 1.0:
            numerics = rules.more_time(numerics, excess["time"])
        if excess["nodes"] > 1.0:
            numerics = rules.more_nodes(numerics, excess["nodes"])
        if excess["space"] > 1.0 and space is not None:
            goal = SHARE / SAFETY * self._allowed[0] / hidden
            ways = {key: way / goal for key, way in space.top.items()}
            numerics = rules.more_space(numerics, ways, slow)
        return numerics

    def _excess(self, one: Numerics, other: Numerics) -> float:
        """Return the largest distance over the share that a part of the numerics has."""
        apart = self._apart(one, other)
        if apart is None:
            return float("inf")
        return float((apart[-1] / (SHARE / SAFETY * self._allowed)).max())

    def _apart(self, one: Numerics, other: Numerics) -> Floats | None:
        """Return the largest distances so far (looks, 2) of two runs; None without both."""
        runs = [self._trial(numerics) for numerics in (one, other)]
        if runs[0] is None or runs[1] is None:
            return None
        return distances(runs[0].poses, runs[1].poses, self._compiled)

    def _trial(self, numerics: Numerics) -> _Trial | None:
        """Make the run, or remember it; None if the solver gave up."""
        key = repr((numerics.integrator, numerics.options, numerics.rods))
        if key not in self._trials:
            share = self.work / self.limit
            self._say(f"run {len(self._trials) + 1}, {share:.0%} of the limit: {words(numerics)}")
            try:
                self._trials[key] = self._run(numerics)
            except SolverError as failure:
                self._trials[key] = failure
        result = self._trials[key]
        self.failure = result if isinstance(result, SolverError) else None
        return None if isinstance(result, SolverError) else result

    def _run(self, numerics: Numerics) -> _Trial:
        simulation = Simulation(
            replace(self._scene, numerics=replace(numerics, free=Free()), sensors=())
        )
        if self._drive is None:
            self._drive = probe(simulation).looking()
        self._compiled = simulation.compiled
        largest = np.zeros(simulation.n_coordinates)
        before, price = self.work, len(simulation.compiled.chain.segments) * (6.0 + len(largest))
        times: list[float] = []

        def see() -> None:
            np.maximum(largest, np.abs(simulation.q), out=largest)
            times.append(simulation.time)
            made = price * simulation.statistics().evaluations
            self.work = before + made + LOOK * len(times)
            if self.work > self.limit:
                raise Spent

        poses = self._drive.poses(simulation, see)
        self._times = np.array(times)
        return _Trial(poses, top_orders(simulation, largest))


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
