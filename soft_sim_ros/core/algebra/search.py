"""Where in a table a number lies."""

from soft_sim_ros.core.backend.jit import kernel


@kernel
def row_of(table, first, last, x):
    """Return the last of rows ``first`` … ``last`` − 1 that begins at or before x, or ``first``."""
    while last - first > 1:
        middle = (first + last) // 2
        if table[middle, 0] <= x:
            first = middle
        else:
            last = middle
    return first
