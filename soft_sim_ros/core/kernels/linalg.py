"""Dense LU for the Newton systems.

Small enough that a library call would cost more than the arithmetic.
"""

from .jit import kernel


@kernel
def lu_factor(a, pivot):
    """Factor a (n, n) in place with row exchanges; return False if it is singular or not finite."""
    n = a.shape[0]
    for k in range(n):
        best, row = 0.0, k
        for i in range(k, n):
            size = abs(a[i, k])
            if size > best:
                best, row = size, i
        if not (best > 0.0 and best < 1e300):
            return False
        pivot[k] = row
        if row != k:
            for j in range(n):
                a[k, j], a[row, j] = a[row, j], a[k, j]
        scale = 1.0 / a[k, k]
        for i in range(k + 1, n):
            factor = a[i, k] * scale
            a[i, k] = factor
            if factor != 0.0:
                for j in range(k + 1, n):
                    a[i, j] -= factor * a[k, j]
    return True


@kernel
def lu_solve(a, pivot, b):
    """Solve in place for b (n,) with the factors of ``lu_factor``."""
    n = a.shape[0]
    for k in range(n):
        row = pivot[k]
        if row != k:
            b[k], b[row] = b[row], b[k]
    for i in range(1, n):
        total = b[i]
        for j in range(i):
            total -= a[i, j] * b[j]
        b[i] = total
    for i in range(n - 1, -1, -1):
        total = b[i]
        for j in range(i + 1, n):
            total -= a[i, j] * b[j]
        b[i] = total / a[i, i]
