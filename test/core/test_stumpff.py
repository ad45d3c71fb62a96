"""The functions behind every rotation, and their derivatives, to round-off at every angle."""

import math

import numpy as np
import pytest

from soft_sim_ros.core.algebra import rotation
from soft_sim_ros.core.algebra.simd import one
from soft_sim_ros.core.backend.jit import unit

ANGLES = np.concatenate([[0.0], np.logspace(-9, 1.2, 200), [math.pi, 2 * math.pi, 1.9999, 2.0001]])


# Algebra is inlined and cannot be called from Python.
stumpff = unit(lambda x: rotation.stumpff(x))
first = unit(lambda k, c: rotation.first(k, c))
second = unit(lambda k, c: rotation.second(k, c))
third = unit(lambda k, c: rotation.third(k, c))


def series(k, x, derivative=0, terms=60):
    """Sum of the defining series with exact rational weights, in extended precision."""
    total = np.longdouble(0)
    for j in range(terms - 1, derivative - 1, -1):
        weight = np.longdouble(1)
        for i in range(derivative):
            weight *= j - i
        power = np.longdouble(x) ** (j - derivative)
        total += (-1) ** j * weight * power / np.longdouble(math.factorial(2 * j + k))
    return total


@pytest.mark.parametrize("k", range(10))
def test_values_match_the_series(k):
    for angle in ANGLES:
        expected = float(series(k, angle**2))
        # beyond a turn the alternating series itself cancels: measured against its first term
        assert stumpff(angle**2)[k] == pytest.approx(expected, abs=2e-12 / math.factorial(k))


@pytest.mark.parametrize("k", [1, 2, 3])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_match_the_series(k, order):
    function = (first, second, third)[order - 1]
    for angle in ANGLES[ANGLES < 7]:
        expected = float(series(k, angle**2, order))
        assert function(k, stumpff(angle**2)) == pytest.approx(expected, abs=1e-11)


@unit
def four_at_once(x, out):
    """Fill out (1, 40) with the functions of x (1, 4)."""
    rotation.stumpff_lanes(one(x, 0, 0), out, 0)


@pytest.mark.parametrize("largest", [0.0, 9e-4, 1.1e-3, 0.09, 0.11, 0.9, 1.1, 5.0, 9.9, 10.1, 40.0])
def test_four_at_once_match_the_series(largest):
    """On both sides of every change of the way they are computed, and whatever the neighbours."""
    x = largest * np.array([[1.0, 0.3, 0.0, 0.999]])
    out = np.empty((1, 40))
    four_at_once(x, out)
    for i in range(4):
        expected = np.array([float(series(k, x[0, i])) for k in range(10)])
        bound = np.array([1.0 / math.factorial(k) for k in range(10)])
        if largest < 10.0:
            assert (np.abs(out[0, i::4] - expected) <= 2e-16 * (1.0 + x[0, i]) * bound).all()
        else:
            assert np.array_equal(out[0, i::4], stumpff(x[0, i]))
