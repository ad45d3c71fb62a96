"""A few point masses with the same moments as a distribution of mass.

The mass of a floating-frame link enters its motion only by the integrals of Boyer & Primault 2005,
(3.31), (3.33): those of products of two of the functions 1, X, Φ₁ … Φ_m. A quadrature for the span
of these functions is exact with as many points as there are independent functions besides 1, plus
one point where all functions vanish. If that one point would carry most of the mass, one more point
is used instead; on polynomials this is Gauss quadrature.
"""

import numpy as np

from soft_sim_ros.core.floats import Floats

# Singular values below this share of the largest count as zero (dependent functions). It bounds the
# error of the integrals.
DEPENDENT = 1e-10
# Least share of the mass on the points: with less, they would have to lie far outside of the link.
BORNE = 0.25


def concentrated(functions: Floats, mass: Floats, along: Floats) -> tuple[Floats, Floats]:
    """Return masses (k,) and values (k, r) at k points with the moments of a distribution.

    Σ w f and Σ w f fᵀ equal those of the distribution. The rest of the total mass is to be put
    where all functions vanish.

    Parameters
    ----------
    functions : (N, r) values of functions that vanish somewhere
    mass : (N,) masses ≥ 0 there
    along : (N,) a function that differs between the points, such as the arc length
    """
    root = np.sqrt(mass)
    size = np.sqrt(mass @ functions**2)
    shown = size > 0.0
    if not shown.any():
        return np.zeros(0), np.zeros((0, functions.shape[1]))
    scaled = root[:, None] * functions[:, shown] / size[shown]
    left, stretch, right = np.linalg.svd(scaled, full_matrices=False)
    count = int(np.sum(stretch > DEPENDENT * stretch[0]))
    span, values = left[:, :count], stretch[:count, None] * right[:count]
    share = span.T @ root
    if share @ share < BORNE * mass.sum():
        rest = root - span @ share
        span = np.column_stack([span, rest / np.linalg.norm(rest)])
        values = np.vstack([values, np.zeros(values.shape[1])])
        share = span.T @ root
    # multiplication by ``along`` within the span: its eigenvectors are the points
    _, points = np.linalg.eigh(span.T @ (along[:, None] * span))
    amount = points.T @ share
    out = np.zeros((len(amount), functions.shape[1]))
    out[:, shown] = points.T @ values / amount[:, None] * size[shown]
    return amount**2, out
