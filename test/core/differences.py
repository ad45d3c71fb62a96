"""Derivatives by difference quotients, for tests of those that are derived."""

import numpy as np


def central_difference(function, x, size):
    """Fourth-order difference quotient of function along every coordinate of x."""
    columns = []
    for j in range(len(x)):
        e = np.zeros(len(x))
        e[j] = size[j]
        slope = 8.0 * (function(x + e) - function(x - e)) - (
            function(x + 2 * e) - function(x - 2 * e)
        )
        columns.append(slope / (12.0 * size[j]))
    return np.stack(columns, axis=1)
