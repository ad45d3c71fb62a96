"""A load path that ends is followed again: by arc length, and with finer numerics.

A path may turn back at a limit point and reach the full load later. A model that is too coarse may
oscillate along the rod, buckle or fail where the arm would not. Only failures that finer numerics
confirm are called buckling.
"""

from __future__ import annotations

from dataclasses import replace

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.integrators.newton import INVERTED, LAWLESS, REASONS
from soft_sim_ros.core.mechanics.dynamics import Dynamics
from soft_sim_ros.errors import StaticsFailed

from .continuation import trace
from .load_path import whole_load
from .load_steps import End, Question, judge, newton, unresolved, walk

# Along the branch: most steps, and what n³ for every coordinate of n may add up to.
STEPS, WORK = 200, 6e8
LEVELS = 2  # how many times the numerics are made finer
MOST = 400  # coordinates of the finer model
SAME = 0.02  # of the share of the load at which two models end: they agree
# failures of the rod itself, not of its discretisation
ITSELF = (REASONS[INVERTED], REASONS[LAWLESS])


def look_again(question: Question, start: Floats, end: End) -> End:
    """Return the stable equilibrium under the full load that the path still leads to, if any.

    Parameters
    ----------
    start : (n,) where the path begins
    end : where it ended when the load grew step by step

    Raises
    ------
    StaticsFailed
        if there is none; it says whether the numerics are the cause, and what helps.
    """
    if end.why in ITSELF:
        raise StaticsFailed(end.share, end.size, question.time, end.why)
    beyond = _by_arc_length(question, end)
    if beyond is not None:
        judged = judge(question) if question.stable else None
        if judged is None or not judged.refused:
            return End(beyond, 1.0, 0.0, "", judged)
    found = _finer_end(question, start, end)
    why = end.why
    if found is not None and _further(found[1], end):
        why = _coarse(question, *found) + unresolved(question.dynamics, end.q)
    else:
        coarse = unresolved(question.dynamics, end.q)
        why += coarse or _advice(end, found is not None)
        if beyond is not None:
            why += "; stable=False takes the equilibrium under the full load all the same"
    raise StaticsFailed(end.share, end.size, question.time, why)


def _by_arc_length(question: Question, end: End) -> Floats | None:
    """Return the equilibrium under the full load at the other end of the branch, if there is one.

    The last residual is then that of this equilibrium.
    """
    if not question.mask.all():
        return None
    dynamics = question.dynamics
    path = whole_load(dynamics, question.efforts, question.time, question.tip, question.tip_follows)
    steps = int(min(STEPS, WORK / dynamics.n**3 + 10))
    last = trace(dynamics, path, end.q, end.share, within=(0.0, 1.0), steps=steps)
    if last is None or last[1] < 1.0:
        return None
    return newton(question, last[0], 1.0)[0]


def _finer_end(question: Question, start: Floats, end: End) -> tuple[Dynamics, End] | None:
    """Return a finer model, and where the same path ends with it; None if it would be too large."""
    from soft_sim_ros.core.refine.prolong import finer, prolong  # which compiles scenes

    found: tuple[Dynamics, End] | None = None
    coarse, q, mask = question.dynamics, start, question.mask
    for _ in range(LEVELS):
        if 2 * coarse.n > MOST:
            break
        fine = finer(coarse)
        q = prolong(coarse.compiled, fine.compiled, q)
        mask = prolong(coarse.compiled, fine.compiled, (~mask).astype(float)) == 0.0
        last = walk(replace(question, dynamics=fine, mask=mask), q)
        agrees = found is not None and not _further(last, found[1])
        if last.whole or found is None or _further(last, found[1]):
            found = fine, last
        if last.whole or agrees or not _further(last, end):
            break
        coarse = fine
    return found


def _further(one: End, other: End) -> bool:
    """Whether one path goes on clearly further than another."""
    return one.share > other.share + SAME * max(other.share, SAME)


def _coarse(question: Question, fine: Dynamics, last: End) -> str:
    words = []
    for name, basis in fine.compiled.scene.numerics.rods.items():
        orders = ", ".join(f"{strain} {order}" for strain, order in basis.order.items())
        nodes = "" if basis.nodes is None else f" and {basis.nodes} nodes"
        elements = f" in {basis.elements} elements" if basis.elements > 1 else ""
        words.append(f"orders {orders}{elements}{nodes} of {name}")
    share = "all" if last.whole else f"{last.share:.3g}"
    return (
        "the numerics are too coarse there, not the arm too weak: with "
        f"{'; '.join(words)} {share} of the load is reached: try more numerics.basis.order or "
        "elements, and nodes"
    )


def _advice(end: End, compared: bool) -> str:
    """Say what else can be done where the numerics are not to blame."""
    same = "; finer numerics say the same" if compared and end.verdict is not None else ""
    return same + "; core.continuation.follow shows the branch"
