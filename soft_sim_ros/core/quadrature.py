"""Quadrature rules on [0, 1]."""

from collections.abc import Sequence

import numpy as np
from numpy.polynomial import Legendre
from numpy.polynomial.legendre import leggauss, legvander

from .floats import Floats


def gauss(count: int) -> tuple[Floats, Floats]:
    """Return points and weights of the Gauss–Legendre rule, exact to degree 2 count − 1."""
    x, w = leggauss(count)
    return 0.5 * (1.0 + x), 0.5 * w


def lobatto(count: int) -> tuple[Floats, Floats]:
    """Return points and weights of the Gauss–Lobatto rule, exact to degree 2 count − 3."""
    if count < 2:
        raise ValueError(f"a Gauss–Lobatto rule has at least 2 points, not {count}")
    p = Legendre.basis(count - 1)
    x = np.concatenate([[-1.0], np.sort(p.deriv().roots().real), [1.0]])
    # one Newton step on P' polishes the companion-matrix roots to round-off
    inner = x[1:-1]
    x[1:-1] = inner - p.deriv(1)(inner) / p.deriv(2)(inner)
    x = 0.5 * (x - x[::-1])
    w = 2.0 / (count * (count - 1) * p(x) ** 2)
    return 0.5 * (1.0 + x), 0.5 * w


def antiderivative(x: Floats) -> Floats:
    """Return the matrix (N, N) from values at x (N,) to ∫₀^x of the polynomial through them."""
    # Legendre polynomials in 2x − 1 keep the matrix well conditioned at any number of points
    t, count = 2.0 * x - 1.0, len(x)
    values = legvander(t, count - 1)
    integrals = [0.5 * Legendre.basis(j).integ(lbnd=-1.0)(t) for j in range(count)]
    return np.linalg.solve(values.T, np.array(integrals)).T


def derivative(x: Floats) -> Floats:
    """Return the matrix (N, N) from values at x (N,) to slopes of the polynomial through them."""
    t, count = 2.0 * x - 1.0, len(x)
    slopes = [2.0 * Legendre.basis(j).deriv()(t) for j in range(count)]
    return np.linalg.solve(legvander(t, count - 1).T, np.array(slopes)).T


def scattered(begin: float, end: float, count: int = 101) -> Floats:
    """Return unevenly spaced, ascending points (count,) from begin to end, both included.

    They sample an unknown function. Evenly spaced points may all be zeros of a wave; these are
    fractional parts of multiples of the golden ratio, stretched to one side, which avoids that.
    """
    even = np.sort(np.arange(1, count - 1) * (0.5 * (np.sqrt(5.0) - 1.0)) % 1.0)
    inner = 0.8 * even + 0.2 * even**2
    return np.concatenate([[begin], begin + (end - begin) * inner, [end]])


def composite(rule: tuple[Floats, Floats], marks: Sequence[float]) -> tuple[Floats, Floats]:
    """Return points and weights of a rule repeated between neighbours of rising marks (N + 1,)."""
    x, w = rule
    begin, step = np.asarray(marks)[:-1, None], np.diff(marks)[:, None]
    return (begin + step * x).ravel(), (step * w).ravel()
