"""The estimator against linear theory, and its intervals against how often they are right."""

import numpy as np
import pytest
from scipy.stats import t as student

from soft_sim_ros.core.analysis.identification import fit
from soft_sim_ros.errors import Diverged

TIME = np.linspace(0.0, 3.0, 61)


def decay(values, instants=None):
    amplitude, rate = values
    return amplitude * np.exp(-rate * TIME[:instants])


def test_without_noise_the_parameters_come_back():
    found = fit(["a", "b"], [1.0, 1.0], decay, decay([3.0, 0.7]))
    np.testing.assert_allclose(found.values, [3.0, 0.7], rtol=1e-8)
    assert found.rms < 1e-7
    low, high = found.intervals.T
    assert (low <= [3.0, 0.7]).all() and (high >= [3.0, 0.7]).all()
    assert not found.unknown and not found.warnings()


def test_without_noise_the_intervals_hold_what_the_search_left_over():
    """Two rates that are hard to tell apart, and a search that stops early."""

    def predict(values, instants):
        return np.exp(-values[0] * TIME[:instants]) + np.exp(-values[1] * TIME[:instants])

    truth = np.array([1.0, 1.1])
    found = fit(["a", "b"], [0.8, 1.5], predict, predict(truth, None), tolerance=1e-4)
    low, high = found.intervals.T
    assert (low <= truth).all() and (truth <= high).all()
    assert (high / low < 1.2).all()


def test_intervals_are_those_of_linear_regression():
    """p₀ + p₁ t with white noise, as in any textbook; in logarithms they are only a little bent."""
    rng = np.random.default_rng(1)
    data = 5.0 + 2.0 * TIME + 1e-3 * rng.normal(size=TIME.shape)
    found = fit(
        ["level", "slope"], [4.0, 3.0], lambda p, k: p[0] + p[1] * TIME[:k], data, confidence=0.9
    )
    design = np.stack([np.ones_like(TIME), TIME], axis=1)
    best, left = np.linalg.lstsq(design, data, rcond=None)[:2]
    freedom = len(TIME) - 2
    covariance = left[0] / freedom * np.linalg.inv(design.T @ design)
    half = student.ppf(0.95, freedom) * np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(found.values, best, rtol=1e-9)
    inflation = np.ptp(found.intervals, axis=1) / (2 * half)
    series = data - design @ best
    rho = max(0.0, series[1:] @ series[:-1] / (series @ series))
    np.testing.assert_allclose(inflation, np.sqrt((1 + rho) / (1 - rho)), rtol=1e-3)
    correlation = covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    assert found.correlation[0, 1] == pytest.approx(correlation, abs=1e-3)


def coverage(noise, runs=300):
    """How often the 80 % interval of the rate holds it."""
    truth = np.array([3.0, 0.7])
    rng = np.random.default_rng(2)
    inside = 0
    for _ in range(runs):
        found = fit(["a", "b"], [2.0, 1.0], decay, decay(truth) + noise(rng), confidence=0.8)
        low, high = found.intervals[1]
        inside += low <= truth[1] <= high
    return inside / runs


def test_intervals_are_right_as_often_as_they_say():
    share = coverage(lambda rng: 0.05 * rng.normal(size=TIME.shape))
    assert abs(share - 0.8) < 3 * np.sqrt(0.8 * 0.2 / 300)


def test_noise_that_lasts_makes_them_wider():
    def noise(rng):
        white = 0.05 * rng.normal(size=TIME.shape)
        for i in range(1, len(white)):
            white[i] += 0.7 * white[i - 1]
        return white

    # as white noise it would be right in about half of the cases only
    assert coverage(noise) > 0.7


def test_what_only_a_product_shows_is_named_and_not_believed():
    found = fit(
        ["a", "b", "c"], [2.0, 1.0, 1.0], lambda p, k: p[0] * p[1] * np.exp(-p[2] * TIME[:k]),
        6.0 * np.exp(-0.5 * TIME) + 1e-3 * np.random.default_rng(3).normal(size=TIME.shape),
    )  # fmt: skip
    (direction,) = found.unknown
    np.testing.assert_allclose(np.abs(direction), [0.5**0.5, 0.5**0.5, 0.0], atol=1e-3)
    assert direction[0] * direction[1] < 0.0
    assert found.values[0] * found.values[1] == pytest.approx(6.0, rel=1e-3)
    assert found.values[2] == pytest.approx(0.5, rel=1e-3)
    # the combination nobody sees stays where it was, and the intervals of a and b say so
    assert found.values[0] / found.values[1] == pytest.approx(2.0, rel=1e-3)
    assert np.isinf(found.intervals[:2, 1]).all() and (found.intervals[:2, 0] == 0.0).all()
    assert np.isfinite(found.intervals[2]).all()
    (told,) = found.warnings()
    assert told.startswith("cannot be told apart along: ") and " a" in told and " b" in told


def test_a_parameter_without_effect_is_named():
    found = fit(["a", "idle"], [2.0, 5.0], lambda p, k: p[0] * TIME[:k], 3.0 * TIME)
    assert found.values[1] == pytest.approx(5.0, rel=1e-6)
    assert found.warnings()[0].startswith("cannot be told: ")


def test_a_prediction_that_fails_is_a_step_too_far():
    def predict(values, instants):
        if values[0] > 1.05:
            raise Diverged(0.0, "too stiff")
        return values[0] * TIME[:instants]

    found = fit(["a"], [0.1], predict, 1.0 * TIME)
    assert found.values[0] == pytest.approx(1.0, rel=1e-6)
    with pytest.raises(Diverged):
        fit(["a"], [2.0], predict, 1.0 * TIME)


def test_what_was_not_measured_does_not_count():
    data = decay([3.0, 0.7])
    data[10:20] = np.nan
    found = fit(["a", "b"], [1.0, 1.0], decay, data)
    np.testing.assert_allclose(found.values, [3.0, 0.7], rtol=1e-7)
    assert found.observations == 51


def test_a_negative_parameter_stays_free_and_zero_is_no_first_guess():
    found = fit(["a"], [-2.0], lambda p, k: p[0] * TIME[:k], 1.5 * TIME)
    assert found.values[0] == pytest.approx(1.5)
    with pytest.raises(ValueError, match="must not be zero"):
        fit(["a"], [0.0], lambda p, k: p[0] * TIME[:k], TIME)
    with pytest.raises(ValueError, match="1 measurements for 1 parameters"):
        fit(["a"], [1.0], lambda p, k: p[0] * TIME[:k], TIME[:1])


def test_a_swing_is_not_counted_wrongly_from_a_poor_guess():
    """Over 20 swings a frequency 30 % off would lock on a wrong number of them."""
    time = np.linspace(0.0, 20.0, 801)

    def swing(values, instants):
        return np.cos(2 * np.pi * values[0] * time[:instants])

    found = fit(["hertz"], [0.7], swing, swing([1.0], len(time)))
    assert found.values[0] == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize(
    ("start", "data", "options", "told"),
    [
        ([1.0], TIME[:, None], {}, r"predicted are \(\d+,\) numbers, measured \(\d+, 1\)"),
        ([1.0], TIME, {"confidence": 1.5}, "confidence must be between 0 and 1, not 1.5"),
        ([1.0, 2.0], TIME, {}, "1 finite first guesses are needed"),
        ([np.nan], TIME, {}, "1 finite first guesses are needed"),
    ],
)
def test_bad_questions_are_refused(start, data, options, told):
    with pytest.raises(ValueError, match=told):
        fit(["a"], start, lambda p, k: p[0] * TIME[:k], data, **options)
