"""The functions behind every rotation, and their derivatives, to round-off at every angle."""

import math

import numpy as np
import pytest

from soft_sim_ros.core.kernels import rotation
from soft_sim_ros.core.kernels.jit import unit

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
