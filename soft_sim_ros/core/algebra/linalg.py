"""Dense LU for the Newton systems.

Small enough that a library call would cost more than the arithmetic.
"""

from soft_sim_ros.core.backend.jit import kernel

from .simd import WIDTH, fused, keep_one, one


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
def row_dot(row, b, begin, end):
    """Return Σ row[j] b[j] over begin ≤ j < end, in four interleaved sums for speed."""
    s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
    stop = begin + (end - begin) // 4 * 4
    for j in range(begin, stop, 4):
        s0 += row[j] * b[j]
        s1 += row[j + 1] * b[j + 1]
        s2 += row[j + 2] * b[j + 2]
        s3 += row[j + 3] * b[j + 3]
    for j in range(stop, end):
        s0 += row[j] * b[j]
    return (s0 + s1) + (s2 + s3)


@kernel
def lu_solve(a, pivot, b):
    """Solve in place for b (n,) with the factors of ``lu_factor``."""
    n = a.shape[0]
    for k in range(n):
        row = pivot[k]
        if row != k:
            b[k], b[row] = b[row], b[k]
    for i in range(1, n):
        b[i] -= row_dot(a[i], b, 0, i)
    for i in range(n - 1, -1, -1):
        b[i] = (b[i] - row_dot(a[i], b, i + 1, n)) / a[i, i]


@kernel
def lu_invert(a, pivot, x):
    """Fill x (n, padded n) with the inverse of what ``lu_factor`` factored, padded with zeros."""
    n, width = x.shape
    for i in range(n):
        for c in range(0, width, WIDTH):
            keep_one(x, i, c, 0.0)
        x[i, i] = 1.0
    for k in range(n):
        row = pivot[k]
        if row != k:
            for c in range(0, width, WIDTH):
                upper, lower = one(x, k, c), one(x, row, c)
                keep_one(x, k, c, lower)
                keep_one(x, row, c, upper)
    for i in range(1, n):
        for c in range(0, width, WIDTH):
            total = one(x, i, c)
            for j in range(i):
                total = fused(-a[i, j], one(x, j, c), total)
            keep_one(x, i, c, total)
    for i in range(n - 1, -1, -1):
        scale = 1.0 / a[i, i]
        for c in range(0, width, WIDTH):
            total = one(x, i, c)
            for j in range(i + 1, n):
                total = fused(-a[i, j], one(x, j, c), total)
            keep_one(x, i, c, scale * total)
