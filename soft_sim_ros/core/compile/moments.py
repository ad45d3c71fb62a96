"""Few masses that have the moments of many.

What the motion of a floating-frame link sees of its mass are the integrals of B (3.31), (3.33):
those of products of two functions out of 1, X, Φ₁ … Φ_m. A quadrature made for the span of these
functions has them exactly, with as many points as there are independent functions besides 1, and
one where all functions vanish; or, if that one would have to bear most of the mass, with one point
more. On polynomials the latter is the rule of Gauss.
"""

import numpy as np

from soft_sim_ros.core.floats import Floats

# Share of the largest singular value below which functions count as dependent: so good are the
# integrals.
DEPENDENT = 1e-10
# Share of the mass that the points must bear: else they would have to lie far out.
BORNE = 0.25


def concentrated(functions: Floats, mass: Floats, along: Floats) -> tuple[Floats, Floats]:
    """Return masses (k,) and values (k, r) at k points with the moments of a distribution.

    Σ w f and Σ w f fᵀ are those of the distribution. What the masses lack of its total is to be put
    where all functions vanish.

    Parameters
    ----------
    functions : (N, r) values of functions that vanish somewhere
    mass : (N,) masses ≥ 0 there
    along : (N,) a function by which the points are told apart, such as the arc length
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
