"""Equilibria along a growing load: Newton on the residual, the load applied in steps that adapt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.integrators.newton import CONVERGED, REASONS, admissible
from soft_sim_ros.core.mechanics.blocks import Blocks
from soft_sim_ros.core.mechanics.closing import MET, Closing
from soft_sim_ros.core.mechanics.dynamics import Dynamics

from .stability import Verdict, verdict

# Of the load reached, and of the whole: a slender rod under tension bends under the least of it.
MIN_LOAD_STEP, LEAST_LOAD_STEP = 1e-6, 1e-15
MOST_TRIES = 300
STUCK = 1e-10  # arm lengths: with constraints, corrections no longer than this may end in round-off
# A series of strains whose last terms are this part of its largest does not show the shape.
ENDED = 0.1
SERIES = ("legendre", "chebyshev")
BENT = 1e-6  # times the length: less curvature is round-off
BUCKLES = "it loses stability there: the arm buckles or tips over"


@dataclass(frozen=True, eq=False)
class Question:
    """Which equilibrium is looked for; see ``statics.equilibrium``."""

    dynamics: Dynamics
    mask: np.ndarray  # (n,) bool, coordinates to be found
    efforts: Floats | None
    time: float
    tip: Floats | None
    tip_follows: bool
    tolerance: float
    iterations: int
    stable: bool
    closing: Closing | None = None

    def forcing(self, share: float) -> tuple:
        """Return the arguments of ``Dynamics.forcing`` at a share of the load."""
        return self.efforts, self.time, share, self.tip, self.tip_follows


class End(NamedTuple):
    """How far a load path was walked.

    Attributes
    ----------
    q : (n,) the last equilibrium
    share : of the load there; 1 is the end of the path
    size : last correction of the last attempt beyond, arm lengths
    why : what went wrong there, never empty where share < 1
    verdict : of the equilibrium under the whole load, or of the one beyond that was refused
    """

    q: Floats
    share: float
    size: float
    why: str
    verdict: Verdict | None = None

    @property
    def whole(self) -> bool:
        """Whether the whole load was applied."""
        return self.share >= 1.0


def walk(question: Question, q: Floats) -> End:
    """Return how far the load can grow from nothing, setting out from q (n,)."""
    reached, step, state = 0.0, 1.0, q.copy()
    previous: tuple[float, Floats] | None = None
    last: Verdict | None = None
    tries = 0
    while reached < 1.0:
        tries += 1
        share = min(1.0, reached + step)
        guess = state.copy()
        if previous is not None and reached > previous[0]:
            guess += (share - reached) / (reached - previous[0]) * (state - previous[1])
        kept = None if question.closing is None else question.closing.multipliers.copy()
        found, size, why = newton(question, guess, share)
        judged = None
        if found is not None and question.stable:
            judged = judge(question)
            if judged.refused:
                found, why = None, in_words(judged)
                _back(question.closing, kept, size, why)
        if found is None:
            step *= 0.25
            if tries >= MOST_TRIES:
                why = f"{why}; {tries} steps along the load path have been tried"
            if tries >= MOST_TRIES or step < max(MIN_LOAD_STEP * reached, LEAST_LOAD_STEP):
                return End(state, reached, size, why, judged)
            continue
        previous = (reached, state)
        reached, state, last = share, found, judged
        step *= 2.0
    return End(state, 1.0, 0.0, "", last)


def judge(question: Question) -> Verdict:
    """Return the verdict on the equilibrium of the last residual, as far as it is watched."""
    return verdict(question.dynamics, question.mask, question.time)


def in_words(judged: Verdict) -> str:
    """Say how an equilibrium is left."""
    if not judged.flutters:
        return BUCKLES
    return (
        f"it loses stability there: it flutters, a swing of {judged.hertz:.3g} Hz grows by "
        f"{judged.growth:.3g} 1/s under moments or loads that follow the arm"
    )


def newton(question: Question, q: Floats, share: float) -> tuple[Floats | None, float, str]:
    """Return (equilibrium or None, last correction in arm lengths, what went wrong)."""
    dynamics, mask, closing = question.dynamics, question.mask, question.closing
    rates, accelerations = dynamics.guided(question.time)[1:]
    weight = dynamics.model.weight
    size, first, before = np.inf, np.inf, np.inf
    q = q.copy()
    own = np.ix_(mask, mask)
    blocks = Blocks(dynamics, mask) if Blocks.serve(dynamics, mask) else None
    implied, kept = 0.0, None if closing is None else closing.multipliers.copy()
    for iteration in range(question.iterations):
        data = dynamics.forcing(*question.forcing(share))
        if closing is not None:
            closing.at(share)
            closing.push()
        residual = dynamics.residual(q, rates, accelerations, data)
        try:
            if blocks is not None:
                step = _by_blocks(blocks, residual)
            else:
                matrix = _finite(dynamics.last_tangent((1.0, 0.0, 0.0)))[own]
                if closing is None:
                    step = np.linalg.solve(matrix, _finite(residual)[mask])
                else:
                    step, implied = closing.step(matrix, _finite(residual)[mask], mask, share)
        except FloatingPointError as error:
            return _back(closing, kept, np.inf, str(error))
        except np.linalg.LinAlgError:
            why = "nothing holds the arm there: its stiffness is singular"
            return _back(closing, kept, np.inf, why)
        q[mask] -= step
        size = float(np.max(np.abs(step) * weight[mask]))
        # round-off of what holds and what is held, which may differ by many orders of magnitude
        stuck = closing is not None and size <= STUCK and size > 0.3 * before
        if size <= question.tolerance or stuck:
            if closing is not None and implied > MET:
                return _back(closing, kept, size, str(closing.contradicted()))
            if closing is not None:
                closing.push()
            dynamics.residual(q, rates, accelerations, data)
            status = admissible(dynamics.model, data)
            if status == CONVERGED:
                return q, size, ""
            why = REASONS[status]
            return _back(closing, kept, size, why)
        if iteration == 0:
            first = size
        before = size
        # a first correction of many arm lengths, or growth: the step along the path was too long
        if not np.isfinite(size) or size > 4.0 * max(first, 0.1) or first > 3.0:
            break
    why = (
        "Newton's method finds no equilibrium near the last one, its last correction is "
        f"{size:.3g} arm lengths: the load may have its largest value there, and the arm snaps"
    )
    return _back(closing, kept, size, why)


def _finite(values: Floats) -> Floats:
    if not np.isfinite(values).all():
        raise FloatingPointError("it is not finite")
    return values


def _by_blocks(blocks: Blocks, residual: Floats) -> Floats:
    """Return K⁻¹ r of the coordinates that are looked for, at linear cost."""
    _finite(residual)
    blocks.fill((1.0, 0.0, 0.0))
    _finite(blocks.diagonal)
    if not blocks.factor():
        raise np.linalg.LinAlgError("singular")
    return blocks.solve(residual)[blocks.mask]


def _back(
    closing: Closing | None, kept: Floats | None, size: float, why: str
) -> tuple[None, float, str]:
    """Put multipliers back to those before a failed attempt; return what ``newton`` does."""
    if closing is not None and kept is not None:
        closing.multipliers[:] = kept
    return None, size, why


def unresolved(dynamics: Dynamics, q: Floats) -> str:
    """Return a warning if the basis does not resolve the bending of the arm at q, else nothing.

    A thin, heavy rod bends within (EI / weight per length)^(1/3) of its clamp. Polynomials that
    cannot, wind to and fro instead, and that is unstable, or leads nowhere.
    """
    worst, where = ENDED, ""
    bent = BENT / dynamics.compiled.length
    for rod in dynamics.compiled.chain.rods.values():
        for element in rod.elements:
            for component, first, count in element.columns:
                terms = np.abs(q[first : first + count])
                if element.basis.kind not in SERIES or component > 2 or count < 3:
                    continue
                share = float(terms[-2:].max() / terms.max()) if terms.max() > bent else 0.0
                if share > worst:
                    worst, where = share, dynamics.compiled.coordinate_names[first]
    if not where:
        return ""
    return (
        f"; its basis does not show the shape: the last terms of {where.rpartition('/')[0]} are "
        f"{worst:.2g} of the largest, so a thin rod may bend within less than an element: try "
        "more numerics.basis.elements or a higher order"
    )
