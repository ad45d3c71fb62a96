"""Static equilibrium: Newton on the same residual, the load applied in steps that adapt."""

from __future__ import annotations

import numpy as np
import scipy

from ..errors import StaticsFailed
from .dynamics import Dynamics
from .kernels.newton import CONVERGED, REASONS, admissible
from .model import Floats
from .relaxation import sink
from .space_error import Forcing, tell_if_coarse

MIN_LOAD_STEP = 1e-6
WATCHED = 1500
# A series of strains whose last terms are this part of its largest does not show the shape.
ENDED = 0.1
SERIES = ("legendre", "chebyshev")
BENT = 1e-6  # 1/m: less curvature is round-off


def equilibrium(
    dynamics: Dynamics,
    q: Floats | None = None,
    *,
    efforts: Floats | None = None,
    time: float = 0.0,
    tip: Floats | None = None,
    tip_follows: bool = False,
    tolerance: float = 1e-12,
    iterations: int = 25,
    free: Floats | None = None,
    stable: bool = True,
    check: bool | None = None,
) -> Floats:
    """Return q (n,) with r(q, 0, 0) = 0.

    Parameters
    ----------
    q : (n,) start; the reference shape by default
    efforts : (A,) actuator efforts in scene order
    time : s at which scheduled loads are taken
    tip : (6,) moment and force at the tip along world axes, or (``tip_follows``) those of the tip
    tolerance : largest last correction, as a displacement of the tip in arm lengths
    iterations : Newton steps allowed for one load step
    free : (n,) bool, coordinates to be found; the others keep their start value
    stable : whether only stable equilibria will do
    check : whether to ask a finer basis how far off the tip is, and to warn; by default, where the
        scene's author wrote no basis. It costs about as much as the solution, and once per arm the
        compilation of a finer one: False for loops

    Warns
    -----
    NotResolved
        if basis and nodes are too coarse for this state (space_error.py)

    Raises
    ------
    StaticsFailed
        if the load path cannot be followed to the full load.

    Notes
    -----
    Weight, loads and efforts grow together from zero to their full size along the path of
    equilibria that starts at q, so of several equilibria the one on the load path is found. A limit
    point ends it, and so does (``stable``) the loss of static stability, as in buckling: it is
    looked for after every load step, up to WATCHED coordinates. An arm with a string or a cable in
    it has no such path, since only its load holds it: it sinks into a stable equilibrium under the
    full load (relaxation.py).
    """
    n = dynamics.n
    state = np.zeros(n) if q is None else dynamics.coordinates(q).copy()
    mask = np.ones(n, dtype=bool) if free is None else np.asarray(free, dtype=bool)
    if mask.shape != (n,):
        raise ValueError(f"free must be {n} truth values, not {free!r}")
    if not mask.any():
        return state
    reached, step = 0.0, 1.0
    previous: tuple[float, Floats] | None = None
    if any(m.pivot for m in dynamics.compiled.chain.rods.values()):
        state = sink(dynamics, state, mask, (efforts, time, 1.0, tip, tip_follows), time)
    while reached < 1.0:
        share = min(1.0, reached + step)
        guess = state.copy()
        if previous is not None and reached > previous[0]:
            guess += (share - reached) / (reached - previous[0]) * (state - previous[1])
        found, size, why = _newton(
            dynamics, guess, mask, (efforts, time, share, tip, tip_follows), tolerance, iterations
        )
        if found is not None and stable and not _is_stable(dynamics, mask):
            found, why = None, "it loses stability there: the arm buckles or tips over"
        if found is None:
            step *= 0.25
            if step < MIN_LOAD_STEP:
                raise StaticsFailed(reached, size, time, why + _unresolved(dynamics, state))
            continue
        previous = (reached, state)
        reached, state = share, found
        step *= 2.0
    if check or (check is None and not dynamics.compiled.scene.numerics.space_written):
        tell_if_coarse(dynamics, state, Forcing(efforts, time, 1.0, tip, tip_follows), mask)
    return state


def _unresolved(dynamics: Dynamics, q: Floats) -> str:
    """Return a warning if the basis does not resolve the bending of the arm at q, else nothing.

    A thin, heavy rod bends within (EI / weight per length)^(1/3) of its clamp. Polynomials that
    cannot, wind to and fro instead, and that is unstable, or leads nowhere.
    """
    worst, where = ENDED, ""
    for rod in dynamics.compiled.chain.rods.values():
        for element in rod.elements:
            for component, first, count in element.columns:
                terms = np.abs(q[first : first + count])
                if element.basis.kind not in SERIES or component > 2 or count < 3:
                    continue
                share = float(terms[-2:].max() / terms.max()) if terms.max() > BENT else 0.0
                if share > worst:
                    worst, where = share, dynamics.compiled.coordinate_names[first]
    if not where:
        return ""
    return (
        f"; its basis does not show the shape: the last terms of {where.rpartition('/')[0]} are "
        f"{worst:.2g} of the largest, so a thin rod may bend within less than an element: try "
        "more numerics.basis.elements or a higher order"
    )


def _is_stable(dynamics: Dynamics, mask: np.ndarray) -> bool:
    """Return whether the equilibrium of the last residual is stable, as far as it is watched."""
    return int(np.count_nonzero(mask)) > WATCHED or unstable_directions(dynamics, mask) == 0


def unstable_directions(dynamics: Dynamics, mask: np.ndarray | None = None) -> int:
    """Return in how many ways the arm leaves the equilibrium of the last residual, not swinging.

    That is, the number of real negative λ of K x = λ M x, for the coordinates in ``mask``. K of
    follower loads is not symmetric; then some λ may be complex, which is flutter or its damped
    form, a matter of dynamics.
    """
    mask = np.ones(dynamics.n, dtype=bool) if mask is None else mask
    scale = 1.0 / dynamics.model.weight[mask]
    stiffness, mass = (
        dynamics.last_tangent(alpha)[np.ix_(mask, mask)] * np.outer(scale, scale)
        for alpha in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    )
    size = np.abs(stiffness).max()
    if np.abs(stiffness - stiffness.T).max() < 1e-9 * size:
        lowest = np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))
        return int(np.count_nonzero(lowest < -1e-10 * size))
    values = scipy.linalg.eig(stiffness, mass, right=False)
    real = np.abs(values.imag) <= 1e-6 * np.abs(values)
    return int(np.count_nonzero(values.real[real] < -1e-10 * np.abs(values).max()))


def _newton(
    dynamics: Dynamics,
    q: Floats,
    mask: np.ndarray,
    forcing: tuple,
    tolerance: float,
    iterations: int,
) -> tuple[Floats | None, float, str]:
    """Return (equilibrium or None, last correction in arm lengths, what went wrong)."""
    zero = np.zeros(len(q))
    weight = dynamics.model.weight
    size, first = np.inf, np.inf
    q = q.copy()
    for iteration in range(iterations):
        data = dynamics.forcing(*forcing)
        residual = dynamics.residual(q, zero, zero, data)
        matrix = dynamics.last_tangent((1.0, 0.0, 0.0))
        if not (np.isfinite(residual).all() and np.isfinite(matrix).all()):
            return None, np.inf, "it is not finite"
        try:
            step = np.linalg.solve(matrix[np.ix_(mask, mask)], residual[mask])
        except np.linalg.LinAlgError:
            return None, np.inf, "nothing holds the arm there: its stiffness is singular"
        q[mask] -= step
        size = float(np.max(np.abs(step) * weight[mask]))
        if size <= tolerance:
            dynamics.residual(q, zero, zero, data)
            status = admissible(dynamics.model, data)
            return (q, size, "") if status == CONVERGED else (None, size, REASONS[status])
        if iteration == 0:
            first = size
        # a first correction of many arm lengths, or growth: the step along the path was too long
        if not np.isfinite(size) or size > 4.0 * max(first, 0.1) or first > 3.0:
            return None, size, ""
    return None, size, ""
