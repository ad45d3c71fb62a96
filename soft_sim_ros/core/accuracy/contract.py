"""The accuracy contract: a scene names a tolerance, the solver chooses how to meet it.

Whatever the scene leaves open is chosen: the error of the integrator's steps, and for every rod its
elements, the order of every strain and the number of nodes. A run is made with a choice and with a
finer *companion*: a tenth of the error of a step, two more orders, half as many segments again.
Where they differ by more than the tolerance, each of the three is refined alone, which shows whose
the error is, and the choice is refined there. Where they agree, a third run that is finer still,
with elements cut in two, shows how much better than the run its companion is: with that comes the
estimate (convergence.py), of the error of the motion against the continuum, not a sum of
local errors. Runs are compared at every step of the scene, independent of the publish rate.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from soft_sim_ros.core.refine.refinement import Refinement, source_with, words
from soft_sim_ros.errors import SearchSpent, ToleranceMissed
from soft_sim_ros.scene import Free, Scene

from .convergence import SLOWEST, accuracy, factor
from .drive import Drive
from .search import LIMIT, Search, Spent, Verdict

# The search gives up after this many refinements, or this many in a row that gain less than a
# factor GAIN: undamped motion may be sensitive to every refinement.
ROUNDS, PATIENCE, GAIN = 12, 3, 1.5
# Tips this far apart (over the length) are unrelated. A choice is then judged by how much longer it
# stays within the tolerance than the one before, once it does so for a part SEEN of the run.
LOST, SEEN = 0.1, 0.02


@dataclass(frozen=True)
class Choice:
    """Numerics that meet a tolerance, and their estimated errors.

    scene : the scene with complete numerics, also in its source
    estimate : of the tip's largest error in the drive, over the length
    rounds : how often the choice was refined
    angle : estimate of the largest error of the tip's orientation in rad
    contraction : of the distances from one companion to the next
    """

    scene: Scene
    estimate: float
    rounds: int
    angle: float
    contraction: float

    def accuracy(self) -> dict[str, float]:
        """Return tolerances and estimates by their keys in summary.json."""
        numerics = self.scene.numerics
        tolerance = numerics.tolerance or float("inf")
        return accuracy(tolerance, self.estimate, numerics.orientation, self.angle)


def draft(scene: Scene) -> Scene:
    """Return a scene completed by a first guess; it needs the same kernels."""
    tolerance = scene.numerics.tolerance
    if not scene.numerics.free:
        return scene
    if tolerance is None:
        from .unwritten import first_guess  # it imports this module

        return first_guess(scene)
    return replace(scene, numerics=replace(Refinement(scene, tolerance).first(), free=Free()))


def settle(scene: Scene, say: Callable[[str], None] = lambda text: None) -> Scene:
    """Return a scene in which nothing is left free, chosen by a probe where something was.

    Parameters
    ----------
    scene : the scene; returned as it is if its numerics leave nothing free
    say : told in words what is tried
    """
    if scene.numerics.free and scene.numerics.tolerance is None:
        from .unwritten import settle_unwritten  # it imports this module

        return settle_unwritten(scene).scene
    return choose(scene, say=say).scene if scene.numerics.free else scene


def choose(
    scene: Scene,
    drive: Drive | None = None,
    say: Callable[[str], None] = lambda text: None,
    limit: float = LIMIT,
) -> Choice:
    """Choose the numerics that a scene with a tolerance leaves open.

    Parameters
    ----------
    scene : with ``numerics.tolerance``
    drive : the run to be made; None: a test run, since commands are not known beforehand
    say : receives messages about the search
    limit : of the work of all runs that are made (search.py)

    Raises
    ------
    ToleranceMissed
        if the finest choice that makes sense, or what the scene fixes, does not meet it
    SearchSpent
        if the limit is reached before
    SolverError
        if the solver gives up, however fine the choice
    """
    if scene.numerics.tolerance is None:
        raise ValueError(f"{scene.name} has no numerics.tolerance")
    search = Search(scene, drive, say, limit)
    found: list[Verdict] = []
    try:
        if (choice := _look(search, scene, found, say)) is not None:
            return choice
    except Spent:
        raise SearchSpent(*_missed(scene, found), search.limit) from None
    if search.failure is not None:
        raise search.failure
    raise ToleranceMissed(*_missed(scene, found))


def _look(
    search: Search, scene: Scene, found: list[Verdict], say: Callable[[str], None]
) -> Choice | None:
    """Refine until the tolerance is met, or give up; ``found`` collects the trials."""
    numerics, excess, stuck, lost = search.rules.first(), float("inf"), 0, 0
    for rounds in range(ROUNDS):
        before = excess
        verdict = search.judge(numerics)
        lost = lost + 1 if found and _hopeless(found[-1], verdict, ROUNDS - 1 - rounds) else 0
        if verdict.excess <= 1.0:
            verdict = search.judge(numerics, thoroughly=True)
        found.append(verdict)
        say(f"{words(numerics)}: estimate {verdict.error:.2g} for {scene.numerics.tolerance:g}")
        if verdict.excess <= 1.0:
            return _choice(scene, verdict, rounds)
        excess = verdict.excess
        stuck = stuck + 1 if excess > before / GAIN else 0
        if stuck == PATIENCE or lost == 2:
            return None
        refined = search.refined(verdict, slow=stuck > 0)
        if refined == numerics:
            return None
        numerics = refined
    return None


def _hopeless(before: Verdict, now: Verdict, left: int) -> bool:
    """Whether the refinements that are left do not reach the end of the run, at this pace."""
    if min(before.error, now.error) < LOST or not np.isfinite(before.error + now.error):
        return False
    if before.holds < SEEN * now.end:  # too coarse to tell
        return False
    return now.holds + left * max(0.0, now.holds - before.holds) < now.end


def _choice(scene: Scene, verdict: Verdict, rounds: int) -> Choice:
    ratio = SLOWEST if verdict.contraction is None else verdict.contraction
    fixed = replace(verdict.numerics, free=Free(), trust=factor(ratio))
    chosen = replace(scene, numerics=fixed, source=source_with(scene, fixed))
    return Choice(chosen, verdict.error, rounds, verdict.angle, ratio)


def _missed(scene: Scene, found: list[Verdict]) -> tuple[str, float, float, str, float]:
    """Return the message of an error, about the choice that holds for the longest time."""
    tolerance = scene.numerics.tolerance or 0.0
    if not found:
        first = Refinement(scene, tolerance).first()
        return scene.file, tolerance, float("inf"), words(first), 0.0
    best = max(found, key=lambda verdict: (verdict.holds, -verdict.excess))
    finest = words(best.numerics)
    return scene.file, tolerance, best.error, finest, best.holds
