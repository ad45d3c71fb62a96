"""Parameters of a model from a recorded motion: least squares, with confidence intervals.

In x = log(p / p₀) for p₀ > 0, else x = p / |p₀| + 1, the sum of squares of measured − predicted(x)
is minimised by Gauss–Newton steps within a trust region. With J = ∂predicted/∂x and σ² the variance
of the residuals, the covariance of x is σ² (JᵀJ)⁻¹. Directions along which it is large or infinite
are reported as not determined by the data.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from soft_sim_ros.core.arguments import real
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import SolverError

STEP = 1e-3  # of x, in central differences: errors of 1e-6, far above the noise of the solver
FARTHEST = np.log(1e4)  # parameters stay within this factor of where they started
# Regularisation, relative to the largest singular value, of directions that the data do not
# determine or (while only the first instants are fitted) determine badly.
PRIOR, STAGE_PRIOR = 1e-6, 1e-2
STAGES = (32, 16, 8, 4, 2)
BLIND = 1e-4  # of the largest singular value: below it a direction is lost in the differences
LEAST = 10  # measurements per parameter with which a part of the time is worth a fit

Predict = Callable[[Floats, int], Floats]


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters, and how well the data determine them.

    Parameters
    ----------
    names : (p,)
    values : (p,) estimates
    intervals : (p, 2) confidence intervals; 0 or −∞ to ∞ where the data do not determine them
    confidence : their probability, if the model is right and its errors are independent
    correlation : (p, p) of the estimates
    unknown : directions (p,) in x along which the data say too little: a change of x by one, a
        factor e, is within the interval
    rms : root mean square of the residuals, in units of the data
    observations : how many numbers were fitted
    evaluations : how many predictions were made
    """

    names: tuple[str, ...]
    values: Floats
    intervals: Floats
    confidence: float
    correlation: Floats
    unknown: tuple[Floats, ...]
    rms: float
    observations: int
    evaluations: int

    def warnings(self) -> list[str]:
        """Return a message on parameters that the data do not determine."""
        told = []
        for direction in self.unknown:
            order = np.argsort(-np.abs(direction))
            terms = [
                f"{direction[i]:+.2f} {self.names[i]}" for i in order if abs(direction[i]) > 0.05
            ]
            what = "cannot be told" if len(terms) == 1 else "cannot be told apart along"
            told.append(f"{what}: {', '.join(terms)} (in logarithms)")
        return told


class _Problem:
    """Predictions of the first instants as a function of x, counted."""

    def __init__(self, predict: Predict, start: Floats, measured: Floats) -> None:
        self.predict, self.start = predict, start
        self.logarithmic = start > 0.0
        self.count = 0
        self.seen = np.isfinite(measured)
        self.measured = np.where(self.seen, measured, 0.0)
        self.instants = len(measured)

    def values(self, x: Floats) -> Floats:
        grown = self.start * np.exp(np.where(self.logarithmic, x, 0.0))
        return np.where(self.logarithmic, grown, self.start * (1.0 - x))

    def left(self, x: Floats) -> Floats:
        """Return predicted − measured over time, zero where nothing was measured."""
        self.count += 1
        predicted = real("predict", self.predict(self.values(x), self.instants))
        measured = self.measured[: self.instants]
        if predicted.shape != measured.shape:  # numpy would spread one over the other
            raise ValueError(f"predicted are {predicted.shape} numbers, measured {measured.shape}")
        error = predicted - measured
        return np.where(self.seen[: self.instants], error, 0.0)

    def error(self, x: Floats) -> Floats:
        """Return the same as one vector; NaN where the model cannot be solved: a step too far."""
        seen = self.seen[: self.instants]
        try:
            return self.left(x)[seen]
        except SolverError:
            return np.full(np.count_nonzero(seen), np.nan)

    def slope(self, x: Floats) -> Floats:
        """Return J by central differences, one-sided where one side cannot be solved."""
        columns = []
        for unit in np.eye(len(x)):
            ahead, behind = self.error(x + STEP * unit), self.error(x - STEP * unit)
            width = 2.0 * STEP
            if np.isnan(ahead).any() or np.isnan(behind).any():
                here, width = self.error(x), STEP
                ahead, behind = (here, behind) if np.isnan(ahead).any() else (ahead, here)
            columns.append((ahead - behind) / width)
        return np.stack(columns, axis=1)

    def solve(self, x: Floats, instants: int, tolerance: float, prior: float) -> Floats:
        """Return x that fits the first instants best, near x.

        Directions with less than ``prior`` of the largest effect on the prediction are held.
        """
        self.instants = instants
        hold = prior * np.linalg.norm(self.slope(x), 2) * np.eye(len(x))
        solution = least_squares(
            lambda y: np.concatenate([self.error(y), hold @ (y - x)]),
            x,
            jac=lambda y: np.vstack([self.slope(y), hold]),
            bounds=(np.full(len(x), -FARTHEST), np.full(len(x), FARTHEST)),
            xtol=tolerance,
            ftol=tolerance,
            gtol=1e-14,
            max_nfev=100,
        )
        return np.asarray(solution.x, dtype=float)


def fit(
    names: Sequence[str],
    start: Floats,
    predict: Predict,
    measured: Floats,
    *,
    confidence: float = 0.95,
    tolerance: float = 1e-7,
) -> Fit:
    """Return the parameters that predict the measurements best.

    Parameters
    ----------
    names : (p,)
    start : (p,) first guesses, not zero; those above zero stay above zero
    predict : values (p,), k → what they predict for the first k instants, (k, …). A SolverError
        means that these values cannot be simulated
    measured : (T, …) over time; NaN where nothing was measured
    confidence : probability of the intervals
    tolerance : relative change of x, and of the sum of squares, at which to stop

    Raises
    ------
    ValueError
        if there are not more measurements than parameters, a first guess is zero or not finite,
        or predictions are not of the shape of the measurements.
    SolverError
        if not even the first guesses can be simulated.

    Notes
    -----
    The beginning is fitted first, then twice that time, and so on: swinging motion fitted as a
    whole from a poor guess would lock on a wrong number of swings.

    The intervals treat the residuals as noise, of equal size everywhere. Noise that lasts from
    one instant to the next (autocorrelation ρ > 0 at the lag of one) counts (1 + ρ)/(1 − ρ) times.
    """
    start, measured = real("start", start).copy(), real("measured", measured)
    problem = _Problem(predict, start, measured)
    count = int(np.count_nonzero(problem.seen))
    if start.shape != (len(names),) or not np.isfinite(start).all():
        raise ValueError(f"{len(names)} finite first guesses are needed, not {start}")
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence must be between 0 and 1, not {confidence!r}")
    if not (start != 0.0).all():
        raise ValueError(f"first guesses must not be zero, they are {start}: it sets the scale")
    if count <= len(start):
        raise ValueError(f"{count} measurements for {len(start)} parameters")
    x = np.zeros(len(start))
    for part in STAGES:
        instants = len(measured) // part
        if np.count_nonzero(problem.seen[:instants]) >= LEAST * len(start):
            problem.instants = instants
            problem.left(x)  # raises what is wrong with a first guess
            x = problem.solve(x, instants, 1e-3, STAGE_PRIOR)
    problem.instants = len(measured)
    problem.left(x)
    x = problem.solve(x, len(measured), tolerance, PRIOR)
    left = problem.left(x)
    freedom = count - len(start)
    variance = float(np.sum(left**2)) / freedom * _lasting(left)
    quantile = float(student.ppf(0.5 + 0.5 * confidence, freedom))
    columns, sizes, rows = np.linalg.svd(problem.slope(x), full_matrices=False)
    known = (sizes > BLIND * sizes[0]) & (quantile * np.sqrt(variance) < sizes)
    # the change by one more step counts as uncertainty too, for any noise (twice, to include the
    # steps after it)
    more = rows[known].T @ ((columns[:, known].T @ left[problem.seen]) / sizes[known])
    spread = (rows[known].T / sizes[known]) * np.sqrt(variance)  # covariance = spread spreadᵀ
    deviation = np.sqrt((spread**2).sum(axis=1))
    deviation[(np.abs(rows[~known]) > 0.05).any(axis=0)] = np.inf
    covariance = (rows.T / np.maximum(sizes, 1e-8 * sizes[0] + 1e-150) ** 2) @ rows
    scale = np.sqrt(np.diag(covariance))
    width = quantile * deviation + 2.0 * np.abs(more)
    ends = [np.clip(x + sign * width, -700.0, 700.0) for sign in (-1.0, 1.0)]
    intervals = np.sort(np.stack([problem.values(end) for end in ends], axis=1), axis=1)
    lost = np.isinf(deviation)
    intervals[lost, 0] = np.where(problem.logarithmic, 0.0, -np.inf)[lost]
    intervals[lost, 1] = np.inf
    return Fit(
        names=tuple(names),
        values=problem.values(x),
        intervals=intervals,
        confidence=confidence,
        correlation=covariance / np.outer(scale, scale),
        unknown=tuple(rows[~known]),
        rms=float(np.sqrt(np.sum(left**2) / count)),
        observations=count,
        evaluations=problem.count,
    )


def _lasting(left: Floats) -> float:
    """Return the factor by which autocorrelated noise increases the variance of a mean."""
    series = left.reshape(len(left), -1)
    total = float(np.sum(series * series))
    if len(series) < 3 or total == 0.0:
        return 1.0
    rho = float(np.sum(series[1:] * series[:-1])) / total
    return max(1.0, (1.0 + rho) / max(1.0 - rho, 1e-3))
